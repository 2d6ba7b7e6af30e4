"""A view of an image set, from its files to what each pixel sees."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import cv2
import numpy as np

from raxel.errors import InputError
from raxel.features.active_grid.checks.doubts import clipped_at, examine
from raxel.features.active_grid.coding import ALONE, FILLED, RIM
from raxel.features.active_grid.decoding import Decoded, decode
from raxel.features.active_grid.response import response_warnings
from raxel.geometry.pixel_cells import as_in_a_mirror
from raxel.sets import ActiveGrid, ImageSet, View, read_colour

# Dark parts that are taken for lit ones, since their noise is more than was measured.
# Noise is measured from differences of neighbouring pixels. A tone curve makes it
# larger in the dark, and the blocks of a JPEG file hide it: outside the monitor, a
# pixel is then decoded by chance. Two neighbours may agree by chance, a patch of them
# does not, and the sines are faint there. Small images of a mirror need this: a
# quarter of their decoded pixels are such specks.


FAINT = 5  # times the usual sigma
PATCH = 40  # pixels that hang together; of fewer, it is a speck
MANY = 0.01  # of what is decoded: fewer specks are what cameras in facets see


def without_specks(decoded):
    """(Decoded without specks and what is near them, the share that they were).

    Where specks are few, they stay, and the share is 0. Where they are many, what lies
    beside the lit area did not count as dark: the rim is left out here, by margin_px
    about all that is not decoded.
    """
    mask = decoded.mask.astype(np.uint8)
    count = np.count_nonzero(mask)
    labels, stats = cv2.connectedComponentsWithStats(mask, connectivity=8)[1:3]
    small = stats[:, cv2.CC_STAT_AREA] < PATCH
    small[0] = False
    specks = small[labels] & _faint(decoded.sigma, mask > 0)
    share = np.count_nonzero(specks) / max(count, 1)
    if share < MANY:
        return decoded, 0.0
    mask[specks] = 0
    kernel = np.ones((2 * decoded.margin_px + 1,) * 2, np.uint8)
    inner = cv2.erode(mask, kernel, borderValue=1) > 0
    status = np.where(specks, ALONE, decoded.status)
    status = np.where((mask > 0) & ~inner, RIM, status).astype(np.uint8)
    gone = status > FILLED
    location, sigma = decoded.location.copy(), decoded.sigma.copy()
    location[gone] = sigma[gone] = np.nan
    return replace(decoded, location=location, sigma=sigma, status=status), share


def _faint(sigma, mask):
    """(H, W) bool: where an axis is known much worse than it usually is."""
    faint = np.zeros(mask.shape, bool)
    for own in np.moveaxis(sigma, 2, 0):
        known = own[mask]
        if np.isfinite(known).any():
            faint |= own > FAINT * np.nanmedian(known)
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
            f"{image_set.description}: target.kind: found no active_grid; chessboards "
            "are for raxel corners"
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
    images = np.array(_pictures(image_set, view))
    levels = dict(zip(_levels(view), images[len(view.patterns) :], strict=True))
    images = images[: len(view.patterns)]
    shown = view.patterns, image_set.target
    try:
        found, checked = decode_checked(images, *shown, **levels, **options)  # type: ignore[misc]
    except InputError as fault:
        raise InputError(f"{where}: {fault}") from fault
    found, specks = without_specks(found)
    found = replace(found, sigma=checked.widened(found.sigma))
    doubts = checked.doubts
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
    if specks:
        warnings.append(
            f"{100 * specks:.0f} % of the decoded pixels are specks outside the lit "
            "area and are left out; save PNG or TIFF with a linear response, since the "
            "noise in the dark is larger than measured"
        )
    warnings += response_warnings(found, options.get("linear"))
    warnings = tuple(f"{view.label}: {text}" for text in warnings)  # type: ignore[assignment]
    image = levels.get("white", images[0])
    mirrored = as_in_a_mirror(found.location)
    errors, factors = (tuple(map(float, x)) for x in (checked.errors, checked.factors))
    return DecodedView(found, reason, warnings, image, mirrored, errors, factors)  # type: ignore[arg-type]


def decode_checked(images, patterns, monitor, *, smooth=True, **options):
    """Decode images and check them: (Decoded, Examined); arguments as of `decode`."""
    clipped = clipped_at(images, patterns)
    if clipped:
        options = {"saturated": clipped, **options}
    options["smooth"] = smooth
    levels = {level: options.get(level) for level in LEVELS}
    found = decode(images, patterns, monitor, **options)
    checked = examine(images, patterns, monitor, found, **levels, smooth=smooth)
    if max(checked.factors) > 1:
        options |= {"noise": found.noise, "shared": checked.factors}
        found = decode(images, patterns, monitor, **options)
    return found, checked


def _levels(view):
    return [name for name in LEVELS if getattr(view, name)]


def _pictures(image_set, view):
    """All images of a view in grey, of one depth: patterns first, then its levels."""
    names = [p.image for p in view.patterns]
    names += [getattr(view, level) for level in _levels(view)]
    found = []
    for name in names:
        image = _grey(read_colour(image_set, name))
        if found and image.dtype != found[0].dtype:
            bits = [one.dtype.itemsize * 8 for one in (image, found[0])]
            raise InputError(
                f"{image_set.folder / name}: found {bits[0]} bit, but {bits[1]} in "
                f"{names[0]}; save all images of {view.label} in one depth"
            )
        found.append(image)
    return found


def _grey(image):
    if image.ndim == 2:
        return image
    import cv2

    grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    top = np.iinfo(image.dtype).max
    grey[(image == top).any(axis=2)] = top
    return grey
