"""OpenCV's cornerSubPix behind the interface of the localisers."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.errors import InputError
from raxel.features.localise.saddle import (
    Localised,
    checked,
    fits,
    gather,
    inverted,
    localised,
    noise_variance,
)

TERMINATION_PX = 0.1
ITERATIONS = 100


def opencv_subpix(
    image: np.ndarray,
    corners: ArrayLike,
    half_window: int = 4,
    zero_zone: int = -1,
    termination_px: float = TERMINATION_PX,
) -> NDArray[np.float64]:
    """Return corners as OpenCV's cornerSubPix alone localises them.

    `corner_subpix` also predicts the standard deviation of each corner.

    Parameters
    ----------
    image : np.ndarray
        (H, W) grey levels, uint8 or float32.
    corners : ArrayLike
        (N, 2) pixels (u, v) inside the image, which OpenCV takes as float32.
    half_window, zero_zone, termination_px
        As of `corner_subpix`.

    Returns
    -------
    NDArray[np.float64]
        (N, 2) pixels (u, v). A corner that OpenCV gives up keeps its start position.
    """
    import cv2

    until = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, ITERATIONS)
    # cornerSubPix overwrites its input.
    start = np.array(corners, dtype=np.float32, order="C").reshape(-1, 1, 2)
    window, middle = (half_window, half_window), (zero_zone, zero_zone)
    found = cv2.cornerSubPix(image, start, window, middle, (*until, termination_px))
    return found[:, 0].astype(float)


def corner_subpix(
    image: np.ndarray,
    corners: ArrayLike,
    *,
    half_window: int = 4,
    zero_zone: int = -1,
    termination_px: float = TERMINATION_PX,
) -> Localised:
    """Localise corners where the gradients of the grey levels point past them least.

    The function is OpenCV's cornerSubPix (formerly cvFindCornerSubPix). With g the
    gradient at a pixel p of the window and w a Gaussian weight, it minimises over q

        sum w (g . (p - q))^2,  so that  (sum w g g^T) q = sum w g g^T p,

    in a window about the last q, until q moves less than `termination_px`. A corner
    keeps its start position when q leaves the window on either axis.

    Parameters
    ----------
    image : np.ndarray
        (H, W) grey levels of any depth.
    corners : ArrayLike
        (N, 2) start pixels (u, v).
    half_window : int
        OpenCV's `winSize`: the window is 2 half_window + 1 px wide.
    zero_zone : int
        Half width in px of a central part that is excluded (`zeroZone`); -1 for none.
    termination_px : float
        Largest last step; the thesis states 0.1 px (3.3.2).

    Returns
    -------
    Localised
        Corners with predicted standard deviations.

    Raises
    ------
    InputError
        `bad-input` for a colour image, an invalid window, or a `zero_zone` of
        `half_window` or more.

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.features.localise import corner_subpix
    >>> image = np.kron([[0, 255], [255, 0]], np.ones((30, 30))).astype(np.uint8)
    >>> corner = corner_subpix(image, [[28.0, 31.0]], termination_px=1e-3)
    >>> np.round(corner.corners, 1).tolist(), corner.converged.tolist()
    ([[29.5, 29.5]], [True])
    """
    grey, corners = checked(image, corners, 2 * half_window + 1)
    if zero_zone >= half_window:
        raise InputError(
            f"zero_zone: found {zero_zone}; give less than half_window {half_window}"
        )
    # OpenCV rejects images smaller than its window plus two pixels on each side.
    inside = fits(grey.shape, corners, 0) & (min(grey.shape) >= 2 * half_window + 5)
    found = corners.copy()
    if inside.any():
        grey_levels = image if image.dtype == np.uint8 else grey.astype(np.float32)
        found[inside] = opencv_subpix(
            grey_levels, corners[inside], half_window, zero_zone, termination_px
        )
    # OpenCV returns its input unchanged where it gives up.
    moved = inside & (found != corners.astype(np.float32)).any(axis=1)
    moved &= fits(grey.shape, found, half_window + 5)
    variance = np.full((len(corners), 2, 2), np.nan)
    if moved.any():
        variance[moved] = _variance(grey, found[moved], half_window, zero_zone)
    return localised(corners, found, variance, moved)


def _variance(image, found, half, zero_zone):
    """Covariance (N, 2, 2) of the corners.

    With e = g . (p - q), noise dg changes q by A^-1 sum w (e dg + g (p - q) . dg). A dg
    is half the difference of two samples, and a sample a bilinear mean of four pixels.
    """
    gradient_u, gradient_v = _slopes(image, found, half)
    y, x = np.mgrid[-half : half + 1, -half : half + 1].astype(float)
    weight = np.exp(-(x**2 + y**2) / half**2)
    weight[(np.abs(x) <= zero_zone) & (np.abs(y) <= zero_zone)] = 0
    slopes = np.stack([gradient_u, gradient_v], axis=1)
    normal = np.einsum("naij,nbij,ij->nab", slopes, slopes, weight)
    inverse = inverted(normal)
    along = gradient_u * x + gradient_v * y
    pixels = []
    for axis in range(2):
        on_u = slopes[:, axis] * x + (along if axis == 0 else 0)
        on_v = slopes[:, axis] * y + (along if axis == 1 else 0)
        pixels.append(_on_pixels(weight * on_u, weight * on_v, found))
    with np.errstate(invalid="ignore", over="ignore"):
        influence = np.einsum("nab,nbij->naij", inverse, np.stack(pixels, axis=1))
        gram = np.einsum("naij,nbij->nab", influence, influence)
        counted = (influence**2).sum(axis=1)[:, :-1, :-1]
        return noise_variance(image, found, counted)[:, None, None] * gram


def _slopes(image, found, half):
    """Central differences (N, m, m) of the image sampled about the corners."""
    base = np.floor(found).astype(int)
    a, b = ((found - base).T)[:, :, None, None]
    block = gather(image, base - half - 1, 2 * half + 4)
    rows = (1 - b) * block[:, :-1] + b * block[:, 1:]
    samples = (1 - a) * rows[:, :, :-1] + a * rows[:, :, 1:]
    slope_u = (samples[:, 1:-1, 2:] - samples[:, 1:-1, :-2]) / 2
    slope_v = (samples[:, 2:, 1:-1] - samples[:, :-2, 1:-1]) / 2
    return slope_u, slope_v


def _on_pixels(on_u, on_v, found):
    """Weights on slopes (N, m, m) as weights on pixels (N, m + 3, m + 3)."""
    n, size, _ = on_u.shape
    samples = np.zeros((n, size + 2, size + 2))
    samples[:, 1:-1, 2:] += on_u / 2
    samples[:, 1:-1, :-2] -= on_u / 2
    samples[:, 2:, 1:-1] += on_v / 2
    samples[:, :-2, 1:-1] -= on_v / 2
    a, b = ((found - np.floor(found)).T)[:, :, None, None]
    pixels = np.zeros((n, size + 3, size + 3))
    pixels[:, :-1, :-1] += (1 - a) * (1 - b) * samples
    pixels[:, :-1, 1:] += a * (1 - b) * samples
    pixels[:, 1:, :-1] += (1 - a) * b * samples
    pixels[:, 1:, 1:] += a * b * samples
    return pixels
