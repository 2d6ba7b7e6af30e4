"""A view of an image set, from its files to what each pixel sees."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from raxel.errors import InputError
from raxel.features.active_grid.checks.doubts import clipped_at, examine
from raxel.features.active_grid.checks.levels import mended_levels
from raxel.features.active_grid.checks.passing import NOTHING, passing, passing_warnings
from raxel.features.active_grid.coding import read_coding
from raxel.features.active_grid.decode import Decoded, decode
from raxel.features.active_grid.layout import PASSED
from raxel.features.active_grid.response import response_warnings
from raxel.features.active_grid.specks import without_specks
from raxel.geometry.pixel_cells import as_in_a_mirror
from raxel.sets import ActiveGrid, read_colour
from raxel.sets.image_files import is_jpeg

LEVELS = "white", "black"


class DecodedView(NamedTuple):
    """What was decoded, and what to know of it.

    reason: why nothing of it can be used, empty where it can; warnings: lines on what
    it suffers from; picture: (H, W) uint8 or uint16, what the camera saw, with the
    pattern white where there is one; as_in_a_mirror: whether the grid is seen as in a
    mirror, None where that cannot be told; step_errors: (along x, along y), what sigma
    has been widened by, as the steps of the sines do not agree; noise_factors: alike,
    what it was multiplied by before, as neighbours share their noise.
    """

    decoded: Decoded
    reason: str
    warnings: tuple[str, ...]
    picture: np.ndarray
    as_in_a_mirror: bool | None
    step_errors: tuple[float, float]
    noise_factors: tuple[float, float]


def check_active_grid(image_set):
    """Raise InputError unless the target of the set is an active grid."""
    if not isinstance(image_set.target, ActiveGrid):
        raise InputError(
            f"{image_set.description}: target.kind: found no active_grid; chessboards "
            "are for raxel corners"
        )


def decode_view(image_set, view, **options):
    """Read and decode the pictures of one view of a set; options as of `decode`.

    Colour is made grey; a pixel of which one colour is clipped counts as clipped.
    Where nothing could be decoded, or the pictures contradict each other so that what
    was decoded is wrong, the result's `reason` says so. Raises InputError, naming set,
    view and file, where a picture cannot be read or does not fit the others.
    """
    check_active_grid(image_set)
    where = f"{image_set.description}: views: {view.label}"
    images = np.array(_pictures(image_set, view))
    levels = dict(zip(_levels(view), images[len(view.patterns) :], strict=True))
    images = images[: len(view.patterns)]
    shown = view.patterns, image_set.target
    try:
        found, told, passed = decode_checked(images, *shown, **levels, **options)
    except InputError as fault:
        raise InputError(f"{where}: {fault}") from fault
    found, specks = without_specks(found)
    found = replace(found, sigma=told.widened(found.sigma))
    doubts = told.doubts
    reason = next((doubt.text for doubt in doubts if doubt.spoils), "")
    if not reason and not found.mask.any():
        reasons = (f"{n} {why}" for why, n in found.counts().items() if n)
        reason = f"no pixel could be decoded ({', '.join(reasons)})"
    warnings = [d.text for d in doubts if not d.spoils]
    if found.blur_px is None and options.get("margin_px") is None:
        warnings.append(
            f"its blur cannot be measured; the margin of {found.margin_px} px is right "
            "for blur of 1 px or less: give more with --margin where it is larger"
        )
    warnings += passed
    if specks:
        warnings.append(
            f"{100 * specks:.0f} % of what was decoded were specks beside the lit area "
            "and are left out: noise is larger in the dark than it seems, and standard "
            f"deviations do not know of it; {_what_hides_noise(image_set, view)}"
        )
    warnings += response_warnings(found, options.get("linear"))
    warnings = tuple(f"{view.label}: {text}" for text in warnings)
    picture = levels.get("white", images[0])
    mirrored = as_in_a_mirror(found.location)
    errors, factors = (tuple(map(float, x)) for x in (told.errors, told.factors))
    return DecodedView(found, reason, warnings, picture, mirrored, errors, factors)


def decode_checked(images, patterns, monitor, *, smooth=True, linear=False, **options):
    """Decoded, what its pictures say against themselves, as Examined, and lines on what
    passed before the monitor; arguments as of `decode`.

    With `linear`, no pixel is asked whether something passed before it, in white or
    black neither.
    """
    clipped = clipped_at(images, patterns)
    if clipped:
        options = {"saturated": clipped.level, **options}
    options |= {"smooth": smooth, "linear": linear}
    levels, off = {level: options.get(level) for level in LEVELS}, []
    codes = read_coding(patterns, monitor.monitor_px)
    if not linear:
        levels, off = mended_levels(images, codes, levels)
        options |= levels
    found, passed = decode(images, patterns, monitor, **options), NOTHING
    if not linear:
        passed = passing(images, codes, found)
    levels |= {"smooth": smooth, "spoilt": passed.mask, "bands": passed.bands}
    told = examine(images, patterns, monitor, found, **levels)
    if max(told.factors) > 1:
        options |= {"noise": found.noise, "shared": told.factors}
        found = decode(images, patterns, monitor, **options)
    count = _leave_out(found, passed)
    return found, told, off + passing_warnings(passed, patterns, count)


def _leave_out(decoded, passed):
    """Take their places from pixels before which something passed; how many had one."""
    if passed.mask is None:
        return 0
    mask = decoded.mask & passed.mask
    decoded.status[mask] = PASSED
    decoded.location[mask] = decoded.sigma[mask] = np.nan
    return int(np.count_nonzero(mask))


def _what_hides_noise(image_set, view):
    """Why noise may be larger than it seems, and what to do: as the files are."""
    names = [pattern.image for pattern in view.patterns]
    if any(is_jpeg(image_set.folder / name) for name in names):
        return "JPEG smooths it away in the dark; save PNG or TIFF"
    return (
        "a tone curve of the camera squeezes it in the dark, as JPEG does that was "
        "turned into another format; take the pictures with a linear response"
    )


def _levels(view):
    return [name for name in LEVELS if getattr(view, name)]


def _pictures(image_set, view):
    """All pictures of a view in grey, of one depth: patterns first, then its levels."""
    names = [p.image for p in view.patterns]
    names += [getattr(view, level) for level in _levels(view)]
    found = []
    for name in names:
        picture = _grey(read_colour(image_set, name))
        if found and picture.dtype != found[0].dtype:
            bits = [one.dtype.itemsize * 8 for one in (picture, found[0])]
            raise InputError(
                f"{image_set.folder / name}: found {bits[0]} bit, but {bits[1]} in "
                f"{names[0]}; save all pictures of {view.label} in one depth"
            )
        found.append(picture)
    return found


def _grey(picture):
    if picture.ndim == 2:
        return picture
    import cv2

    grey = cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)
    top = np.iinfo(picture.dtype).max
    grey[(picture == top).any(axis=2)] = top
    return grey
