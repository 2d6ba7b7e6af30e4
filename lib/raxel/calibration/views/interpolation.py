"""Points of a chessboard between its corners: three interpolations of a cell.

- "homographic": the exact homography of each cell's four corners (step 2 of the
  thesis's Algorithm 1, section 3.2). It is exact for a pinhole camera; under a fisheye
  or a mirror its error is a fraction of the bend of a cell.
- "smooth": a C1 surface through all corners, sampled as a finer lattice with cells of
  negligible bend. It interpolates pixels times the perspective weight of the board's
  best homography, so it is exact for a pinhole camera as well.
- "by need": for each board, the one of the two with the smaller error, as estimated
  from its own corners (`_bends`).

All further functions (`pixels_on_board`, `locate_pixels`, `ray_table`) work on the view
of either lattice.
"""

from __future__ import annotations

import numpy as np

from raxel.calibration.views.correspondence import (
    BoardView,
    board_cells,
    cell_turns,
    check_view,
)
from raxel.calibration.views.dense import DenseView
from raxel.geometry.homography import homography_dlt

# Smooth surface through the corners of a lattice: C1 and exact at every corner. Between
# corners each quantity is a bicubic Hermite patch. Its slopes at a corner are those of
# the polynomial through up to five neighbours in the row or column. A hole or the edge
# only reduces the order, and a corner does not affect distant cells.


MAX_N_SLOPE_CORNERS = 5  # corners of a row or column that determine one slope


def refined_lattice(lattice, factor):
    """Surface at `factor` points per cell along both axes.

    lattice: (rows, columns, ...), NaN where unknown. Returns (factor (rows - 1) + 1,
    factor (columns - 1) + 1, ...), NaN in cells that lack a corner; the given corners
    are every factor-th point, unchanged.
    """
    down, along = _slopes(lattice, 0), _slopes(lattice, 1)
    # Next to a hole the two orders of computing slopes can differ.
    twist = (_slopes(down, 1) + _slopes(along, 0)) / 2
    lattice, along = _refined(lattice, down, factor), _refined(along, twist, factor)
    return _refined(lattice.swapaxes(0, 1), along.swapaxes(0, 1), factor).swapaxes(0, 1)


def refining_weights(count, factor):
    """(factor (count - 1) + 1, count): weights of `refined_lattice` along one line."""
    unit = np.eye(count)
    return _refined(unit, _slopes(unit, 0), factor)


def _refined(values, slopes, factor):
    """Cubic Hermite interpolation along the first axis."""
    t = np.arange(1, factor).reshape(-1, *[1] * (values.ndim - 1)) / factor
    before, after = values[:-1, None], values[1:, None]
    rise, fall = slopes[:-1, None], slopes[1:, None]
    between = (
        (1 + 2 * t) * (1 - t) ** 2 * before
        + t * (1 - t) ** 2 * rise
        + t**2 * (3 - 2 * t) * after
        + t**2 * (t - 1) * fall
    )
    fine = np.concatenate([before, between], axis=1)
    return np.concatenate([fine.reshape(-1, *values.shape[1:]), values[-1:]])


def _slopes(values, axis):
    """Derivatives per step along one axis, NaN without a known neighbour.

    The longest run of known corners counts, and among equals the one whose middle is
    nearest.
    """
    values = np.moveaxis(values, axis, 0)
    slopes = np.full(values.shape, np.nan)
    for first, weights in _STENCILS:
        low, high = max(0, -first), len(values) + 1 - first - len(weights)
        if high <= low:
            continue
        there = slopes[low:high]
        found = sum(
            weight * values[low + first + k : high + first + k]
            for k, weight in enumerate(weights)
        )
        there[:] = np.where(np.isnan(there), found, there)
    return np.moveaxis(slopes, 0, axis)


def _stencils():
    """(first neighbour, weights): slopes at 0 of polynomials through neighbours."""
    found = []
    for count in range(MAX_N_SLOPE_CORNERS, 1, -1):
        for first in sorted(range(1 - count, 1), key=lambda f: abs(2 * f + count - 1)):
            powers = np.vander(first + np.arange(count), increasing=True).T
            found.append((first, np.linalg.solve(powers, np.eye(count)[1])))
    return found


_STENCILS = _stencils()


INTERPOLATIONS = ("homographic", "smooth", "by need")
TRIAL_POINTS_PER_CELL = 4  # per axis, where both interpolations are compared
MAX_CELL_BEND_PX = 0.015  # of a cell of the finer lattice
MAX_SUBDIVISION = 16  # cells of the finer lattice per cell, per axis
MIN_CORNER_SD_PX = 1e-3  # highest accuracy of a corner
MAX_N_TERMS = 120  # of a polynomial through corners
EVEN_TOL = 1e-6  # differences of steps over the size of the board
MIN_WEIGHT_RATIO = 0.02  # smallest over largest perspective weight


def interpolated_view(
    view: BoardView | DenseView, interpolation: str
) -> tuple[BoardView | DenseView, str]:
    """Return the view whose cells follow the board by an interpolation, and its name.

    Cells that lack a corner, are not convex, or in which the surface folds are
    excluded. A board without even spacing stays "homographic". A DenseView needs no
    interpolation: it is returned as it is, with "none".

    Parameters
    ----------
    view : BoardView or DenseView
        The view.
    interpolation : str
        One of INTERPOLATIONS.

    Returns
    -------
    view : BoardView or DenseView
        The view itself with "homographic", one of a finer lattice with "smooth".
    name : str
        The interpolation that was applied.

    Raises
    ------
    ValueError
        If `interpolation` is another name.
    InputError
        As `check_view`.
    """
    if interpolation not in INTERPOLATIONS:
        names = "', '".join(INTERPOLATIONS)
        raise ValueError(f"interpolation: found {interpolation!r}; give '{names}'")
    view = check_view(view)
    if view.every_pixel:
        return view, "none"
    smooth = interpolation != "homographic" and _is_even(view)
    if not smooth or not cell_turns(view).any():
        return view, "homographic"
    differences = _differences(view)
    if interpolation == "by need" and not _bends(view, differences):
        return view, "homographic"
    return _finer(view, np.abs(differences).max()), "smooth"


def _is_even(view):
    """Whether rows and columns are evenly spaced, as the smooth surface assumes.

    Corners of AprilTags and staggered circles are not.
    """
    lattice = view.points.reshape(view.rows, view.columns, 2)
    second = [np.abs(np.diff(lattice, 2, axis=k)).max(initial=0) for k in (0, 1)]
    return max(second) < EVEN_TOL * np.ptp(lattice)


def _bends(view, differences):
    """Whether the cells of a board bend by more than the uncertainty of its corners.

    Per board, not per cell: the squared difference d^2 of the two predictions, averaged
    over the insides of all cells, contains the bend b that the homography misses and
    the corners' noise, of variance s^2 along each axis. With S and H the weights of the
    corners in either (mean squares SS and HH over the cells, products SH),

        d^2 = b^2 + s^2 (SS + HH - 2 SH),
        error of the smooth one s^2 SS, of the homographic one b^2 + s^2 HH,

    so the smooth one has the smaller error where d^2 > 2 s^2 (SS - SH). The surface
    propagates noise with about 1.4 times the standard deviation of the homographies, so
    it is used only for a larger bend. s^2 is estimated from the corners themselves
    (`corner_variance`), not from the detector's estimate. A lattice that is too coarse
    for its bend has a large s^2 and stays homographic: no surface through it would be
    correct either.
    """
    noise = max(corner_variance(view), MIN_CORNER_SD_PX**2)
    price = np.prod([_mean_products(count) for count in (view.rows, view.columns)], 0)
    return np.mean(differences**2) > 2 * noise * (price[0] - price[1])


def _mean_products(count):
    """Means of S S and S H inside the cells of one line of corners."""
    place = np.arange(TRIAL_POINTS_PER_CELL * (count - 1) + 1) / TRIAL_POINTS_PER_CELL
    inside = place % 1 > 0
    S = refining_weights(count, TRIAL_POINTS_PER_CELL)[inside]
    H = np.maximum(1 - np.abs(place[inside, None] - np.arange(count)), 0)
    return np.mean(np.sum(S * S, axis=1)), np.mean(np.sum(S * H, axis=1))


def corner_variance(view):
    """Variance (px^2) of the corners along each axis, from the corners themselves.

    The minimum over polynomials of rising degree of the residual variance per degree of
    freedom: too low a degree leaves bend, each sufficient one leaves noise alone. A
    standard error is added to each, since a minimum of several estimates is biased low.
    At least a quarter of the corners remains as degrees of freedom; inf where that is
    too few for any degree.
    """
    found = np.flatnonzero(np.isfinite(view.pixels[:, 0]))
    i, j, counts = _terms(view, min(3 * len(found) // 4, MAX_N_TERMS))
    if len(counts) == 0:
        return np.inf
    y, x = np.divmod(found, view.columns)
    x = np.arccos(2 * x / (view.columns - 1) - 1)
    y = np.arccos(2 * y / (view.rows - 1) - 1)
    terms = np.cos(i * x[:, None]) * np.cos(j * y[:, None])
    weight = _perspective(view)(view.points[found])
    basis = np.linalg.qr(terms / weight[:, None])[0]
    coefficients = basis.T @ view.pixels[found]
    rest = np.sum((view.pixels[found] - basis @ coefficients) ** 2)
    left = np.array([rest + np.sum(coefficients[count:] ** 2) for count in counts])
    freedom = 2.0 * (len(found) - counts)
    return np.min(left / freedom * (1 + np.sqrt(2 / freedom)))


def _terms(view, most):
    """Exponents (i, j) of Chebyshev polynomials on a lattice, lower degrees first, and
    their number (`most` or fewer) up to each degree from 2 on."""
    i, j = np.divmod(np.arange(view.columns * view.rows), view.rows)
    order = np.lexsort([i, i + j])
    i, j = i[order], j[order]
    counts = np.searchsorted(i + j, np.arange(3, view.columns + view.rows))
    counts = counts[counts <= most]
    return i[: counts.max(initial=0)], j[: counts.max(initial=0)], counts


def _finer(view, bend):
    """View of a finer lattice on the surface through the corners, whose cells bend by
    at most `bend` px."""
    factor = int(np.clip(np.ceil(np.sqrt(bend / MAX_CELL_BEND_PX)), 2, MAX_SUBDIVISION))
    pixels, points = _surface(view, factor)
    rows, columns = pixels.shape[:2]
    fine = view._replace(
        pixels=pixels.reshape(-1, 2),
        points=points.reshape(-1, 2),
        rows=rows,
        columns=columns,
        sd=None,
    )
    # A fold of the surface excludes the whole cell, as in the coarse lattice.
    turns = cell_turns(view)
    fine_turns = cell_turns(fine).reshape(len(turns), factor, -1, factor)
    usable = (turns != 0) & (fine_turns == turns[:, None, :, None]).all(axis=(1, 3))
    known = np.zeros((rows, columns), bool)
    for down in range(factor + 1):
        ends = slice(down, rows - factor + down, factor)
        for along in range(factor + 1):
            known[ends, along : columns - factor + along : factor] |= usable
    return fine._replace(pixels=np.where(known.reshape(-1, 1), fine.pixels, np.nan))


def _surface(view, factor):
    """Pixels and points of the refined lattice, (R, C, 2) each."""
    weight = _perspective(view)
    weighted = view.pixels * weight(view.points)[:, None]
    lattice = np.concatenate([weighted, view.points], axis=1)
    fine = refined_lattice(lattice.reshape(view.rows, view.columns, 4), factor)
    weighted, points = fine[..., :2], fine[..., 2:]
    return weighted / weight(points)[..., None], points


def _perspective(view):
    """Points (..., 2) -> weight (...): the denominator of the board's homography.

    Of one sign on the board; 1 where a strong bend allows no plane of weights.
    """
    found = np.isfinite(view.pixels[:, 0])
    a, b, c = homography_dlt(view.points[found], view.pixels[found])[2]
    values = view.points @ [a, b] + c
    if values.min() < MIN_WEIGHT_RATIO * values.max():
        return lambda points: np.ones(points.shape[:-1])
    return lambda points: (points @ [a, b] + c) / values.max()


def _differences(view):
    """Smooth minus homographic positions (K, P, 2) px inside the whole cells."""
    pixels, points = _surface(view, TRIAL_POINTS_PER_CELL)
    whole = cell_turns(view) != 0
    pixels, points = (
        np.lib.stride_tricks.sliding_window_view(
            fine, (TRIAL_POINTS_PER_CELL + 1,) * 2, axis=(0, 1)
        )[::TRIAL_POINTS_PER_CELL, ::TRIAL_POINTS_PER_CELL, :, 1:-1, 1:-1][
            whole
        ].reshape(-1, 2, (TRIAL_POINTS_PER_CELL - 1) ** 2)
        for fine in (pixels, points)
    )
    maps = np.linalg.inv(board_cells(view).board_from_pixel)
    straight = maps[..., :2] @ points + maps[..., 2:]
    return np.moveaxis(pixels - straight[:, :2] / straight[:, 2:], 1, 2)
