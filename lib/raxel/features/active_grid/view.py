"""Decoding of one view of an image set, from its files to monitor positions."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import cv2
import numpy as np

from raxel.errors import InputError
from raxel.features.active_grid.checks.diagnostics import clipped_at, examine
from raxel.features.active_grid.coding import ALONE, BORDER
from raxel.features.active_grid.decoding import Decoded, decode
from raxel.features.active_grid.response import response_warnings
from raxel.geometry.pixel_cells import as_in_a_mirror
from raxel.io.stored import StoredArray
from raxel.sets import ActiveGrid, ImageSet, View, read_colour

# Isolated pixels: dark parts that count as lit, because their noise exceeds the
# measured noise. Noise is measured from differences between neighbouring pixels. A tone
# curve makes it larger in the dark, and the blocks of a JPEG file hide it. A pixel
# outside the monitor is then decoded by chance. Two neighbours may agree by chance, a
# patch does not, and the modulation is small there. Small images of a mirror need this:
# a quarter of their decoded pixels are isolated.


FAINT_SIGMAS = 5  # times the usual sigma
MIN_PATCH_PIXELS = 40  # connected pixels; smaller patches are isolated
# Of the decoded pixels: faceted cameras also have some isolated ones.
MIN_ISOLATED_SHARE = 0.01


def without_isolated_pixels(decoded):
    """Return Decoded without isolated pixels and what is near them, and their share.

    A small share of isolated pixels is kept and returned as 0. With many of them, the
    surroundings of the lit area did not count as dark. Then the border is excluded
    here, by margin_px around all pixels that are not decoded. The arrays of `decoded`
    are changed, since copies would fill the memory.
    """
    mask = decoded.mask.astype(np.uint8)
    labels, stats = cv2.connectedComponentsWithStats(mask, connectivity=8)[1:3]
    small = stats[:, cv2.CC_STAT_AREA] < MIN_PATCH_PIXELS
    small[0] = False
    isolated = small[labels]
    del labels
    isolated &= _faint(decoded.sigma, mask > 0)
    isolated_share = np.count_nonzero(isolated) / max(np.count_nonzero(mask), 1)
    if isolated_share < MIN_ISOLATED_SHARE:
        return decoded, 0.0
    mask[isolated] = 0
    kernel = np.ones((2 * decoded.margin_px + 1,) * 2, np.uint8)
    inner = cv2.erode(mask, kernel, borderValue=1) > 0
    decoded.status[isolated] = ALONE
    decoded.status[(mask > 0) & ~inner] = BORDER
    for values in decoded.location, decoded.sigma:
        np.copyto(values, np.nan, where=~decoded.mask[..., None])
    return decoded, isolated_share


def _faint(sigma, mask):
    """Return (H, W) bool: pixels whose sigma along an axis is unusually large."""
    faint = np.zeros(mask.shape, bool)
    for own in np.moveaxis(sigma, 2, 0):
        known = own[mask]
        if np.isfinite(known).any():
            faint |= own > FAINT_SIGMAS * np.nanmedian(known, overwrite_input=True)
    return faint


LEVELS = "white", "black"


class DecodedView(NamedTuple):
    """Hold what was decoded in one view, and what limits its use.

    Attributes
    ----------
    decoded : Decoded
        Locations of the pixels.
    reason : str
        Why nothing of it can be used; empty where it can.
    warnings : tuple[str, ...]
        Lines on what the view suffers from.
    image : np.ndarray
        (H, W) uint8 or uint16, the image of the camera, with the pattern white where
        there is one.
    as_in_a_mirror : bool or None
        Whether the grid is visible as in a mirror; None where that is undetermined.
    step_errors : tuple[float, float]
        (along x, along y): by what sigma is widened, as the phase steps disagree.
    noise_factors : tuple[float, float]
        (along x, along y): by what sigma is multiplied before, for spatially correlated
        noise.
    """

    decoded: Decoded
    reason: str
    warnings: tuple[str, ...]
    image: np.ndarray
    as_in_a_mirror: bool | None
    step_errors: tuple[float, float]
    noise_factors: tuple[float, float]


def check_active_grid(image_set):
    """Raise InputError unless the target of the set is an active grid."""
    if not isinstance(image_set.target, ActiveGrid):
        raise InputError(
            f"{image_set.description}: target.kind: not an active_grid; use raxel "
            "corners for chessboards"
        )


def decode_view(image_set: ImageSet, view: View, **options: Any) -> DecodedView:
    """Read and decode the images of one view of a set.

    Colour images are converted to grey; a pixel of which one colour is clipped counts
    as clipped.

    Parameters
    ----------
    image_set : ImageSet
        The set, with an active grid as its target.
    view : View
        One of its views.
    **options
        Options of `decode`.

    Returns
    -------
    DecodedView
        Its `reason` states why it cannot be used: nothing could be decoded, or the
        images contradict each other so that the decoded locations are wrong.

    Raises
    ------
    InputError
        `bad-input` where an image cannot be read or does not fit the others. The
        message names set, view and file.
    """
    check_active_grid(image_set)
    where = f"{image_set.description}: views: {view.label}"
    images = _images(image_set, view)
    levels = dict(zip(_levels(view), images[len(view.patterns) :], strict=True))
    images = images[: len(view.patterns)]
    try:
        found, checked = decode_checked(
            images, view.patterns, image_set.target, **levels, **options
        )
    except InputError as fault:
        raise InputError(f"{where}: {fault}") from fault
    found, isolated = without_isolated_pixels(found)
    found = replace(found, sigma=checked.widened(found.sigma))
    diagnostics = checked.diagnostics
    reason = next(
        (diagnostic.text for diagnostic in diagnostics if diagnostic.invalidates), ""
    )
    if not reason and not found.mask.any():
        reasons = (f"{n} {why}" for why, n in found.counts().items() if n)
        reason = f"no pixel could be decoded ({', '.join(reasons)})"
    lines = [d.text for d in diagnostics if not d.invalidates]
    if found.blur_px is None and options.get("margin_px") is None:
        lines.append(
            f"blur not measurable (too few edges of Gray code); the margin of "
            f"{found.margin_px} px suits blur up to 1 px: increase --margin for more"
        )
    if isolated:
        lines.append(
            f"{100 * isolated:.0f} % of the decoded pixels are excluded as isolated "
            "pixels outside the lit area (noise in the dark); save PNG or TIFF with a "
            "linear response"
        )
    lines += response_warnings(found, options.get("linear"))
    warnings = tuple(f"{view.label}: {text}" for text in lines)
    image = levels.get("white", images[0])[:]
    mirrored = as_in_a_mirror(found.location)
    (ex, ey), (fx, fy) = map(float, checked.errors), map(float, checked.factors)
    return DecodedView(found, reason, warnings, image, mirrored, (ex, ey), (fx, fy))


def decode_checked(images, patterns, monitor, *, smooth=True, **options):
    """Decode images and check them: (Decoded, Examined); arguments of `decode`."""
    clipped = clipped_at(images, patterns)
    if clipped:
        options = {"saturated": clipped, **options}
    options["smooth"] = smooth
    levels = {level: options.get(level) for level in LEVELS}
    found = decode(images, patterns, monitor, **options)
    checked = examine(images, patterns, monitor, found, **levels, smooth=smooth)
    if max(checked.factors) > 1:
        options |= {"noise": found.noise, "shared": checked.factors}
        del found  # memory for the next one
        found = decode(images, patterns, monitor, **options)
    return found, checked


def _levels(view):
    return [name for name in LEVELS if getattr(view, name)]


def _images(image_set, view):
    """Return images in grey of one depth as StoredArrays: patterns, then levels."""
    names = [p.image for p in view.patterns]
    names += [getattr(view, level) for level in _levels(view)]
    found = []
    for name in names:
        image = _grey(read_colour(image_set, name))
        if found and image.dtype != found[0].dtype:
            bits = [one.dtype.itemsize * 8 for one in (image, found[0])]
            raise InputError(
                f"{image_set.folder / name}: {bits[0]} bit differs from {bits[1]} bit "
                f"of {names[0]}; save all images of {view.label} in one depth"
            )
        found.append(StoredArray(image))
    return found


def _grey(image):
    if image.ndim == 2:
        return image
    grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    top = np.iinfo(image.dtype).max
    grey[(image == top).any(axis=2)] = top
    return grey
