"""`raxel undistort camera.npz SET --out FOLDER`"""

import os
import struct
import tempfile
import unicodedata
import zlib
from collections import Counter
from itertools import count
from pathlib import Path, PurePath

from raxel.cli.outputs import check_written
from raxel.cli.straight import straightener
from raxel.cli.terminal import on_one_line
from raxel.errors import InputError
from raxel.io.files import check_can_be_written
from raxel.sets import load_set, read_colour

LEAST_SHARE = 0.5  # of the pixels: below it, the picture is mostly black
# A PNG begins with its signature and the chunk IHDR; then comes what made it.
HEADER_BYTES = 33
MADE_BY = b"Software\0raxel undistort"


def undistort(options, say):
    """Write every image of the set as a pinhole at the camera's centre would see it, or
    laid out on the plane of an active grid."""
    out = Path(options.out)
    image_set = load_set(options.set)
    files = list(dict.fromkeys(name for v in image_set.views for name in v.files))
    targets = _targets(files)
    _check_folder(out, image_set)
    _check_places(out, targets, image_set, options.camera)
    straight = straightener(options.camera, image_set)
    disk = out if out.is_dir() else out.parent
    with tempfile.TemporaryDirectory(dir=disk, prefix=".undistort-") as room:
        folder = Path(room) / "images"
        for number, (name, target) in enumerate(zip(files, targets, strict=True), 1):
            image = straight.picture(read_colour(image_set, name))
            _write_png(folder / target, image)
            renamed = target != _plain(name)
            say(f"{number}/{len(files)} {name}{f' as {target}' if renamed else ''}")
        for target in targets:
            (out / target).parent.mkdir(parents=True, exist_ok=True)
            os.replace(folder / target, out / target)
    print(
        f"{image_set.name}: {len(files)} images in {on_one_line(out)}; {straight.sees} "
        f"{100 * straight.share:.0f} % of their pixels"
    )
    if straight.share < LEAST_SHARE:
        print(f"the rest is black: {straight.rest}")


def _check_folder(out, image_set):
    if out.is_dir():
        if out.resolve() == image_set.folder.resolve():
            raise InputError(f"{out}: this is the set itself; choose another folder")
        check_can_be_written(out / "image.png")
    else:
        check_can_be_written(out)


def _check_places(out, targets, image_set, camera):
    """Raise InputError where an image would leave `out`, or take the place of anything
    but its like."""
    paths = [out / target for target in targets]
    check_written(paths, [image_set], [camera])
    for path in paths:
        if not path.parent.resolve().is_relative_to(out.resolve()):
            raise InputError(
                f"{path.parent}: found a link that leads out of {out}; take it away, "
                "or choose another --out"
            )
        folder = next(folder for folder in path.parents if os.path.lexists(folder))
        if not folder.is_dir():
            raise InputError(
                f"{folder}: found no folder, but images go below it; choose another "
                "--out"
            )
        check_can_be_written(folder / "image.png")
        if path.exists() and not _is_ours(path):
            raise InputError(
                f"{path}: found a file that raxel undistort did not write; choose "
                "another --out, or take it away"
            )


def _is_ours(path):
    with path.open("rb") as stream:
        return MADE_BY in stream.read(HEADER_BYTES + 12 + len(MADE_BY))


def _targets(files):
    """A PNG file for each image, each another one also where capitals do not count.

    The image's name with the ending .png; where several images share that, the whole
    old name before it, and a number where that is taken too.
    """
    plain = list(map(_plain, files))
    shared = Counter(map(_alike, plain))
    taken = {_alike(folder) for path in plain for folder in path.parents}
    targets = []
    for name, first in zip(files, plain, strict=True):
        choices = _choices(name, first if shared[_alike(first)] == 1 else None)
        targets.append(next(path for path in choices if _alike(path) not in taken))
        taken.add(_alike(targets[-1]))
    return targets


def _plain(name):
    return PurePath(name).with_suffix(".png")


def _choices(name, first):
    if first is not None:
        yield first
    yield PurePath(f"{name}.png")
    for number in count(2):
        yield PurePath(f"{name}-{number}.png")


def _alike(path):
    """The same for paths that some file systems take for one."""
    return unicodedata.normalize("NFC", str(path).casefold())


def _write_png(path, image):
    import cv2

    path.parent.mkdir(parents=True, exist_ok=True)
    data = cv2.imencode(".png", image)[1].tobytes()
    header, rest = data[:HEADER_BYTES], data[HEADER_BYTES:]
    path.write_bytes(header + _chunk(b"tEXt" + MADE_BY) + rest)


def _chunk(content):
    """A chunk of a PNG from its kind and data: length and check sum around them."""
    length, checksum = len(content) - 4, zlib.crc32(content)
    return struct.pack(">I", length) + content + struct.pack(">I", checksum)
