"""The saddle point method: a quadratic surface fitted to the blurred corner."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.errors import InputError

# Windows around corners: gathering, interpolation, and the noise in them.


def fits(shape, corners, reach):
    """Which corners (N,) are finite, with `reach` px of image on all sides."""
    height, width = shape
    with np.errstate(invalid="ignore"):
        inside = (corners >= reach) & (corners <= np.array([width, height]) - 1 - reach)
    return inside.all(axis=1)


def gather(image, first, size):
    """Square windows (N, size, size) of `image` from their first pixels (N, 2)."""
    views = np.lib.stride_tricks.sliding_window_view(image, (size, size))
    return views[first[:, 1], first[:, 0]]


def cubic_taps(fraction):
    """Weights (N, 4) of cubic convolution at pixels -1, 0, 1, 2, for `fraction` (N,).

    Keys (1981), doi 10.1109/TASSP.1981.1163711: exact for quadratics.
    """
    t = fraction[:, None] + np.array([1.0, 0.0, -1.0, -2.0])
    d = np.abs(t)
    near = (1.5 * d - 2.5) * d**2 + 1
    far = ((-0.5 * d + 2.5) * d - 4) * d + 2
    return np.where(d <= 1, near, far)


def spread(weights, taps):
    """Weights on samples (rows, n) as weights on pixels (N, rows, n + taps - 1).

    A sample between pixels is a sum of pixels with `taps` (N, taps); its weight is
    distributed in that proportion.
    """
    rows, n = weights.shape
    out = np.zeros((len(taps), rows, n + taps.shape[1] - 1))
    for k in range(taps.shape[1]):
        out[:, :, k : k + n] += taps[:, k, None, None] * weights
    return out


def noise_variance(
    image: NDArray[np.float64], corners: np.ndarray, weights: np.ndarray
) -> NDArray[np.float64]:
    """Return the variance of the pixel noise about each corner.

    A chessboard corner is point-symmetric: I(c + d) = I(c - d). The difference of a
    window and its 180-degree rotation therefore shows the noise and nothing else. It
    contains neither the image nor what a model cannot follow of it. The rotation is
    about the multiple of half a pixel next to the corner, where pixels fall on pixels.
    The first order of that shift is removed.

    Parameters
    ----------
    image : NDArray[np.float64]
        (H, W) grey levels.
    corners : np.ndarray
        (N, 2) pixels (u, v), `reach` px inside the image.
    weights : np.ndarray
        (N, m, m) weights of the pixels about the nearest whole pixel, with m odd and
        `reach` = m / 2 + 3. They select the pixels that matter to the caller.

    Returns
    -------
    NDArray[np.float64]
        (N,) squared grey levels.
    """
    half = weights.shape[1] // 2
    centre = np.rint(2 * corners) / 2
    pixel = np.floor(centre).astype(int)
    opposite = np.rint(2 * centre).astype(int) - pixel
    size = 2 * half + 5
    window = gather(image, pixel - half - 2, size)
    rotated = gather(image, opposite - half - 2, size)[:, ::-1, ::-1]
    even = (window + rotated) / 2
    slope_u = _slope(even[:, 2:-2])
    slope_v = _slope(even[:, :, 2:-2].transpose(0, 2, 1)).transpose(0, 2, 1)
    shift = 2 * (corners - centre)[:, :, None, None]
    odd = (
        (window - rotated)[:, 2:-2, 2:-2]
        + shift[:, 0] * slope_u
        + shift[:, 1] * slope_v
    )
    total = weights.sum(axis=(1, 2))
    # Every pair is counted twice. The corner has used two degrees of freedom.
    with np.errstate(invalid="ignore", divide="ignore"):
        pairs = total**2 / (weights**2).sum(axis=(1, 2)) / 2
        mean = (weights * odd**2).sum(axis=(1, 2)) / (2 * total)
    return mean * pairs / np.maximum(pairs - 2, 1)


def _slope(values):
    """Derivative along the last axis, of fourth order; two samples lost at each end."""
    near = values[..., 3:-1] - values[..., 1:-3]
    far = values[..., 4:] - values[..., :-4]
    return (8 * near - far) / 12


# Input and output of every localiser.


MIN_WINDOW_PX = 5


class Localised(NamedTuple):
    """Hold corners after localisation.

    `sd` is the spread that noise gives. What a window contains besides the corner, such
    as other corners, may move a result further.

    Attributes
    ----------
    corners : np.ndarray
        (N, 2) pixels (u, v).
    sd : np.ndarray
        (N,) px, predicted standard deviation of the position per axis (root mean square
        of both) from the noise of the image about the corner. NaN where nothing was
        found, infinite where the window does not hold the corner.
    converged : np.ndarray
        (N,) bool; where False, the corner is returned at its start position.
    """

    corners: np.ndarray
    sd: np.ndarray
    converged: np.ndarray


def checked(
    image: ArrayLike, corners: ArrayLike, window: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The grey image as float64 and corners (N, 2), or InputError."""
    image = np.asarray(image)
    if image.ndim != 2:
        raise InputError(
            f"image: found an array of shape {image.shape}; give grey levels "
            "(height, width)"
        )
    corners = np.asarray(corners, dtype=float)
    if corners.ndim != 2 or corners.shape[1] != 2:
        raise InputError(
            f"corners: found an array of shape {corners.shape}; give (N, 2) pixels"
        )
    if window != int(window) or window < MIN_WINDOW_PX or window % 2 == 0:
        raise InputError(
            f"window: found {window}; give an odd width of at least {MIN_WINDOW_PX} px"
        )
    return image.astype(float), corners


def within_window(found, start, window):
    """Which corners (N,) are finite and within the window of their start."""
    with np.errstate(invalid="ignore"):
        return (np.abs(found - start) <= window / 2).all(axis=1)


def localised(start, found, variance, converged):
    """A Localised with the results that converged, and the start positions elsewhere.

    variance: (N, 2, 2) px^2, covariance of the position; NaN where unknown.
    """
    corners = np.where(converged[:, None], found, start)
    with np.errstate(invalid="ignore"):
        sd = np.sqrt(np.trace(variance, axis1=1, axis2=2) / 2)
    sd = np.where(np.isfinite(sd), sd, np.inf)
    return Localised(corners, np.where(converged, sd, np.nan), converged)


def inverted(matrices):
    """Inverses of (N, 2, 2); not finite where singular."""
    a, b, c, d = matrices.reshape(-1, 4).T
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        return np.stack([d, -b, -c, a] / (a * d - b * c), axis=1).reshape(-1, 2, 2)


MAX_ITERATIONS = 30
STEP_TOL_PX = 1e-4
NOISE_WINDOW_PX = 7
SHIFT_PX = 0.5


def saddle_point(
    image: ArrayLike, corners: ArrayLike, *, window: int = 15, blur_sd: float = 2.0
) -> Localised:
    """Localise corners at the saddle points of the blurred grey levels.

    The blurred image about a corner is fitted by least squares in a square window with

        I(x, y) = a x^2 + b x y + c y^2 + d x + e y + f,

    with (x, y) from the middle of the window. The gradient vanishes at the corner,

        [2a  b; b  2c] (x, y)^T = -(d, e)^T,

    as long as that is a saddle, 4 a c - b^2 < 0. The window is moved there and the fit
    repeated until it is stationary. Only a window centred on the corner is free of bias
    from what the quadratic cannot follow.

    Parameters
    ----------
    image : ArrayLike
        (H, W) grey levels of any depth.
    corners : ArrayLike
        (N, 2) start pixels (u, v).
    window : int
        Full odd width of the window in px, 5 or more.
    blur_sd : float
        Standard deviation in px of the Gaussian blur before the fit; 0 for none.

    Returns
    -------
    Localised
        A corner has not converged where the surface is no saddle, where it left its
        first window, or where the window leaves the image.

    Raises
    ------
    InputError
        `bad-input` for a colour image, an invalid window or a negative blur.

    References
    ----------
    Lucchese and Mitra (2002), "Using saddle points for subpixel feature detection in
    camera calibration targets", doi 10.1109/APCCAS.2002.1115151.

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.features.localise import saddle_point
    >>> image = np.kron([[0, 255], [255, 0]], np.ones((30, 30)))
    >>> corner = saddle_point(image, [[28.0, 31.0]])
    >>> np.round(corner.corners, 3).tolist(), corner.converged.tolist()
    ([[29.5, 29.5]], [True])
    """
    image, corners = checked(image, corners, window)
    soft = blurred(image, blur_sd)
    found, converged = fit_saddles(soft, corners, window)
    reach = max(window, NOISE_WINDOW_PX) // 2 + 4
    known = converged & fits(image.shape, found, reach)
    variance = np.full((len(corners), 2, 2), np.nan)
    if known.any():
        variance[known] = _variance(image, soft, found[known], window, blur_sd)
    return localised(corners, found, variance, known)


def blurred(image: np.ndarray, blur_sd: float) -> np.ndarray:
    """Return an image after a Gaussian blur.

    Parameters
    ----------
    image : np.ndarray
        (H, W) float64 grey levels.
    blur_sd : float
        Standard deviation in px; 0 returns the image itself.

    Returns
    -------
    np.ndarray
        (H, W) float64 grey levels.

    Raises
    ------
    InputError
        `bad-input` for a negative standard deviation.
    """
    if not blur_sd >= 0:
        raise InputError(
            f"blur_sd: found {blur_sd}; give a standard deviation in px, 0 or more"
        )
    if blur_sd == 0:
        return image
    size = 2 * _reach(blur_sd) + 1
    return cv2.GaussianBlur(image, (size, size), blur_sd)


def fit_saddles(
    soft: NDArray[np.float64], corners: NDArray[np.float64], window: int
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Return the saddle points of an image that is blurred already.

    Parameters
    ----------
    soft : NDArray[np.float64]
        (H, W) grey levels.
    corners : NDArray[np.float64]
        (N, 2) start pixels (u, v).
    window : int
        Full odd width of the window in px.

    Returns
    -------
    found : NDArray[np.float64]
        (N, 2) pixels (u, v), NaN where the fit did not converge.
    converged : NDArray[np.bool_]
        (N,), as of `saddle_point`.
    """
    half = window // 2
    rows = _quadratic_rows(half)
    found = corners.copy()
    settled = np.zeros(len(corners), dtype=bool)
    # Derivative of the fitted gradient by the position of the window: first the fitted
    # Hessian, then updated by Broyden's method.
    change = np.full((len(corners), 2, 2), np.nan)
    step, gradient = np.zeros_like(corners), np.zeros_like(corners)
    active = np.arange(len(corners))
    for turn in range(MAX_ITERATIONS):
        active = active[fits(soft.shape, found[active], half + 2)]
        if not len(active):
            break
        now, hessian = _surface(soft, found[active], half, rows)
        if turn == 0:
            change[active] = hessian
        else:
            gradient_change = now - gradient[active]
            change[active] = _broyden(change[active], step[active], gradient_change)
        saddle = (_det(hessian) < 0) & (_det(change[active]) < 0)
        active, now = active[saddle], now[saddle]
        moves = -np.linalg.solve(change[active], now[..., None])[..., 0]
        length = np.linalg.norm(moves, axis=1)
        moves *= np.minimum(1, half / np.maximum(length, 1e-12))[:, None]
        found[active] += moves
        step[active], gradient[active] = moves, now
        inside = within_window(found[active], corners[active], window)
        stationary = inside & (length < STEP_TOL_PX)
        settled[active[stationary]] = True
        active = active[inside & ~stationary]
    found[~settled] = np.nan
    return found, settled


def _det(matrices):
    a, b, c, d = matrices.reshape(-1, 4).T
    return a * d - b * c


def _broyden(change, step, gradient_change):
    """The matrices (N, 2, 2) nearest to `change` that map step to gradient_change."""
    missing = gradient_change - (change @ step[..., None])[..., 0]
    square = np.maximum((step**2).sum(axis=1), 1e-12)[:, None, None]
    return change + missing[:, :, None] * step[:, None, :] / square


def _quadratic_rows(half):
    """1-D weights (3, 2 half + 1) whose products give the quadratic's coefficients.

    On a square grid the fit separates: the coefficient of x is a mean over y of slopes
    in x, that of x^2 a mean of curvatures, that of x y a slope of slopes.
    """
    x = np.arange(-half, half + 1.0)
    curved = x**2 - np.mean(x**2)
    return np.stack(
        [np.full(len(x), 1 / len(x)), x / (x @ x), curved / (curved @ curved)]
    )


def _surface(image, centres, half, rows):
    """Gradient (N, 2) and Hessian (N, 2, 2) of the fitted quadratic at its centre."""
    first, along_u, along_v = _placed(centres, half, rows)
    values = gather(image, first, 2 * half + 4)
    moments = along_v @ values @ along_u.transpose(0, 2, 1)
    gradient = np.stack([moments[:, 0, 1], moments[:, 1, 0]], axis=1)
    a, b, c = moments[:, 0, 2], moments[:, 1, 1], moments[:, 2, 0]
    hessian = np.stack([2 * a, b, b, 2 * c], axis=1).reshape(-1, 2, 2)
    return gradient, hessian


def _placed(centres, half, rows):
    """First pixels (N, 2) of the windows, and `rows` as weights on pixels, u and v."""
    base = np.floor(centres).astype(int)
    taps = [cubic_taps(fraction) for fraction in (centres - base).T]
    return base - half - 1, spread(rows, taps[0]), spread(rows, taps[1])


def _variance(image, soft, found, window, blur_sd):
    """Covariance (N, 2, 2) of the saddle points.

    The window settles where its fitted gradient g is zero, so that noise moves it by
    -(dg/dc)^-1 dg. Here c is the position of the window. The window moves along, and
    dg/dc is less than the fitted Hessian where the surface is not quadratic. dg is a
    weighted sum of pixels: the rows of the fit, through interpolation and blur.
    """
    half = window // 2
    rows = _quadratic_rows(half)
    change = np.empty((len(found), 2, 2))
    for axis in range(2):
        shift = np.zeros(2)
        shift[axis] = SHIFT_PX
        ahead, _ = _surface(soft, found + shift, half, rows)
        behind, _ = _surface(soft, found - shift, half, rows)
        change[:, :, axis] = (ahead - behind) / (2 * SHIFT_PX)
    _, along_u, along_v = _placed(found, half, rows)
    u, v = (_through_blur(along, blur_sd) for along in (along_u, along_v))
    uu, vv = u @ u.transpose(0, 2, 1), v @ v.transpose(0, 2, 1)
    gram = np.empty((len(found), 2, 2))
    gram[:, 0, 0] = vv[:, 0, 0] * uu[:, 1, 1]
    gram[:, 1, 1] = vv[:, 1, 1] * uu[:, 0, 0]
    gram[:, 0, 1] = gram[:, 1, 0] = vv[:, 0, 1] * uu[:, 0, 1]
    inverse = inverted(change)
    x = np.arange(
        -max(half, NOISE_WINDOW_PX // 2), max(half, NOISE_WINDOW_PX // 2) + 1.0
    )
    weights = np.minimum(np.abs(x), half) ** 2
    weights = np.broadcast_to(weights + weights[:, None], (len(found), len(x), len(x)))
    noise = noise_variance(image, found, weights)
    with np.errstate(invalid="ignore", over="ignore"):
        spread_px2 = inverse @ gram @ inverse.transpose(0, 2, 1)
        return noise[:, None, None] * spread_px2


def _through_blur(weights, blur_sd):
    """Weights on blurred pixels (N, rows, m) as weights on the pixels before it."""
    if blur_sd == 0:
        return weights
    reach = _reach(blur_sd)
    kernel = cv2.getGaussianKernel(2 * reach + 1, blur_sd)[:, 0]
    n, rows, size = weights.shape
    out = np.zeros((n, rows, size + 2 * reach))
    for k, share in enumerate(kernel):
        out[:, :, k : k + size] += share * weights
    return out


def _reach(blur_sd):
    return int(np.ceil(4 * blur_sd))
