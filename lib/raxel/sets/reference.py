"""Reference corners of a set (corners.json), for scoring only."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from raxel.errors import InputError
from raxel.io.documents import one_line
from raxel.io.files import read_json
from raxel.sets.model import ImageSet, sd_from_plain


@dataclass(frozen=True, eq=False)
class ReferenceCorners:
    """Hold the corners of one image, row by row; any board corner may be the first.

    Attributes
    ----------
    corners : ndarray, shape (rows * columns, 2)
        Corners, px; NaN where missing.
    certain : ndarray of bool, shape (rows * columns,)
        Whether a corner is certain.
    columns, rows : int
        Number of interior corners along each direction.
    tolerance_px : float
        Largest distance, px, at which a detected corner is correct.
    sd : ndarray, shape (rows * columns,), or None
        Standard deviations, px, by the rule of `raxel.sets.model`; None where the file
        states none.
    """

    corners: np.ndarray
    certain: np.ndarray
    columns: int
    rows: int
    tolerance_px: float
    sd: np.ndarray | None = None


def load_reference(image_set: ImageSet) -> dict[str, ReferenceCorners]:
    """Return the reference corners of a set.

    Parameters
    ----------
    image_set : ImageSet
        The set.

    Returns
    -------
    dict of str to ReferenceCorners
        Corners by name of the image; empty if the set names none.

    Raises
    ------
    InputError
        If the file does not fit its own counts, has invalid numbers, lacks keys, or
        gives no certain corner of an image.
    """
    if image_set.reference is None:
        return {}
    path = image_set.folder / image_set.reference
    data = read_json(path)
    columns, rows = (_count(path, data, key) for key in ("columns", "rows"))
    images = _mapping(path, data, "images")
    return {
        name: _one(path, f"images.{one_line(name)}", entry, columns, rows)
        for name, entry in images.items()
    }


def _one(path, field, entry, columns, rows):
    if not isinstance(entry, dict) or "corners" not in entry:
        raise InputError(f"{path}: {field}.corners: key missing; add the corners")
    corners = _points(path, f"{field}.corners", entry["corners"], columns * rows)
    certain = np.isfinite(corners).all(axis=1)
    for key in ("uncertain", "missing"):
        indices = entry.get(key, [])
        _check_indices(path, f"{field}.{key}", indices, len(corners))
        certain[indices] = False
    if not certain.any():
        raise InputError(
            f"{path}: {field}.corners: no certain corner; give one or more, or remove "
            "the image"
        )
    spread = _spread(path, f"{field}.spread_max_px", entry.get("spread_max_px"))
    tolerance = 2 * spread if 0.5 <= spread <= 1 else 1.0
    sd = sd_from_plain(f"{path}: {field}.sd", entry.get("sd"), len(corners))
    return ReferenceCorners(corners, certain, columns, rows, tolerance, sd)


def _points(path, field, points, count):
    if not isinstance(points, list) or len(points) != count:
        found = f"{len(points)} corners" if isinstance(points, list) else "not a list"
        raise InputError(f"{path}: {field}: {found}; give columns x rows = {count}")
    array = np.full((count, 2), np.nan)
    for index, point in enumerate(points):
        if point is None or point == [None, None]:
            continue
        if not isinstance(point, list) or len(point) != 2 or not all(map(_real, point)):
            raise InputError(
                f"{path}: {field}[{index}]: not a point; give [x, y] or null"
            )
        array[index] = point
    return array


def _check_indices(path, field, indices, count):
    good = isinstance(indices, list) and all(
        isinstance(i, int) and not isinstance(i, bool) and 0 <= i < count
        for i in indices
    )
    if not good:
        raise InputError(
            f"{path}: {field}: not a list of indices; give indices of corners, 0 to "
            f"{count - 1}"
        )


def _spread(path, field, spread):
    if spread is None:
        return 0.0
    if not _real(spread):
        raise InputError(f"{path}: {field}: not a number; give the spread in px")
    return float(spread)


def _count(path, data, key):
    value = data.get(key) if isinstance(data, dict) else None
    if not isinstance(value, int) or isinstance(value, bool) or not 3 <= value <= 1000:
        raise InputError(
            f"{path}: {key}: missing or invalid; give the number of interior corners, "
            "3 to 1000"
        )
    return value


def _mapping(path, data, key):
    value = data.get(key)
    if not isinstance(value, dict):
        raise InputError(
            f"{path}: {key}: missing or not a mapping; give corners by image name"
        )
    return value


def _real(value):
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return number and abs(value) < 1e9
