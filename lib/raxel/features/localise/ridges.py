"""The derivative method: two crossing ridges fitted to the gradient's magnitude."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.features.localise.saddle import (
    Localised,
    checked,
    fits,
    gather,
    localised,
    noise_variance,
    within_window,
)

MAX_ITERATIONS = 40
MAX_RECENTRINGS = 3
STEP_TOL_PX, COST_TOL = 1e-3, 1e-4
# Largest number of pixels of the windows fitted at a time.
MAX_BATCH_PIXELS = 60_000
FIRST_DAMPING, MIN_DAMPING, MAX_DAMPING = 1e-3, 1e-9, 1e6
FIRST_WIDTH_PX = 1.5
LOG_WIDTHS = (-3.0, 6.0)
# Two edges are distinct, and have a width that a window can show.
MIN_SINE = 0.1
MIN_WIDTH_PX = 0.3
ANGLE_HALF_WINDOWS_PX = (4, 7)
N_ANGLE_BINS, MIN_BIN_DISTANCE = 36, 6
SMOOTH, DIFFERENCE = np.array([0.25, 0.5, 0.25]), np.array([-0.5, 0.0, 0.5])


def derivative(image: ArrayLike, corners: ArrayLike, *, window: int = 15) -> Localised:
    """Localise corners where the two ridges of the gradient's magnitude cross.

    The model of the photonic response at a crossing is made for the bright lines of the
    target of Li and Lavest. At a chessboard corner, the magnitude m of the gradient has
    two bright lines, one along each edge. The model is fitted, non-linearly, to the
    derivatives and not to the grey levels:

        m(x, y) = h1 R1 + h2 R2 - h3 R1 R2 + h0,    Rk = exp(-sk^2 / (2 wk^2)),
        sk = (x - u) cos ak + (y - v) sin ak.

    (u, v) is the corner, ak the direction across edge k and wk its width. On lines the
    crossing is as bright as one line, h3 = (h1 + h2) / 2. At a chessboard corner the
    gradient vanishes, h3 = h1 + h2. Here h3 is free, and so is the floor h0 of the
    magnitude of noise. Derivatives are Sobel's, divided by 8. The fit is Levenberg and
    Marquardt's. It starts from the two most frequent gradient directions in a window of
    9 to 15 px, and from the mean position of those gradients.

    Parameters
    ----------
    image : ArrayLike
        (H, W) grey levels of any depth.
    corners : ArrayLike
        (N, 2) start pixels (u, v).
    window : int
        Full odd width of the window in px, 5 or more.

    Returns
    -------
    Localised
        A corner has not converged where the fit found no two ridges that cross, where
        it left its first window, or where the window leaves the image.

    Raises
    ------
    InputError
        `bad-input` for a colour image or an invalid window.

    References
    ----------
    Li and Lavest (1996), "Some aspects of zoom lens camera calibration",
    doi 10.1109/34.544078.
    """
    image, corners = checked(image, corners, window)
    slopes = gradient(image)
    ridges, converged = fit_ridges(slopes, corners, window)
    found = ridges[:, :2]
    half = window // 2
    known = converged & fits(image.shape, found, half + 5)
    variance = np.full((len(corners), 2, 2), np.nan)
    for part in _in_parts(np.flatnonzero(known), window):
        variance[part] = _variance(image, slopes, ridges[part], half)
    return localised(corners, found, variance, known)


def gradient(image: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the derivatives of an image along u and v.

    Parameters
    ----------
    image : np.ndarray
        (H, W) float64 grey levels.

    Returns
    -------
    tuple[np.ndarray, np.ndarray]
        Derivatives along u and v, (H, W) each, in grey levels per pixel.
    """
    import cv2

    return (
        cv2.sepFilter2D(image, -1, DIFFERENCE, SMOOTH),
        cv2.sepFilter2D(image, -1, SMOOTH, DIFFERENCE),
    )


def fit_ridges(
    slopes: tuple[np.ndarray, np.ndarray], corners: NDArray[np.float64], window: int
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Fit the ten numbers of two ridges about each corner.

    Parameters
    ----------
    slopes : tuple[np.ndarray, np.ndarray]
        `gradient` of the image.
    corners : NDArray[np.float64]
        (N, 2) start pixels (u, v).
    window : int
        Full odd width of the window in px.

    Returns
    -------
    ridges : NDArray[np.float64]
        (N, 10): u, v, a1, a2, log w1, log w2, h1, h2, h3, h0, as of `derivative`.
    converged : NDArray[np.bool_]
        (N,).
    """
    half = window // 2
    magnitude = np.hypot(*slopes)
    ridges = np.full((len(corners), 10), np.nan)
    settled = np.zeros(len(corners), dtype=bool)
    ready = fits(magnitude.shape, corners, max(half, ANGLE_HALF_WINDOWS_PX[1]) + 1)
    for part in _in_parts(np.flatnonzero(ready), window):
        start = _start(slopes, magnitude, corners[part], half)
        ridges[part], settled[part] = _recentred(magnitude, start, half)
    settled &= within_window(ridges[:, :2], corners, window)
    settled &= _two_ridges(ridges, window)
    return ridges, settled


def _in_parts(indices, window):
    """Indices in groups whose windows fit into the cache."""
    size = max(1, MAX_BATCH_PIXELS // window**2)
    return [indices[k : k + size] for k in range(0, len(indices), size)]


def _two_ridges(ridges, window):
    """Which fits are two bright lines that cross, as wide as a window can show."""
    _, _, a1, a2, l1, l2, h1, h2, _, _ = ridges.T
    with np.errstate(invalid="ignore", over="ignore"):
        wide = np.exp([l1, l2])
        return (
            (np.abs(np.sin(a1 - a2)) > MIN_SINE)
            & (np.minimum(h1, h2) > 0)
            & (wide > MIN_WIDTH_PX).all(axis=0)
            & (wide < window).all(axis=0)
        )


def _start(slopes, magnitude, corners, half):
    """First ridges (N, 10): along the two strongest edges near the corners."""
    pixels = np.rint(corners).astype(int)
    ridges = np.zeros((len(corners), 10))
    normals = _edge_normals(slopes, pixels, int(np.clip(half, *ANGLE_HALF_WINDOWS_PX)))
    moved = _crossing(slopes, pixels, corners - pixels, normals, half)
    inside = (np.abs(moved) <= half).all(axis=1)
    ridges[:, :2] = np.where(inside[:, None], pixels + moved, corners)
    ridges[:, 2:4] = normals
    ridges[:, 4:6] = np.log(FIRST_WIDTH_PX)
    values = _values(magnitude, pixels, half)
    columns, _ = _columns(_about(ridges, pixels), *_offsets(half), values)
    square, slope = _normal(columns[:, 6:], values)
    trace = np.trace(square, axis1=1, axis2=2)[:, None, None]
    square += (1e-6 * trace + 1e-12) * np.eye(4)
    ridges[:, 6:] = np.linalg.solve(square, slope[..., None])[..., 0]
    return ridges


def _crossing(slopes, pixels, start, normals, half):
    """Where the two edges near `start` (N, 2) cross, relative to `pixels`: (N, 2).

    The position of an edge is the mean position, across it, of the gradients that point
    across it. The mean is taken in shrinking windows (mean shift).
    """
    x, y = _offsets(half)
    on_u, on_v = (
        gather(slope, pixels - half, 2 * half + 1).reshape(len(pixels), -1)
        for slope in slopes
    )
    cos, sin = np.cos(normals), np.sin(normals)
    positions = np.empty((len(pixels), 2))
    for k in range(2):
        c, s = cos[:, k, None], sin[:, k, None]
        across, along = c * on_u + s * on_v, c * on_v - s * on_u
        weight = np.maximum(across**2 - 2 * along**2, 0)
        position = c * x + s * y
        middle = c * start[:, :1] + s * start[:, 1:]
        for reach in (half / 2, half / 4, FIRST_WIDTH_PX):
            near = weight * np.exp(
                -0.5 * ((position - middle) / max(reach, FIRST_WIDTH_PX)) ** 2
            )
            total = near.sum(axis=1, keepdims=True)
            mean = (near * position).sum(axis=1, keepdims=True)
            middle = np.divide(mean, total, out=middle.copy(), where=total > 0)
        positions[:, k] = middle[:, 0]
    rows = np.stack([cos, sin], axis=2)
    return np.linalg.solve(rows, positions[..., None])[..., 0]


def _edge_normals(slopes, pixels, half):
    """The two directions (N, 2) in which the gradients of a window point most.

    Directions are counted without their sign, by squared length, in bins of 5 deg. The
    second one is the fullest bin at least 30 deg from the first.
    """
    on_u, on_v = (gather(slope, pixels - half, 2 * half + 1) for slope in slopes)
    bins = np.arctan2(on_v, on_u) % np.pi / np.pi * N_ANGLE_BINS
    bins = (
        bins.astype(int) % N_ANGLE_BINS
        + N_ANGLE_BINS * np.arange(len(pixels))[:, None, None]
    )
    count = np.bincount(
        bins.ravel(), (on_u**2 + on_v**2).ravel(), N_ANGLE_BINS * len(pixels)
    ).reshape(-1, N_ANGLE_BINS)
    soft = 2 * count + np.roll(count, 1, axis=1) + np.roll(count, -1, axis=1)
    first = soft.argmax(axis=1)
    distance = np.abs(np.arange(N_ANGLE_BINS) - first[:, None])
    distance = np.minimum(distance, N_ANGLE_BINS - distance)
    second = np.where(distance < MIN_BIN_DISTANCE, -1.0, soft).argmax(axis=1)
    return (np.column_stack([first, second]) + 0.5) * np.pi / N_ANGLE_BINS


def _offsets(half):
    """Positions x, y (n,) in a window relative to its centre, in single precision."""
    step = np.arange(2 * half + 1, dtype=np.float32) - half
    return tuple(grid.ravel() for grid in np.meshgrid(step, step))


def _values(magnitude, pixels, half):
    """Magnitudes (N, n) in windows around integer `pixels`, in single precision."""
    block = gather(magnitude, pixels - half, 2 * half + 1)
    return block.reshape(len(pixels), -1).astype(np.float32)


def _about(ridges, pixels):
    """Ridges with the corner counted from `pixels` (N, 2)."""
    moved = ridges.copy()
    moved[:, :2] -= pixels
    return moved


def _recentred(magnitude, ridges, half):
    """Fits in windows recentred on the last result; and whether they converged."""
    settled = np.zeros(len(ridges), dtype=bool)
    active = np.arange(len(ridges))
    for _ in range(MAX_RECENTRINGS):
        pixels = np.rint(ridges[active, :2]).astype(int)
        values = _values(magnitude, pixels, half)
        fitted, settled[active] = _levenberg(
            _about(ridges[active], pixels), *_offsets(half), values
        )
        ridges[active] = _about(fitted, -pixels)
        moved = settled[active] & fits(magnitude.shape, ridges[active, :2], half + 1)
        settled[active] &= moved
        moved &= (np.rint(ridges[active, :2]) != pixels).any(axis=1)
        active = active[moved]
        if not len(active):
            break
    return ridges, settled


def _columns(ridges, x, y, values):
    """Derivatives (N, 10, n) of the model by its parameters, and the residuals."""
    u, v, a1, a2, l1, l2, h1, h2, h3, _ = ridges.T[:, :, None]
    columns = np.empty((len(ridges), 10, len(x)), dtype=np.float32)
    ridge = []
    for k, (a, log_width) in enumerate(((a1, l1), (a2, l2))):
        cos, sin = np.cos(a), np.sin(a)
        s = _line(cos, sin, u, v, x, y)
        falling = s * np.exp(-2 * log_width).astype(np.float32)
        spread = s * falling
        ridge.append(np.exp(-0.5 * spread))
        falling *= ridge[k]
        columns[:, 2 + k] = _line(-sin, cos, u, v, x, y)
        columns[:, 4 + k] = np.multiply(spread, ridge[k], out=spread)
        columns[:, 6 + k] = np.negative(falling, out=falling)
    for k in range(2):
        height = (h1, h2)[k].astype(np.float32) - h3.astype(np.float32) * ridge[1 - k]
        columns[:, 4 + k] *= height
        columns[:, 6 + k] *= height
        columns[:, 2 + k] *= columns[:, 6 + k]
    columns[:, 0] = _line(-np.cos(a1), -np.cos(a2), 0, 0, columns[:, 6], columns[:, 7])
    columns[:, 1] = _line(-np.sin(a1), -np.sin(a2), 0, 0, columns[:, 6], columns[:, 7])
    columns[:, 6], columns[:, 7] = ridge
    np.multiply(-ridge[0], ridge[1], out=columns[:, 8])
    columns[:, 9] = 1
    linear = ridges[:, None, 6:].astype(np.float32) @ columns[:, 6:]
    return columns, values - linear[:, 0]


def _line(p, q, u, v, x, y):
    """p (x - u) + q (y - v), in single precision; p, q, u, v (N, 1)."""
    out = p.astype(np.float32) * x
    out += q.astype(np.float32) * y
    out -= (p * u + q * v).astype(np.float32)
    return out


def _normal(columns, residual):
    """J J^T (N, 10, 10) and J r (N, 10) in double precision."""
    square = columns @ columns.transpose(0, 2, 1)
    slope = (columns @ residual[..., None])[..., 0]
    return square.astype(float), slope.astype(float)


def _levenberg(ridges, x, y, values):
    """Levenberg-Marquardt for all corners at once: ridges (N, 10), converged (N,).

    Positions are relative to the centre of each window.
    """
    ridges = ridges.copy()
    settled = np.zeros(len(ridges), dtype=bool)
    damping = np.full(len(ridges), FIRST_DAMPING)
    columns, residual = _columns(ridges, x, y, values)
    square, slope = _normal(columns, residual)
    cost = np.square(residual).sum(axis=1)
    active = np.arange(len(ridges))
    for _ in range(MAX_ITERATIONS):
        trial = ridges[active] + _damped(square[active], slope[active], damping[active])
        trial[:, 4:6] = np.clip(trial[:, 4:6], *LOG_WIDTHS)
        columns, residual = _columns(trial, x, y, values[active])
        new_cost = np.square(residual).sum(axis=1)
        better = new_cost <= cost[active]
        moved = np.linalg.norm(trial[:, :2] - ridges[active, :2], axis=1)
        gain = cost[active] - new_cost
        taken = active[better]
        ridges[taken], cost[taken] = trial[better], new_cost[better]
        square[taken], slope[taken] = _normal(columns[better], residual[better])
        damping[active] *= np.where(better, 0.2, 10.0)
        np.clip(damping, MIN_DAMPING, None, out=damping)
        stationary = better & (moved < STEP_TOL_PX) & (gain <= COST_TOL * new_cost)
        settled[active[stationary]] = True
        active = active[~stationary & (damping[active] < MAX_DAMPING)]
        if not len(active):
            break
    return ridges, settled


def _damped(normal, slope, damping):
    """Steps (N, 10) of Levenberg and Marquardt."""
    diagonal = np.einsum("nii->ni", normal)
    scale = diagonal + 1e-9 * diagonal.max(axis=1, keepdims=True) + 1e-12
    damped = normal + (damping[:, None] * scale)[:, :, None] * np.eye(10)
    damped += 1e-12 * np.eye(10)
    return np.linalg.solve(damped, slope[..., None])[..., 0]


def _variance(image, slopes, ridges, half):
    """Covariance (N, 2, 2) of the crossings.

    Noise dm in the magnitude moves a least-squares fit by (J^T J)^-1 J^T dm, where
    dm = (gu dgu + gv dgv) / m, and a derivative is a weighted sum of pixels.
    """
    pixels = np.rint(ridges[:, :2]).astype(int)
    size = 2 * half + 1
    on_u, on_v = (gather(slope, pixels - half, size) for slope in slopes)
    length = np.maximum(np.hypot(on_u, on_v), 1e-9)
    values = length.reshape(len(ridges), -1)
    columns, residual = _columns(_about(ridges, pixels), *_offsets(half), values)
    square, _ = _normal(columns, residual)
    square += 1e-9 * square * np.eye(10) + 1e-12 * np.eye(10)
    influence = (np.linalg.inv(square)[:, :2] @ columns).reshape(-1, 2, size, size)
    weights = np.zeros((len(ridges), 2, size + 2, size + 2))
    for i in range(3):
        for j in range(3):
            along_u = SMOOTH[i] * DIFFERENCE[j] * on_u
            along_v = DIFFERENCE[i] * SMOOTH[j] * on_v
            share = influence * ((along_u + along_v) / length)[:, None]
            weights[:, :, i : i + size, j : j + size] += share
    gram = np.einsum("naij,nbij->nab", weights, weights)
    noise = noise_variance(image, ridges[:, :2], (weights**2).sum(axis=1))
    return noise[:, None, None] * gram
