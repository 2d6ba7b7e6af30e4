"""All active grids of an image set: decoded, written to a folder, read back."""

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np

from raxel.errors import InputError
from raxel.features.active_grid.view import check_active_grid, decode_view
from raxel.io.archives import Archive
from raxel.io.documents import shown
from raxel.io.files import read_json
from raxel.io.stored import StoredArray
from raxel.sets.model import View

SUMMARY = "decoded.json"
MAX_LENGTH = 1e6  # mm or px, of points and their deviations


class DecodedGrid(NamedTuple):
    """The decoded points of one view: location, sigma and mask, as `decode` returns
    them, the first two as StoredArrays.

    All None where the view was rejected, for `reason`. Read from a file, sigma and mask
    may be None. warnings: lines on problems of the view.
    """

    view: View
    location: StoredArray | None = None
    sigma: StoredArray | None = None
    mask: np.ndarray | None = None
    reason: str = ""
    warnings: tuple[str, ...] = ()


def decode_grids(image_set, views, say=None):
    """Yield a DecodedGrid for each view; say: called with one line per view.

    A view with inconsistent images is rejected, with that reason. Raises InputError as
    `raxel.features.active_grid.view.decode_view` does.
    """
    check_active_grid(image_set)
    for number, view in enumerate(views, 1):
        found, reason, warnings, *_ = decode_view(image_set, view)
        if say:
            share = 0.0 if reason else 100 * np.mean(found.mask)
            say(f"{number}/{len(views)} {view.label}: {share:.1f} % of the pixels")
        grid = DecodedGrid(view, reason=reason)
        if not reason:
            arrays = *map(StoredArray, (found.location, found.sigma)), found.mask
            grid = DecodedGrid(view, *arrays, warnings=warnings)
        del found  # memory for the next one
        yield grid


def write_points(path, decoded):
    """Write a Decoded as .npz: points_mm (or points_px), sigma alike, mask, status."""
    np.savez_compressed(
        path,
        **{
            f"points_{decoded.unit}": decoded.location,
            f"sigma_{decoded.unit}": decoded.sigma,
        },
        mask=decoded.mask,
        status=decoded.status,
    )


def read_grids(folder, image_set, views=None):
    """Yield a DecodedGrid for each view from the files that `raxel decode` wrote.

    A view without a file counts as not decoded, with that reason. Raises InputError for
    files that are not a decoded view of this set.
    """
    check_active_grid(image_set)
    folder = Path(folder)
    if not folder.is_dir():
        raise InputError(f"{folder}: no such folder; give one written by raxel decode")
    summary = folder / SUMMARY
    if summary.exists():
        data = read_json(summary)
        name = data.get("set") if isinstance(data, dict) else None
        if name != image_set.name:
            raise InputError(
                f"{summary}: set: found {shown(name)}, expected "
                f"{image_set.name!r}; give the points of this set"
            )
    unit = "mm" if image_set.target.monitor_mm else "px"
    shape = image_set.height, image_set.width, 2
    for view in image_set.views if views is None else views:
        path = folder / f"{view.label}.npz"
        if path.exists():
            yield _read(path, view, unit, shape)
        else:
            yield DecodedGrid(view, reason=f"{folder} has no file for it")


def has_points(path):
    """Whether an .npz file is a decoded view. Raises InputError for other files."""
    with Archive(path, "camera file or file of points") as archive:
        return archive.has("points_mm") or archive.has("points_px")


def read_grid(path, shape):
    """Read (location, sigma, mask) from such a file; shape: (height, width, 2).

    sigma and mask are None where the file has none.
    """
    with Archive(path, "file of points") as archive:
        unit = "mm" if archive.has("points_mm") else "px"
    _, location, sigma, mask, *_ = _read(path, None, unit, shape)
    return location[:], sigma and sigma[:], mask


def _read(path, view, unit, shape):
    with Archive(path, "file of points") as archive:
        points = _lengths(path, archive, f"points_{unit}", shape)
        sigma = mask = None
        if archive.has(f"sigma_{unit}"):
            sigma = _lengths(path, archive, f"sigma_{unit}", shape)
        if archive.has("mask"):
            mask = _array(path, archive, "mask", shape[:2], "b", "truth values")
    return DecodedGrid(view, points, sigma, mask)


def _lengths(path, archive, name, shape):
    """Numbers that may be lengths on a monitor, as a StoredArray."""
    values = _array(path, archive, name, shape, "iuf", "numbers")
    kind = np.result_type(values, np.float32)  # halves end below
    values = values.astype(kind, copy=False)
    beyond = (values > MAX_LENGTH) | (values < -MAX_LENGTH)  # NaN is not
    if beyond.any():
        raise InputError(
            f"{path}: {name}: found {values[beyond][0]:g}, more than any monitor; "
            "decode the view again"
        )
    return StoredArray(values)


def _array(path, archive, name, shape, kinds, what):
    found = archive.shape(name)
    if found != shape:
        raise InputError(f"{path}: {name}: found shape {found}; give {shape}")
    values = archive.array(name, math.prod(shape))
    if values.dtype.kind not in kinds:
        raise InputError(f"{path}: {name}: found {values.dtype}; give {what}")
    return values
