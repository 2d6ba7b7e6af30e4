"""B-spline ray field from a table of noisy rays: less noise than a single pixel's ray.

The pixel at which the trend would image a ray, minus the ray's own pixel, is a noisy
value of the field s of a `raxel.cameras.tables.ray_spline.RaySplineCamera`, in px. The
field is a penalised spline. Cross-validation selects its cells and its smoothness. It
holds out whole squares of the image, since neighbours in a table may have common errors
(decoded points and interpolated corners do), and a smoothness selected on single pixels
would then follow the noise.
"""

from __future__ import annotations

from functools import cache, lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from raxel.calibration.smooth.boards import MIN_N_RAYS, trend_of_rays
from raxel.calibration.smooth.equations import (
    FAR_TIE_WEIGHT,
    FieldSums,
    band_of,
    band_product,
    downhill,
    far_from_data,
    free_polynomials,
    node_places,
    penalty_matrix,
)
from raxel.cameras.tables.interpolation import field_at, shares
from raxel.cameras.tables.ray_spline import RaySplineCamera
from raxel.errors import CalibrationError
from raxel.geometry.poses import pose

CELLS = (4, 8, 16, 32)  # along the image's longer side, tried in this order
SMOOTHNESS = 10.0 ** np.arange(-10, 5)  # in data of a cell; search from START_INDEX
START_INDEX = 7
N_FOLDS = 5  # of the cross-validation
MAX_N_PILOT_RAYS = 20_000  # rays for the trend and for gross errors
GROSS_SIGMAS, MIN_GROSS_PX = 8.0, 0.1  # robust standard deviations, and minimum
RAYLEIGH_MEDIAN = 1.1774  # median distance at unit standard deviation per coordinate
BLOCK = 1 << 16


class SmoothTable(NamedTuple):
    """Hold a smoothed ray table.

    Attributes
    ----------
    camera : RaySplineCamera
        The camera in the frame of the table, with region and uncertainty.
    trend : Camera
        Camera on which the field is based.
    cells : int
        Cells of the field along the longer side.
    smoothness : float
        The chosen smoothness.
    sd_px : float
        Standard deviation of a coordinate of one ray of weight 1, px: noise and what no
        field follows.
    sharing : float
        How many errors of neighbours count as one.
    held_out_px : dict of int to float
        RMS distance of held-out rays, px, at the best smoothness, by number of cells;
        0: of the trend alone.
    n_rays : int
        Number of rays that were used.
    left_out : dict of str to int
        Number of excluded rays by reason.
    """

    camera: RaySplineCamera
    trend: object
    cells: int
    smoothness: float
    sd_px: float
    sharing: float
    held_out_px: dict
    n_rays: int
    left_out: dict


class _Field(NamedTuple):
    """cells along the longer side; their sums; the smoothness; control values (rows,
    columns, 2); held_out: {cells: sum of squares of the held-out values}."""

    cells: int
    sums: FieldSums
    smoothness: float
    control: np.ndarray
    held_out: dict


def smoothed_rays(
    pixels: np.ndarray,
    directions: np.ndarray,
    width: int,
    height: int,
    *,
    centre: ArrayLike = (0.0, 0.0, 0.0),
    weights: ArrayLike | None = None,
    trend: Any = None,
    block_px: int = 16,
) -> SmoothTable:
    """Return smooth rays from unit directions at any pixels, from one centre.

    Parameters
    ----------
    pixels : ndarray, shape (N, 2)
        Pixels (u, v).
    directions : ndarray, shape (N, 3)
        Unit directions of their rays.
    width, height : int
        Size of the image, px.
    centre : array_like, shape (3,)
        Common origin of the rays.
    weights : array_like, shape (N,), or None
        Weights of the rays; None for equal ones.
    trend : tuple or None
        A camera and its pose, on which the field is based; None to fit one.
    block_px : int
        Side of the squares of pixels that are held out together, px.

    Returns
    -------
    SmoothTable
        The camera and its quality.
    """
    weights = np.ones(len(pixels)) if weights is None else np.asarray(weights, float)
    trend, T = trend or _fitted_trend(pixels, directions, width, height, centre)
    values = _displacements(trend, T, pixels, directions)
    imaged = np.isfinite(values[:, 0])
    left_out = {"beyond the trend": int(np.count_nonzero(~imaged))}
    pixels, values, weights = pixels[imaged], values[imaged], weights[imaged]
    size, every = (
        (width, height),
        slice(None, None, 1 + len(pixels) // MAX_N_PILOT_RAYS),
    )
    field = _best_field(pixels[every], values[every], weights[every], size, block_px)  # type: ignore[index]
    near = _near(field, pixels, values, weights)
    left_out["gross error"] = int(np.count_nonzero(~near))
    if every.step > 1 or not near.all():
        pixels, values, weights = pixels[near], values[near], weights[near]  # type: ignore[index]
        field = _best_field(pixels, values, weights, size, block_px)
    sd_px, inverse = _uncertainty(field)
    sharing = _sharing(field, pixels, values, weights, block_px)
    spacing = field.sums.spacing
    variance = sharing * sd_px**2 * _at_nodes(inverse, field.sums)
    camera = RaySplineCamera(
        trend, spacing, field.control, width, height,
        covered=field.sums.cells > 0,
        covariance=variance[..., None] * np.array([1.0, 0.0, 1.0]),
        T_camera_trend=T,
    )  # fmt: skip
    total = 2 * field.sums.weights.sum()
    held_out = {c: float(np.sqrt(2 * s / total)) for c, s in field.held_out.items()}
    return SmoothTable(
        camera, trend, field.cells, field.smoothness, sd_px, sharing, held_out,
        len(pixels), left_out,
    )  # fmt: skip


def _fitted_trend(pixels, directions, width, height, centre):
    every = slice(None, None, 1 + len(pixels) // MAX_N_PILOT_RAYS)
    found = trend_of_rays(pixels[every], directions[every], width, height)
    return found.camera, pose(found.R_rays_trend, np.asarray(centre, float))


def _displacements(trend, T_table_trend, pixels, directions):
    """Pixel of each ray under the trend, minus its pixel: (N, 2), NaN without one."""
    values = np.empty(pixels.shape)
    for start in range(0, len(pixels), BLOCK):
        rows = slice(start, start + BLOCK)
        seen = trend.project(directions[rows] @ T_table_trend[:3, :3])
        values[rows] = seen.pixels - pixels[rows]
    return values


def _near(field, pixels, values, weights):
    """Which values (N,) are within GROSS_SIGMAS robust standard deviations of a
    field."""
    found, _ = field_at(pixels, field.control, field.sums.spacing)
    distance = np.linalg.norm(values - found, axis=1) * np.sqrt(weights)
    sd = np.median(distance[weights > 0]) / RAYLEIGH_MEDIAN
    floor = MIN_GROSS_PX * np.sqrt(weights)
    return (weights > 0) & (distance <= GROSS_SIGMAS * sd + floor)


# --------------------------------------------------------------- cells and smoothness


def _best_field(pixels, values, weights, size, block_px):
    """_Field with the best prediction of held-out values, fitted to all."""
    if len(pixels) < MIN_N_RAYS:
        raise CalibrationError(
            f"smooth rays: found {len(pixels)} rays that the trend images; at least "
            f"{MIN_N_RAYS} are required",
            code="too-few-rays",
        )
    square = _squares(pixels, block_px)
    part = (square[:, 0] + 2 * square[:, 1]) % N_FOLDS
    best, held_out = (np.inf, None, None, None), {}
    for cells in CELLS:
        sums = FieldSums(*size, max(size) / cells, N_FOLDS)
        if held_out and len(pixels) < np.prod(sums.shape):
            break
        sums.add(pixels, values, weights, part)
        score, smoothness = _best_smoothness(sums)
        held_out[0] = float(sums.squares.sum())
        held_out[cells] = score
        if not score < best[0]:
            break  # finer cells follow the noise even more
        best = score, cells, sums, smoothness
    _, cells, sums, smoothness = best
    right = sums.right.sum(axis=0).reshape(-1, 2)
    control = _solved(sums.band(slice(None)) + _penalty(sums, smoothness), right)
    return _Field(cells, sums, smoothness, control.reshape(*sums.shape, 2), held_out)


def _best_smoothness(sums):
    """(score, smoothness): descent from START_INDEX."""
    score = cache(lambda k: _held_out(sums, SMOOTHNESS[k]))
    best = downhill(score, START_INDEX, len(SMOOTHNESS))
    return score(best), float(SMOOTHNESS[best])


def _squares(pixels, block_px):
    """Column and row (N, 2) int of the square of the image that contains each pixel."""
    return ((pixels + 0.5) // block_px).astype(np.int64)


def _held_out(sums, smoothness):
    """Sum over parts of weighted squared distances from fields fitted without them."""
    total, right = sums.band(slice(None)), sums.right.sum(axis=0).reshape(-1, 2)
    total += _penalty(sums, smoothness)
    score = 0.0
    for part in range(N_FOLDS):
        rest = right - sums.right[part].reshape(-1, 2)
        score += sums.quadratic(part, _solved(total - sums.band([part]), rest))
    return score


def _penalty(sums, smoothness, ties=True):
    """Band of the penalty, with or without far ties; smoothness 1 weighs as the data of
    one cell."""
    of_a_cell = sums.weights.sum() / max(np.count_nonzero(sums.cells), 1)
    band = smoothness * _penalty_band(sums.shape)
    if ties:
        band[0] += FAR_TIE_WEIGHT * far_from_data(sums.cells > 0)
    return of_a_cell * band


@lru_cache(maxsize=len(CELLS))
def _penalty_band(shape):
    return band_of(penalty_matrix(shape), 3 * shape[1] + 4)


def _solved(band, right):
    from scipy.linalg import solveh_banded

    return solveh_banded(band, right, lower=True, check_finite=False)


# ------------------------------------------------------------------------ uncertainty


def _uncertainty(field):
    """Standard deviation of a coordinate of one ray, px, and the inverse (K, K) of the
    normal matrix with free polynomials: the covariance of one coordinate's control
    values in units of its square."""
    sums = field.sums
    normal = sums.band(slice(None))
    penalty = _penalty(sums, field.smoothness, ties=False)
    polynomials = free_polynomials(sums.shape)
    count = len(polynomials)
    solved = _solved(
        normal + penalty, np.hstack([np.eye(count), band_product(normal, polynomials)])
    )
    inverse, by_polynomials = solved[:, :count], solved[:, count:]
    # Penalty without its part on polynomials, by Woodbury's identity.
    penalised = band_product(penalty, polynomials)
    lifted = polynomials - by_polynomials  # (normal + penalty)^-1 penalty polynomials
    inverse = inverse + lifted @ np.linalg.solve(by_polynomials.T @ penalised, lifted.T)
    taken = sum(
        (1 + (k > 0)) * np.vdot(normal[k, : count - k], np.diagonal(inverse, -k))
        for k in range(len(normal))
        if normal[k].any()
    )
    left = max(sums.cells.sum() - taken, 1)
    squares = sum(
        sums.quadratic(part, field.control.reshape(-1, 2)) for part in range(N_FOLDS)
    )
    return float(np.sqrt(max(squares, 0.0) / (2 * left))), inverse


def _at_nodes(inverse, sums):
    """Variances (rows, columns) of the field at `node_places`."""
    places = node_places(sums.shape, sums.spacing)
    index, share = shares(places.reshape(-1, 2), sums.shape, sums.spacing)
    near = inverse[index[:, :, None], index[:, None]]
    found = np.einsum("ni,nij,nj->n", share, near, share)
    return found.reshape(places.shape[:2])


def _sharing(field, pixels, values, weights, block_px):
    """Mean number of rays with a common error: 1 for independent errors.

    The square of the summed errors in a small square of the image, over the sum of
    their squares.
    """
    found, _ = field_at(pixels, field.control, field.sums.spacing)
    errors = weights[:, None] * (values - found)
    square = _squares(pixels, block_px)
    name = square[:, 1] * (square[:, 0].max() + 1) + square[:, 0]
    sums = [np.bincount(name, errors[:, k]) for k in range(2)]
    return max(1.0, float(np.sum(np.square(sums)) / np.sum(errors**2)))
