"""`raxel undistort camera.npz SET --out FOLDER`"""

import os
import tempfile
from collections import Counter
from pathlib import Path, PurePath

from raxel.cameras.io import load_camera
from raxel.cli.evaluate import check_size
from raxel.errors import InputError
from raxel.files import check_can_be_written
from raxel.multiview.perspective_view import (
    perspective_view,
    resample,
    share_seen,
    source_pixels,
)
from raxel.sets import load_set, read_colour

LEAST_SHARE = 0.5  # of the pixels: below it, the picture is mostly black


def undistort(options, say):
    """Write every image of the set as a pinhole at the camera's centre would see it."""
    out = Path(options.out)
    image_set = load_set(options.set)
    _check_folder(out, image_set)
    camera = load_camera(options.camera)
    check_size(options.camera, camera, image_set)
    try:
        view = perspective_view(camera)
    except InputError as fault:
        raise InputError(f"{options.camera}: {fault}") from fault
    sources = source_pixels(camera, view)
    share = share_seen(sources, camera)
    files = [name for view in image_set.views for name in view.files]
    with tempfile.TemporaryDirectory(dir=out.parent, prefix=f".{out.name}-") as folder:
        for number, (name, target) in enumerate(_targets(files).items(), 1):
            image = resample(read_colour(image_set, name), sources)
            _write_png(Path(folder) / target, image)
            say(f"{number}/{len(files)} {name}")
        _move(Path(folder), out)
    print(
        f"{image_set.name}: {len(files)} images in {out}; the camera sees "
        f"{100 * share:.0f} % of their pixels"
    )
    if share < LEAST_SHARE:
        print(
            "the rest is black: a pinhole's picture cannot hold what this camera sees, "
            "or the boards covered little of the image; a camera that looks all around "
            "is unrolled by raxel.multiview.cylindrical_view"
        )


def _check_folder(out, image_set):
    if out.is_dir():
        if out.resolve() == image_set.folder.resolve():
            raise InputError(f"{out}: this is the set itself; choose another folder")
        check_can_be_written(out / "image.png")
    else:
        check_can_be_written(out)


def _targets(files):
    """The PNG file for each image, with the whole old name where two would coincide."""
    files = dict.fromkeys(files)
    stems = Counter(PurePath(name).with_suffix("") for name in files)
    return {
        name: f"{name}.png"
        if stems[PurePath(name).with_suffix("")] > 1
        else f"{PurePath(name).with_suffix('.png')}"
        for name in files
    }


def _write_png(path, image):
    import cv2

    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(cv2.imencode(".png", image)[1].tobytes())


def _move(folder, out):
    """All images are whole: now they take their places."""
    out.mkdir(exist_ok=True)
    for path in sorted(folder.rglob("*.png")):
        target = out / path.relative_to(folder)
        target.parent.mkdir(parents=True, exist_ok=True)
        os.replace(path, target)
