"""`make test-formats`: readers in environments of their own, and the table of formats.

cv2.omnidir and mrcal do not fit into the project's environment. Exact exports must have
the rays of the camera there, too. Then each camera is exported to each format, and the
residuals are written to lib/raxel/formats/TABLE.md.
"""

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from raxel.errors import InputError
from raxel.formats import export_camera
from raxel.formats.conventions import FORMATS
from tests.camera_zoo import ZOO
from tests.format_cameras import CAMERAS, EXACT, SKEWED
from tests.format_readers import exported
from tests.lab_cameras import EVERY

ROOT = Path(__file__).resolve().parents[1]
TABLE = ROOT / "lib/raxel/formats/TABLE.md"
PACKAGES = {
    "opencv-omnidir": ["opencv-contrib-python-headless==5.0.0.93", "numpy", "PyYAML"],
    "mrcal": ["mrcal==2.5.2.post1", "numpy", "numpysane==0.45", "packaging", "PyYAML"],
}
HEAD = """# Cameras and formats

Written by `make test-formats`. *exact*: the model of the format equals that of the
camera, and its rays agree to 1e-6 px in the code of the reader, or in the formula of
the source for Kalibr, Basalt, nerfstudio and (to 1e-3 px) OCamCalib. Largest errors in
{readers}. Otherwise the richest
model of the format is refitted to the rays of the whole image: RMS and largest
residual in px, and the share of the rays within the model's field of view if it is not
all. The numbers are those of one camera of each kind, of wide angle; other cameras have
others, which `raxel export` reports. *cannot*: the rays do not meet in one point, which
no model of the formats holds; `--format table` holds the rays of every camera, and
`--format maps` a perspective view of every central one. A camera whose entrance pupil
moves is exported for far points. Models of the image plane end at 90 degrees from the
axis, as do fisheye models in the code of OpenCV, ROS, Kalibr and COLMAP. A K with skew
is refitted, except for `opencv-omnidir`.

| camera | {formats} |
|{rules}|
"""


def environment(name, python):
    """Python of a new environment with the packages of a reader."""
    folder = ROOT / ".cache/formats" / name
    if not (folder / "installed").exists():
        subprocess.run([python, "-m", "venv", "--clear", folder], check=True)
        # The viewers of mrcal do not build everywhere, and a reader needs none.
        pip = [folder / "bin/pip", "install", "--quiet", "--no-deps"]
        subprocess.run([*pip, *PACKAGES[name]], check=True)
        (folder / "installed").touch()
    return folder / "bin/python"


def largest_error(form, python, folder):
    """Largest error of the exact exports, px, by the code of a reader."""
    cases = []
    for number, name in enumerate(EXACT[form]):
        room = folder / form / str(number)
        room.mkdir(parents=True)
        _, path, pixels, d = exported(form, CAMERAS[name], room)
        np.save(f"{path}.npy", d)
        cases.append((path, pixels))
    script = [python, ROOT / "tests/format_readers.py", form, *(p for p, _ in cases)]
    subprocess.run(script, check=True)
    off = [np.load(f"{path}.pixels.npy") - pixels for path, pixels in cases]
    return max(float(np.abs(each).max()) for each in off)


def cell(camera, form, folder):
    try:
        made = export_camera(camera, folder / "camera.yml", form, True)
    except InputError as fault:
        return "cannot" if "one point" in str(fault) else f"error: {fault}"
    if made.exact:
        return "exact"
    rms, largest = next(iter(made.residuals.values()))
    share = f", {100 * made.held:.0f} %" if made.held < 0.995 else ""
    return f"{rms:.2g}, {largest:.2g}{share}"


def rows():
    """A camera of each kind: first those that some format has exactly."""
    exact = {f"{name} ({camera.kind})": camera for name, camera in CAMERAS.items()}
    kinds = {camera.kind for camera in CAMERAS.values()}
    others = {camera.kind: camera for camera, _ in EVERY.values()}
    others = {kind: camera for kind, camera in others.items() if kind not in kinds}
    decentred = {"kannala-brandt, decentred": ZOO["kannala-brandt, decentred"]}
    more = {"equisolid (fisheye)": EVERY["equisolid"][0]}
    return exact | SKEWED | decentred | more | others


def main(mrcal_python):
    if not shutil.which(mrcal_python):
        sys.exit(f"test-formats: no {mrcal_python}; give MRCAL_PYTHON, 3.12 or later")
    errors = {}
    pythons = {"opencv-omnidir": sys.executable, "mrcal": mrcal_python}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for form, python in pythons.items():
            errors[form] = largest_error(form, environment(form, python), folder)
            print(f"{form}: largest error {errors[form]:.2g} px", flush=True)
        lines = [
            f"| {name} | {' | '.join(cell(camera, form, folder) for form in FORMATS)} |"
            for name, camera in rows().items()
        ]
    words = "`cv2.omnidir`: {:.1g} px, in mrcal: {:.1g} px"
    columns, rules = " | ".join(FORMATS), "|".join(["---"] * (len(FORMATS) + 1))
    readers = words.format(*errors.values())
    head = HEAD.format(readers=readers, formats=columns, rules=rules)
    TABLE.write_text(head + "\n".join(lines) + "\n")
    sys.exit(max(errors.values()) > 1e-6)


if __name__ == "__main__":
    main(*sys.argv[1:])
