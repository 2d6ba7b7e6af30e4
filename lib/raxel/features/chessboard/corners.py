"""Verification and sub-pixel localisation of the corners of a lattice."""

from typing import NamedTuple

import cv2
import numpy as np

from raxel.features.chessboard.saddles import LINEAR, SMOOTHED_NOISE_SD, remapped

# Propagation of pixel noise through the corner fit. `localise_corners` takes gradients
# g_k at positions x_k of a window, in half windows from its centre, and solves A q =
# sum w_k g_k (g_k . x_k), A = sum w_k g_k g_k^T. Gradient errors n_k move the corner,
# which is at q = 0, by A^-1 sum w_k (g_k (n_k . x_k) + n_k (g_k . x_k)). The n_k are
# differences of smoothed noise, which is spatially correlated: white noise of variance
# 1, smoothed by a Gaussian of variance s^2, has the covariance exp(-d^2 / 4 s^2) / (4
# pi s^2) at distance d.


# Variance in px^2 that cubic B-spline interpolation adds to the smoothing.
INTERPOLATION_VARIANCE_PX2 = 1 / 3


def influences(g, x, weight, part=1.0):
    """Solution q of the fit to a part of the window, and its derivatives by gradients.

    g: (N, K, 2) gradients, K = (2 n + 1)^2 row by row, less their weighted mean; x: (K,
    2); weight, part: (K,). Returns q (N, 2) in half windows, and its derivatives (N, 2,
    K, 2) by each gradient.
    """
    combined = weight * part
    toward = (g * x).sum(axis=2)
    A = np.swapaxes(g * combined[:, None], 1, 2) @ g
    A += (1e-9 * np.trace(A, axis1=1, axis2=2)[:, None, None] + 1e-12) * np.eye(2)
    inverse = np.linalg.inv(A)
    right = (combined[:, None] * g * toward[..., None]).sum(axis=1)
    moved = combined[:, None, None] * (
        g[..., None] * x[:, None, :] + toward[..., None, None] * np.eye(2)
    )
    moved -= (weight / weight.sum())[:, None, None] * moved.sum(axis=1, keepdims=True)
    q = np.einsum("nab,nb->na", inverse, right)
    return q, np.einsum("nab,nkbc->nakc", inverse, moved)


def variances(moved, window, level):
    """Variance (N, M) from pixel noise of weighted sums of the gradients of a Level.

    moved: (N, M, K, 2) weights of the gradients; window: (N, 2, 2) px, its columns half
    a window in s and t.
    """
    weights = _of_samples(moved)
    size = 2 * weights.shape[-1]
    power = np.abs(np.fft.rfft2(weights, (size, size))) ** 2
    correlation = np.fft.irfft2(power, (size, size))
    steps = np.fft.fftfreq(size, 1 / size) * 2 / (weights.shape[-1] - 3)
    lags = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    px = lags @ np.swapaxes(window / level.scale, 1, 2)
    smooth = level.sigma**2 + INTERPOLATION_VARIANCE_PX2
    shared = np.exp(-(px**2).sum(axis=2) / (4 * smooth)) / (4 * np.pi * smooth)
    total = (correlation.reshape(*correlation.shape[:2], -1) @ shared[..., None])[
        ..., 0
    ]
    return level.noise**2 * np.maximum(total, 0)


def _of_samples(moved):
    """Weights (N, M, S, S) of samples, S = 2 n + 3, from those (N, M, K, 2) of slopes.

    A slope is the difference of the samples on its two sides, times n / 2.
    """
    side = round(np.sqrt(moved.shape[2]))
    s, t = np.moveaxis(moved.reshape(*moved.shape[:2], side, side, 2), -1, 0)
    per_half = (side - 1) / 4
    weights = np.zeros((*moved.shape[:2], side + 2, side + 2))
    weights[..., 1:-1, 2:] += per_half * s
    weights[..., 1:-1, :-2] -= per_half * s
    weights[..., 2:, 1:-1] += per_half * t
    weights[..., :-2, 1:-1] -= per_half * t
    return weights


SQUARE_SAMPLES = np.array([0.2, 0.34])
MIN_CONTRAST_RATIO = 0.3
# Half window: fraction of the spacing, and largest size in px.
HALF_WINDOW_STEPS, MAX_HALF_WINDOW_PX = 0.38, 7.0


class Effort(NamedTuple):
    """Effort of the corner search.

    half: samples from the centre of a window to its side; iterations: maximum number of
    moves of the window; tolerance_px: a smaller move is the last; widening: ratio of a
    cell's share to the window above which the next window is tried.
    """

    half: int
    iterations: int
    tolerance_px: float
    widening: float


QUICK_EFFORT, FULL_EFFORT = Effort(4, 5, 0.02, 1.67), Effort(7, 12, 1e-3, 1.15)
MAX_SHIFT_STEPS = 0.3
# Inner part of the window, as a fraction of its half size. It determines the corner as
# precisely as the outer part.
INNER_FRACTION = 0.6
# Shift of a window, as a fraction of its half size, to measure how the fit responds.
TEST_SHIFT_FRACTION = 0.1
MIN_RESPONSE_DET = 1e-3
# Window of the symmetry test: half size in spacings, and samples along it.
SYMMETRY_HALF_WINDOW_STEPS, N_SYMMETRY_SAMPLES = 0.33, 12


class CornerSquares(NamedTuple):
    """The four squares around N corners.

    alternate (N,) bool: dark and bright in turn; sign (N,) of the square between +s and
    +t; contrast (N,): smallest difference of neighbours.
    """

    alternate: np.ndarray
    sign: np.ndarray
    contrast: np.ndarray


class LocalisedCorners(NamedTuple):
    """Corners at the crossings of edges: points (N, 2), sd (N,) px, misfit (N,).

    sd: predicted from the noise of the level, as in `Grid`; disagreement (N, 2):
    difference between the inner and the outer part of the window, in SDs of that noise
    (`_inner_outer_difference`). misfit: fraction of the edge strength that does not
    point at the corner; half (N,): half size of the window in spacings; good (N,):
    whether the search ended near its start.
    """

    points: np.ndarray
    sd: np.ndarray
    disagreement: np.ndarray
    misfit: np.ndarray
    half: np.ndarray
    good: np.ndarray


def squares_around(patches, level):
    """The squares around corners, sampled in a Level."""
    a, b = np.meshgrid(SQUARE_SAMPLES, SQUARE_SAMPLES)
    s = np.concatenate([x * a.ravel() for x in (1, -1, -1, 1)])
    t = np.concatenate([y * b.ravel() for y in (1, 1, -1, -1)])
    grey = sampled(level, patches.at(s, t)).reshape(-1, 4, a.size)
    fields = grey.mean(axis=2)
    step = (fields - np.roll(fields, -1, axis=1)) * [1, -1, 1, -1]
    sign = np.sign(step.sum(axis=1))
    step *= sign[:, None]
    smallest, largest = step.min(axis=1), step.max(axis=1)
    return CornerSquares(
        smallest > MIN_CONTRAST_RATIO * np.maximum(largest, 1e-6), sign, smallest
    )


def asymmetry(patches, level):
    """Deviation (N,) of corners from 180-degree point symmetry, in a Level.

    The four squares around a corner are point-symmetric, however they are blurred. An
    occluder of a part, or the edge of a shadow across the corner, is not. The result is
    the root of the odd part's share of the window's variance, without the gradient of
    the light and without the level's noise.
    """
    _, even, odd, _ = _even_and_odd(patches, level, N_SYMMETRY_SAMPLES)
    noise = SMOOTHED_NOISE_SD * level.noise / np.sqrt(2)
    share = np.maximum((odd**2).mean(axis=1) - noise**2, 0)
    return np.sqrt(share / np.maximum((even**2).mean(axis=1), 1e-6))


def symmetry_shift(patches, level, samples):
    """Distance (N,) px of corners from their centre of 180-degree symmetry, in a Level.

    The centre is the point about which the window is closest to even (`asymmetry`);
    samples: along the window.
    """
    k, even, odd, flat = _even_and_odd(patches, level, samples)
    field = even.reshape(-1, len(k), len(k))
    change = np.gradient(field, k, k, axis=(2, 1))
    change = np.stack([flat(one.reshape(even.shape)) for one in change], axis=2)
    normal = np.swapaxes(change, 1, 2) @ change + 1e-9 * np.eye(2)
    right = -np.swapaxes(change, 1, 2) @ odd[..., None]
    ds, dt = np.linalg.solve(normal, right)[..., 0].T
    return np.linalg.norm(ds[:, None] * patches.u + dt[:, None] * patches.v, axis=1)


def _even_and_odd(patches, level, samples):
    """Positions (samples,) along a window, its even and its odd part (N, samples^2).

    The mean of the even part and the linear gradient of the odd part are removed. The
    function that removes the gradient is returned as well. Linear interpolation is not
    symmetric about a corner, and shifts it by 0.07 px at a spacing of 4 px.
    """
    k = np.linspace(-SYMMETRY_HALF_WINDOW_STEPS, SYMMETRY_HALF_WINDOW_STEPS, samples)
    t, s = (a.ravel() for a in np.meshgrid(k, k, indexing="ij"))
    grey, rotated = (
        sampled(level, patches.at(a * s, a * t), cv2.INTER_LANCZOS4) for a in (1, -1)
    )
    even, odd = (grey + rotated) / 2, (grey - rotated) / 2
    slope = np.column_stack([s, t]) / np.linalg.norm(s)

    def flat(values):
        return values - (values @ slope) @ slope.T

    return k, even - even.mean(axis=1, keepdims=True), flat(odd), flat


def sampled(level, pixels, interpolation=LINEAR):
    """Grey levels (N, M) of a Level at image px (N, M, 2); border levels outside."""
    at = (pixels / level.scale).astype(np.float32)
    u, v = np.ascontiguousarray(at[..., 0]), np.ascontiguousarray(at[..., 1])
    return remapped(level.grey, u, v, cv2.BORDER_REPLICATE, interpolation)


def localise_corners(patches, level, window_px=MAX_HALF_WINDOW_PX, effort=FULL_EFFORT):
    """Corners where the edges of their patches cross: `LocalisedCorners`.

    In the window every gradient should be perpendicular to the line to the corner. The
    corner minimises the sum of (g . (x - q))^2, iterated until it is stationary. The
    mean of the gradients is removed first. It vanishes around a corner, so that a
    non-zero mean is a gradient of the light or uneven blur, which would bias the
    corner. The standard deviation is the level's noise propagated through this fit.
    """
    size = np.stack([np.linalg.norm(a, axis=1) for a in (patches.u, patches.v)], axis=1)
    window = window_px * level.scale
    half = np.minimum(HALF_WINDOW_STEPS, window / np.maximum(size, 1e-6))
    x, weight = window_samples(effort.half)
    start = patches.p
    now, active = patches, np.arange(len(start))
    points = start.copy()
    gradients = np.zeros((len(start), len(x), 2), np.float32)
    for _ in range(effort.iterations):
        local = now.of(active)
        g = _slopes(level, local, half[active], weight, effort.half)
        gradients[active] = g
        shift = solved(g, x, weight) * half[active]
        shift = np.clip(shift, -MAX_SHIFT_STEPS, MAX_SHIFT_STEPS)
        move = shift[:, :1] * local.u + shift[:, 1:] * local.v
        points[active] += move
        now = now._replace(p=points)
        active = active[np.linalg.norm(move, axis=1) > effort.tolerance_px]
        if not len(active):
            break
    window = np.stack([half[:, :1] * patches.u, half[:, 1:] * patches.v], axis=2)
    is_inner = np.abs(x).max(axis=1) <= INNER_FRACTION
    parts = np.ones(len(x)), is_inner, ~is_inner
    fits = [influences(gradients, x, weight, part) for part in parts]
    follows = _window_responses(level, now, half, x, weight, parts, effort.half)
    moved, sd = _noise_influence(fits[0][1], window, follows[0], level)
    disagreement = _inner_outer_difference(fits[1:], follows[1:], moved, window, level)
    misfit = misfit_of(gradients, x, weight)
    away = np.linalg.norm(points - start, axis=1) / np.maximum(patches.size, 1e-6)
    good = away < MAX_SHIFT_STEPS
    return LocalisedCorners(points, sd, disagreement, misfit, half.max(axis=1), good)


def window_samples(half):
    """Positions (K, 2) in half windows, K = (2 half + 1)^2 row by row, and weights."""
    k = np.arange(-half, half + 1) / half
    b, a = np.meshgrid(k, k, indexing="ij")
    x = np.stack([a.ravel(), b.ravel()], axis=1).astype(np.float32)
    return x, np.exp(-(x**2).sum(axis=1) / (2 * 0.6**2))


def _slopes(level, patches, half, weight, samples):
    """Slopes (N, K, 2) in windows, per half window, without their mean."""
    from raxel.features.chessboard.compiled import slopes_in_windows

    g = slopes_in_windows(level.grey, level.scale, patches, half, samples)
    return without_mean(g, weight)


def without_mean(g, weight):
    """Gradients (N, K, 2) less their weighted mean."""
    return g - (weight[:, None] * g).sum(axis=1, keepdims=True) / weight.sum()


def _window_responses(level, patches, half, x, weight, parts, samples):
    """Decrease of q of parts of a window that is shifted, (parts, N, 2, 2), about 1.

    A centred window contains equal parts of the four squares. When it is shifted, the
    squares that enter and leave it move q as well.
    """
    change = np.empty((len(parts), len(half), 2, 2))
    centred = _slopes(level, patches, half, weight, samples)
    for axis, along in enumerate((patches.u, patches.v)):
        shift = TEST_SHIFT_FRACTION * half[:, axis : axis + 1] * along
        shifted = _slopes(level, patches.moved(shift), half, weight, samples)
        for k, part in enumerate(parts):
            q, other = (solved(g, x, weight * part) for g in (centred, shifted))
            change[k, ..., axis] = (q - other) / TEST_SHIFT_FRACTION
    return change


def solved(g, x, weight):
    """q (N, 2) that minimises sum w (g . (x - q))^2."""
    A, rhs = _normal(g, x, weight)
    det = A[:, 0, 0] * A[:, 1, 1] - A[:, 0, 1] ** 2
    det = np.where(det > 1e-12, det, np.inf)
    return np.stack(
        [
            (A[:, 1, 1] * rhs[:, 0] - A[:, 0, 1] * rhs[:, 1]) / det,
            (A[:, 0, 0] * rhs[:, 1] - A[:, 0, 1] * rhs[:, 0]) / det,
        ],
        axis=1,
    )


def _normal(g, x, weight):
    wg = g * weight[:, None]
    A = np.swapaxes(wg, 1, 2) @ g
    toward = (g * x).sum(axis=2)
    return A, (wg * toward[..., None]).sum(axis=1)


def _noise_influence(moved, window, follows, level):
    """Derivatives of corners (N, 2, K, 2) in half windows by gradients, and SD (N,) px.

    Of corners that were localised until q vanished; the SD is that of the level's
    noise, infinite where the fit does not respond to a shift of the window.
    window: see `variances`.
    """
    invertible = np.linalg.det(follows) > MIN_RESPONSE_DET
    inverse = np.linalg.inv(np.where(invertible[:, None, None], follows, np.eye(2)))
    moved = np.einsum("nab,nbkc->nakc", inverse, moved)
    in_px = np.einsum("nab,nbkc->nakc", window, moved)
    variance = variances(in_px, window, level).mean(axis=1)
    return moved, np.where(invertible, np.sqrt(variance), np.inf)


def _inner_outer_difference(fits, follows, moved, window, level):
    """Disagreement of two parts of a window about its corner, (N, 2): along u and v.

    In SDs of the level's noise alone. The inner and the outer part of the edges
    determine the corner independently. They follow a shift of the window, which noise
    moves, by different amounts. In the window of a small square noise moves both
    alike, but aliasing does not: their difference is then in SDs of that of two parts
    with the SD of the corner each. Point-symmetric disturbances (blur, motion blur,
    thick ink, clipped whites, edges that cross at a sharp angle) move neither.

    fits, follows: `influences` and responses of the two parts; moved: see
    `_noise_influence`.
    """
    (inner, inner_moved), (outer, outer_moved) = fits
    shifted = np.einsum("nab,nbkc->nakc", follows[0] - follows[1], moved)
    noise = variances(inner_moved - outer_moved - shifted, window, level)
    scale = np.maximum(noise, 2 * variances(moved, window, level)) + 1e-12
    return np.sqrt(((inner - outer) ** 2 + scale - noise) / scale)


def misfit_of(g, x, weight):
    """Fraction (N,) of the edge strength that does not point at the corner."""
    across = (g * x).sum(axis=2)
    length = np.sqrt((g**2).sum(axis=2) * (x**2).sum(axis=1))
    total = np.maximum((weight * length**2).sum(axis=1), 1e-9)
    return (weight * across**2).sum(axis=1) / total
