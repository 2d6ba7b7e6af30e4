"""Corners that other programs detected, in the form of `raxel corners --json`.

mrgingham and mrcal write text files (.vnl) with lines `filename x y level`, OpenCV
writes object points and image points by cv2.FileStorage (.xml, .yml, .yaml). In all
of them the centre of the first pixel is (0, 0).
"""

from pathlib import Path

import numpy as np

from raxel.errors import InputError
from raxel.io.files import check_file, read_json, read_text
from raxel.sets.model import Chessboard, ImageSet, View

MAX_BYTES = 200_000_000
STORAGE_ENDINGS = (".xml", ".yml", ".yaml")


def corner_data(path, image_set):
    """The content of a file of corners: {images: [{file, found, columns, ...}]}.

    Raises InputError for files that cannot be read.
    """
    ending = Path(path).suffix.lower()
    if ending == ".vnl":
        return {"images": list(_vnl_entries(path, image_set))}
    if ending in STORAGE_ENDINGS:
        return {"images": _storage_entries(path, image_set.views)}
    return read_json(path)


def _vnl_entries(path, image_set):
    """Entries of a .vnl file: rows of corners from the first of each image."""
    labels = {Path(view.label).name: view.label for view in image_set.views}
    found = {}
    for number, line in enumerate(read_text(path, MAX_BYTES).splitlines(), 1):
        name, *values = line.split("#")[0].split() or [""]
        if not name:
            continue
        try:
            # A level below 0 or missing marks a point that is not used.
            good = "-" not in values[:3] and not (values[2:] and float(values[2]) < 0)
            point = [float(values[0]), float(values[1])] if good else None
        except (ValueError, IndexError) as fault:
            raise InputError(
                f"{path}: line {number}: not 'filename x y level'; write the file again"
            ) from fault
        name = Path(name).name
        found.setdefault(labels.get(name, name), []).append(point)
    target = image_set.target
    size = {"columns": target.columns, "rows": target.rows}
    for name, corners in found.items():
        entry = {"file": name, "found": any(corners), "reason": f"no corners in {path}"}
        yield entry | size | {"corners": corners}


def _storage_entries(path, views):
    pixels, points, _ = read_storage(path)
    if len(pixels) != len(views):
        raise InputError(
            f"{path}: image points of {len(pixels)} images, but the set has "
            f"{len(views)} views; list the same images in the same order"
        )
    entries = []
    for view, own, board in zip(views, pixels, points, strict=True):
        columns, rows, _, order = _lattice(path, board)
        entry = {"file": view.label, "found": True, "columns": columns, "rows": rows}
        entries.append(entry | {"corners": own[order].tolist()})
    return entries


def corner_set(path):
    """The ImageSet without images of a FileStorage with points and the image size.

    Views are named view1, view2, ... Lengths are in the unit of the object points.
    Raises InputError for other files.
    """
    pixels, points, size = read_storage(path)
    if size is None:
        raise InputError(
            f"{path}: image_size is missing; add it, or give a set with --corners"
        )
    columns, rows, pitch, _ = _lattice(path, points[0])
    views = tuple(View(image=f"view{k}") for k in range(1, len(pixels) + 1))
    target = Chessboard(columns, rows, pitch)
    return ImageSet(Path(path).stem, *size, target, views, Path(path).parent)


def read_storage(path):
    """Image points [(N, 2)] px, object points [(N, 2)] and image size of a FileStorage.

    The names are image_points, object_points and image_size, or imagePoints, ... The
    size (width, height) is None where the file has none.
    """
    import cv2

    check_file(path, MAX_BYTES)
    try:
        storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
        nodes = [
            next((n for n in map(storage.getNode, names) if not n.empty()), None)
            for names in (
                ("image_points", "imagePoints"),
                ("object_points", "objectPoints"),
                ("image_size", "imageSize"),
            )
        ]
        images, objects = (
            [one.at(k).mat() for k in range(one.size())] for one in nodes[:2]
        )
        pixels = [np.reshape(one, (-1, 2)).astype(float) for one in images]
        points = [np.reshape(one, (-1, 3))[:, :2].astype(float) for one in objects]
        if [len(one) for one in pixels] != [len(one) for one in points]:
            raise ValueError("numbers of image and object points differ")
        size = nodes[2] and tuple(int(nodes[2].at(k).real()) for k in range(2))
    except (cv2.error, AttributeError, TypeError, ValueError) as fault:
        raise InputError(
            f"{path}: no image_points and object_points of OpenCV; give a file of "
            "cv2.FileStorage with both, one matrix per image"
        ) from fault
    return pixels, points, size


def _lattice(path, points):
    """Columns, rows, pitch and order of object points (N, 2), row by row."""
    x, y = np.unique(points[:, 0].round(6)), np.unique(points[:, 1].round(6))
    order = np.lexsort(points.T.round(6))
    if len(points) != len(x) * len(y) or len(points) < 4:
        raise InputError(
            f"{path}: object_points: not a lattice; give all corners of a board for "
            "each image"
        )
    return len(x), len(y), float(x[1] - x[0]), order
