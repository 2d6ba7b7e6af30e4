"""The commands of this page, run as they are typed, and their output."""

import contextlib
import io
import json
import tempfile
from pathlib import Path

import numpy as np

from chapters.guides.fisheye_in_ten_minutes.trials.boards import places_of, rig_of
from chapters.shared.facade import T_world_camera
from raxel.calibration.views.boards import board_views
from raxel.cameras import load_camera
from raxel.cli import main
from raxel.evaluation import evaluate_camera
from raxel.features.boards import read_boards
from raxel.lab import facade
from raxel.multiview.perspective_view import perspective_view, source_pixels
from raxel.sets import ImageSet, View, load_set
from raxel.sets.image_set import write_set

SET = "fisheye"
CHECK = ("check", SET)
CORNERS = ("corners", SET, "--json", "corners.json")
CALIBRATE = (
    "calibrate", SET, "--model", "generic", "--corners", "corners.json",
    "--out", "camera.npz", "--json", "fit.json",
)  # fmt: skip
EVALUATE = (
    "evaluate", "camera.npz", SET, "--corners", "corners.json",
    "--json", "kept_out.json",
)  # fmt: skip
UNDISTORT = ("undistort", "camera.npz", SET, "--out", "straight")
FILES = {"corners": "corners.json", "camera": "camera.npz"}


@contextlib.contextmanager
def desk(size, pictures, **files):
    """Provide a working directory with the set in it.

    files: result of a trial that keeps the bytes of a file under this name.
    """
    with tempfile.TemporaryDirectory() as room:
        write_pictures(size, pictures, Path(room) / SET)
        for name, result in files.items():
            path = Path(room) / FILES[name]
            path.write_bytes(result.arrays(name)[0].tobytes())
        with contextlib.chdir(room):
            yield


def write_pictures(size, pictures, folder):
    """Write the images as files, with the set.yaml that a user writes."""
    folder.mkdir()
    rig, views = rig_of(size), []
    for condition in pictures.conditions:
        index = condition["view"]
        name = f"{index + 1:02d}.png"
        png = pictures.arrays("png", view=index)[0]
        (folder / name).write_bytes(png.tobytes())
        fits = index < len(places_of(size.plan))
        use = "calibrate" if fits else "evaluate"
        views.append(View(image=name, use=use))
    write_set(
        ImageSet(
            name=SET,
            width=rig.camera.width,
            height=rig.camera.height,
            target=rig.target,
            views=tuple(views),
            folder=folder,
            camera="fisheye converter, 183 degrees",
        )
    )


def typed(arguments):
    """Run one command of raxel; return its output."""
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        status = main(list(arguments))
    if status:
        raise RuntimeError(f"raxel {' '.join(arguments)}: status {status}")
    return out.getvalue()


def find_corners(size, pictures):
    """Run `raxel check` and `raxel corners`; return output, corners and counts."""
    with desk(size, pictures):
        said = {"check": typed(CHECK), "corners": typed(CORNERS)}
        boards = read_boards("corners.json", load_set(SET))
        content = json.loads(Path("corners.json").read_text("utf-8"))
    for entry in content["images"]:
        entry["milliseconds"] = None  # a result holds no times
    return {
        "said": said,
        "boards": len(boards),
        "found": sum(board.detection.found for board in boards),
        "corners": np.frombuffer(json.dumps(content).encode(), np.uint8),
    }


def views_of(size, pictures, found):
    """Return the views to calibrate with and the held-out ones."""
    with desk(size, pictures, corners=found):
        image_set = load_set(SET)
        boards = read_boards("corners.json", image_set)
    return tuple(
        board_views(image_set, [b for b in boards if b.view.use == use])
        for use in ("calibrate", "evaluate")
    )


def calibrate(size, pictures, found):
    """Run `raxel calibrate` and `raxel evaluate`; return camera and residuals."""
    fit_views, kept_out = views_of(size, pictures, found)
    with desk(size, pictures, corners=found):
        said = {"calibrate": typed(CALIBRATE), "evaluate": typed(EVALUATE)}
        file = Path("camera.npz").read_bytes()
        camera = load_camera("camera.npz")
    return {
        "said": said,
        "camera": np.frombuffer(file, np.uint8),
        "ray_share": float(camera.mask.mean()),
        "fitted_px": evaluate_camera(camera, fit_views).rms_px,
        "kept_out_px": evaluate_camera(camera, kept_out).rms_px,
    }


def look_through(size, pictures, calibrated, rng):
    """Run `raxel undistort`; return it with a street through the same pinhole."""
    import cv2

    street = rig_of(size).laboratory().photograph(facade(), T_world_camera(), rng)
    with desk(size, pictures, camera=calibrated):
        said = {"undistort": typed(UNDISTORT)}
        camera = load_camera("camera.npz")
    sources = source_pixels(camera, perspective_view(camera))
    ahead = cv2.remap(street, *cv2.split(sources), cv2.INTER_LINEAR)
    return {"said": said, "street": street, "ahead": ahead}
