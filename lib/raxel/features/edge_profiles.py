"""Sub-pixel localisation of edges near given positions, along given normals.

Near an edge the grey levels are those of one straight edge, smoothed by lens and
pixels: low + (high - low) Phi((t - p) / s), with t the distance along the normal of the
edge and Phi the normal distribution. The model is fitted to the pixels themselves,
without interpolation. p is where the smoothed gradient is steepest.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ndtr

from raxel.errors import InputError

MAX_ITERATIONS, FIRST_DAMPING, MIN_DAMPING, MAX_DAMPING = 30, 1e-3, 1e-9, 1e6
STEP_TOL_PX = 1e-6
FIRST_BLUR_PX, MIN_BLUR_PX = 0.7, 0.05  # px
MIN_CONTRAST_SIGMAS = 6.0  # standard deviations of what is left, that an edge is high
MIN_CONTRAST_RATIO = 1e-4  # of the greys: smaller steps are not edges


class EdgePoints(NamedTuple):
    """Hold edges localised by `edge_points`.

    Attributes
    ----------
    pixels : np.ndarray
        (N, 2) pixels (u, v), NaN where no edge was found.
    sigma : np.ndarray
        (N,) px, predicted standard deviation along the normal.
    blur : np.ndarray
        (N,) px, standard deviation of the smoothing.
    found : np.ndarray
        (N,) bool.
    """

    pixels: np.ndarray
    sigma: np.ndarray
    blur: np.ndarray
    found: np.ndarray


def edge_points(
    image: ArrayLike,
    positions: ArrayLike,
    normals: ArrayLike,
    half_across: float | np.ndarray = 4.0,
    half_along: float = 1.5,
) -> EdgePoints:
    """Localise edges near given positions of an image, each along its normal.

    An edge of either sense is found. It must be within `half_across` of its position
    and MIN_CONTRAST_SIGMAS times as high as the standard deviation of the residuals.
    Positions that are not finite have no edge. Neighbours whose windows overlap share
    errors.

    Parameters
    ----------
    image : ArrayLike
        (H, W) grey levels, proportional to light. A gamma moves edges, those of a dark
        line both by as much towards its middle.
    positions : ArrayLike
        (N, 2) pixels (u, v).
    normals : ArrayLike
        (N, 2) vectors of any length across the edges.
    half_across : float or np.ndarray
        Half size in px of each window along the normal, a number or (N,), at least 1.5.
        Only one edge, nearly straight, should be in the window.
    half_along : float
        Half size in px of each window across the normal, at least 0.5.

    Returns
    -------
    EdgePoints
        Positions, predicted standard deviations and blur.

    Raises
    ------
    InputError
        `bad-input` for an image of another shape, or for windows that are too small.

    Examples
    --------
    >>> import numpy as np
    >>> from scipy.special import ndtr
    >>> from raxel.features import edge_points
    >>> image = np.tile(10 + 200 * ndtr(np.arange(24) - 11.3), (24, 1))
    >>> edge = edge_points(image, [[11.0, 12.0]], [[1.0, 0.0]])
    >>> np.round(edge.pixels, 3).tolist(), np.round(edge.blur, 3).tolist()
    ([[11.3, 12.0]], [1.0])
    """
    image = np.asarray(image, float)
    if image.ndim != 2:
        raise InputError(
            f"edges: image: found shape {image.shape}; give grey levels (H, W)"
        )
    points, directions = np.asarray(positions, float), np.asarray(normals, float)
    half_across = np.broadcast_to(np.asarray(half_across, float), len(points))
    if not ((half_across >= 1.5).all() and half_along >= 0.5):
        raise InputError(
            f"edges: window: found +-{half_across.min():.3g} x {half_along} px; "
            "give at least 1.5 px across the edge and 0.5 px along it"
        )
    with np.errstate(invalid="ignore", divide="ignore"):
        directions = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    count = len(points)
    pixels = np.full((count, 2), np.nan)
    sigma, blur = np.full(count, np.nan), np.full(count, np.nan)
    reach = int(np.ceil(np.hypot(half_across.max(initial=0), half_along)))
    rows = np.flatnonzero(_inside(image.shape, points, directions, reach))
    if len(rows):
        window = _windows(
            image, points[rows], directions[rows], reach, half_across[rows], half_along
        )
        edge, spread, settled = _fitted(*window)
        good = settled & (np.abs(edge[:, 0]) < half_across[rows])
        at, edge = rows[good], edge[good]
        pixels[at] = points[at] + edge[:, :1] * directions[at]
        sigma[at], blur[at] = spread[good], np.exp(edge[:, 1])
    return EdgePoints(pixels, sigma, blur, np.isfinite(sigma))


def _inside(shape, positions, normals, reach):
    height, width = shape
    with np.errstate(invalid="ignore"):
        low, high = (
            positions >= reach,
            positions <= np.array([width, height]) - 1 - reach,
        )
    finite = np.isfinite(positions).all(axis=1) & np.isfinite(normals).all(axis=1)
    return finite & low.all(axis=1) & high.all(axis=1)


def _windows(image, positions, normals, reach, half_across, half_along):
    """Grey levels, distances along the normal, and which pixels count: (N, S) each."""
    v, u = np.mgrid[-reach : reach + 1, -reach : reach + 1].reshape(2, -1)
    middle = np.rint(positions).astype(int)
    columns, rows = middle[:, :1] + u, middle[:, 1:] + v
    offsets = np.stack([columns, rows], axis=2) - positions[:, None]
    t = np.einsum("nsi,ni->ns", offsets, normals)
    along = offsets[..., 0] * -normals[:, 1:] + offsets[..., 1] * normals[:, :1]
    counts = (np.abs(t) <= half_across[:, None]) & (np.abs(along) <= half_along)
    return image[rows, columns], t, counts


def _fitted(greys, t, counts):
    """Levenberg's method on each window: edges (N, 4), SD (N,), converged (N,).

    An edge is (position, log blur, low, high); the SD is that of the position.
    """
    edge, damping = _start(greys, t, counts), np.full(len(t), FIRST_DAMPING)
    residuals, J = _residuals(edge, greys, t, counts)
    cost = np.sum(residuals**2, axis=1)
    moved = np.full(len(t), np.inf)
    for _ in range(MAX_ITERATIONS):
        normal = np.einsum("nsi,nsj->nij", J, J)
        gradient = np.einsum("nsi,ns->ni", J, residuals)
        scale = np.square(_scale(normal))
        damped = normal + (damping[:, None] * scale)[:, :, None] * np.eye(4)
        step = -np.linalg.solve(damped, gradient[..., None])[..., 0]
        step[:, :2] = np.clip(step[:, :2], -1, 1)
        trial = edge + step
        trial_residuals, trial_J = _residuals(trial, greys, t, counts)
        trial_cost = np.sum(trial_residuals**2, axis=1)
        better = trial_cost <= cost
        edge[better], cost[better] = trial[better], trial_cost[better]
        residuals[better], J[better] = trial_residuals[better], trial_J[better]
        moved[better] = np.abs(step[better, :2]).max(axis=1)
        damping = np.where(better, damping / 10, damping * 10)
        damping = np.clip(damping, MIN_DAMPING, MAX_DAMPING)
        if np.all(moved < STEP_TOL_PX):
            break
    spare = np.maximum(counts.sum(axis=1) - 4, 1)
    scatter = np.sqrt(cost / spare)
    normal = np.einsum("nsi,nsj->nij", J, J)
    scale = _scale(normal)
    share = np.linalg.inv(
        normal / (scale[:, :, None] * scale[:, None]) + 1e-12 * np.eye(4)
    )
    spread = scatter * np.sqrt(np.maximum(share[:, 0, 0], 0)) / scale[:, 0]
    high = np.abs(edge[:, 3] - edge[:, 2])
    widest = np.abs(np.where(counts, t, 0)).max(axis=1) / 2
    min_height = np.maximum(
        MIN_CONTRAST_SIGMAS * scatter, MIN_CONTRAST_RATIO * np.abs(greys).max(axis=1)
    )
    settled = (high > min_height) & (np.exp(edge[:, 1]) < widest)
    return edge, spread, settled & (moved < 1e-2)


def _scale(normal):
    """Roots (N, 4) of the diagonals of matrices, 1 where they are zero."""
    scale = np.sqrt(np.einsum("nii->ni", normal))
    return np.where(scale > 0, scale, 1.0)


def _start(greys, t, counts):
    """Start values (N, 4): mean grey levels of both ends, and a position between."""
    far = np.where(counts, t, 0)
    reach = np.abs(far).max(axis=1, keepdims=True)
    low, high = (
        np.sum(greys * side, axis=1) / np.maximum(side.sum(axis=1), 1)
        for side in (counts & (t < -reach / 2), counts & (t > reach / 2))
    )
    # The sum of a step from low to high determines the fraction that is high.
    total = counts.sum(axis=1)
    step = np.where(np.abs(high - low) > 0, high - low, 1.0)
    share = (np.sum(greys * counts, axis=1) / total - low) / step
    position = reach[:, 0] * np.clip(1 - 2 * share, -0.8, 0.8)
    return np.column_stack(
        [position, np.full(len(t), np.log(FIRST_BLUR_PX)), low, high]
    )


def _residuals(edge, greys, t, counts):
    """Model less grey levels (N, S), 0 where excluded, and derivatives (N, S, 4)."""
    position, low, high = edge[:, :1], edge[:, 2:3], edge[:, 3:]
    blur = np.maximum(np.exp(edge[:, 1:2]), MIN_BLUR_PX)
    z = (t - position) / blur
    share, bell = ndtr(z), np.exp(-z * z / 2) / np.sqrt(2 * np.pi)
    residuals = low + (high - low) * share - greys
    slope = -(high - low) * bell
    J = np.stack([slope / blur, slope * z, 1 - share, share], axis=2)
    return residuals * counts, J * counts[..., None]
