"""Bundle adjustment that also moves the centre, and comes out right (`ext_`).

Section 4.1.4 tried to free the camera's centre and gave it up: the distance of rays
from points shrinks when the noise itself is made smaller, by a centre that moves or a
grid that tilts. Here a residual lies in the plane of its grid, where it was measured,
and is whitened with a matrix that does not follow the parameters. So no parameter can
make the noise smaller than it is, and with more rays the estimate tends to the truth.

Adjusted are the centre, the poses of all grids but the base, and one direction per ray.
`raxel.calibration.adjust.ray_elimination` has the equations.
"""

from typing import NamedTuple

import numpy as np

from raxel.calibration.adjust.bundle import check_shared
from raxel.calibration.adjust.ray_elimination import (
    BEND,
    LOSSES,
    moved,
    normal_equations,
    steps_of_poses,
)
from raxel.calibration.adjust.whitening import (
    frozen_whitening,
    squared_residuals,
    start_directions,
)
from raxel.errors import CalibrationError, InputError
from raxel.geometry.damped import damped_step

# The weights are frozen anew when the first adjustment is as close as this, in SDs.
CLOSE = 0.1
RESOLUTION = 1e-13  # steps this small, against the scene, are rounding
SINGULAR = 1e-10  # smallest over largest eigenvalue, all unknowns in like units
FIRST_DAMPING = 1e-9
MAX_DAMPING = 1e6
MEDIAN = 2 * np.log(2)  # of a chi square with two degrees of freedom


class ConsistentResult(NamedTuple):
    """centre (3,), T_base_grid (n, 4, 4), the base grid's kept, and directions (N, 3),
    unit, base frame; NaN for a ray that sees no grid.

    covariance (6 n - 3, 6 n - 3): of the centre (mm, base frame), then of each grid but
    the base its rotation vector w (rad, its own frame: the true one is R exp([w]x)) and
    its translation (mm, base frame). noise: SD of the whitened residuals, the noise of
    directions in rad where no sigma was given, and near 1 where one was; a given sigma
    is taken at its word by the covariance.
    cost: sum of the loss of the squared whitened residuals; reduced_chi_square: cost
    over degrees_of_freedom. passes: how often all rays were gone through. converged:
    whether it came to rest within the iterations allowed. whitening (n, N, 3) float32:
    the weights, frozen; the first is 0 for points that are not used.
    """

    centre: np.ndarray
    T_base_grid: np.ndarray
    directions: np.ndarray
    covariance: np.ndarray
    noise: float
    cost: float
    reduced_chi_square: float
    degrees_of_freedom: int
    passes: int
    converged: bool
    whitening: np.ndarray


class _State(NamedTuple):
    centre: np.ndarray
    T_base_grid: np.ndarray
    equations: object
    converged: bool
    passes: int


def adjust_consistent(
    points,
    seen,
    centre,
    T_base_grid,
    *,
    sigma=None,
    loss="none",
    iterations=50,
    tolerance=1e-3,
):
    """Centre, poses and ray directions from a start, by whitened in-plane residuals.

    points: (n, N, 2) mm, where N rays meet n grids; entries not seen are ignored.
    seen: (n, N) bool, or None: where the points are finite. centre: (3,) and
    T_base_grid: (n, 4, 4) the start (of the linear stage, say); grid 0, the base, is
    kept.

    sigma: None for noise of the image, equal for all directions of view, whose size is
    found from the residuals; or the standard deviations of the points in mm, a number
    or (n, N) or (n, N, 2), as a decoder of active grids states them, which the
    covariance then takes at their word. The weights follow neither centre nor poses:
    they are computed at the start, and once more when the adjustment is within a tenth
    of a standard deviation of its end.
    loss: "none", "huber" (bends at 2 standard deviations) or "cauchy" (3); the scale is
    the median's, frozen with the weights. The covariance is then that of the weighted
    points, which is an approximation.
    tolerance: it ends when a step is shorter than this, in standard deviations of the
    result.

    Returns ConsistentResult. Raises CalibrationError where a grid shares fewer than
    three rays with the others (points that the start has behind the centre do not
    count), or there are more unknowns than points; InputError for a loss, a sigma or
    shapes that do not fit.
    """
    centre, T = np.asarray(centre, float), np.asarray(T_base_grid, float)
    points, seen = _checked(points, seen, T, loss)
    directions = start_directions(points, seen, centre, T)
    # Stated deviations and no loss leave nothing to freeze anew.
    rounds = (
        (tolerance,) if sigma is not None and loss == "none" else (CLOSE, tolerance)
    )
    passes = 0
    for close_enough in rounds:
        whitening = frozen_whitening(seen, directions, centre, T, sigma)
        freedom = _degrees_of_freedom(whitening)
        rays = points, whitening, directions
        bends = _frozen_loss(rays, centre, T, loss, freedom)
        state = _descend(rays, centre, T, bends, freedom, close_enough, iterations)
        centre, T = state.centre, state.T_base_grid
        passes += state.passes
    return _result(rays, state, sigma, loss, freedom, passes)


def _checked(points, seen, T, loss):
    if loss not in LOSSES:
        raise InputError(f"adjustment: loss {loss!r}; expected one of {[*LOSSES]}")
    points = np.ascontiguousarray(points, float)
    if points.ndim != 3 or points.shape[2] != 2:
        raise InputError(
            f"adjustment: field 'points': shape {points.shape} found; (n, N, 2) needed"
        )
    if T.shape != (len(points), 4, 4):
        raise InputError(
            f"adjustment: field 'T_base_grid': shape {T.shape} found;"
            f" {(len(points), 4, 4)} needed, one pose per grid"
        )
    if len(points) < 3:
        raise CalibrationError(
            f"adjustment: grids: {len(points)}; three or more determine a centre",
            code="too-few-grids",
        )
    finite = np.isfinite(points).all(axis=2)
    seen = finite if seen is None else np.asarray(seen, bool)
    if seen.shape != finite.shape or not finite[seen].all():
        raise CalibrationError(
            "adjustment: not all points that are seen are finite", code="not-finite"
        )
    return points, seen


def _degrees_of_freedom(whitening):
    used = whitening[..., 0] > 0
    check_shared(used)
    number = np.count_nonzero(used, axis=0)
    shared = number >= 2
    freedom = 2 * int(number[shared].sum() - shared.sum()) - 6 * len(whitening) + 3
    if freedom <= 0:
        raise CalibrationError(
            f"adjustment: {shared.sum()} rays see two grids or more; more are needed",
            code="too-few-rays",
        )
    return freedom


def _frozen_loss(rays, centre, T, loss, freedom):
    """Number of the loss, and the squared residual where it bends."""
    if loss == "none":
        return LOSSES[loss], 1.0
    normal_equations(rays, centre, T, settle=2)
    return LOSSES[loss], BEND[loss] ** 2 * _median_variance(rays, centre, T, freedom)


def _median_variance(rays, centre, T, freedom):
    """Variance of a whitened coordinate, from the median of the squared residuals."""
    squares = squared_residuals(rays, centre, T)
    shared = squares[:, np.count_nonzero(rays[1][..., 0], axis=0) >= 2]
    kept = 2 * np.count_nonzero(~np.isnan(shared))
    return float(np.nanmedian(shared)) / MEDIAN * kept / freedom


def _descend(rays, centre, T, bends, freedom, close_enough, iterations):
    """Levenberg-Marquardt until a step is short, in standard deviations."""
    now = normal_equations(rays, centre, T, bends, settle=2)
    if not np.isfinite(now.cost):
        raise CalibrationError(
            "adjustment: the start has points behind the centre", code="behind-centre"
        )
    damping, passes = FIRST_DAMPING, 1
    while passes <= iterations:
        step = damped_step(now.normal, now.gradient, damping)
        gain = -step @ now.gradient
        if gain * freedom <= close_enough**2 * now.cost or is_rounding(step, centre):
            return _State(centre, T, now, True, passes)
        trial = moved(centre, T, step)
        new = normal_equations(rays, *trial, bends)
        passes += 1
        if new.cost < now.cost:
            (centre, T), now = trial, new
            damping = max(damping / 10, FIRST_DAMPING)
        else:
            damping *= 10
            if damping > MAX_DAMPING:
                break
    return _State(centre, T, now, False, passes)


def is_rounding(step, centre):
    """Whether a step (mm and rad) of a scene at this distance is lost in rounding."""
    return np.abs(step).max() <= RESOLUTION * np.abs(centre).max()


def _result(rays, state, sigma, loss, freedom, passes):
    _, whitening, directions = rays
    reduced = state.equations.cost / freedom
    variance = reduced
    if loss != "none":
        variance = _median_variance(rays, state.centre, state.T_base_grid, freedom)
    noise = float(np.sqrt(variance))
    taken = noise if sigma is None else 1.0
    change = steps_of_poses(state.T_base_grid)
    covariance = taken**2 * change @ _inverse(state.equations.normal) @ change.T
    return ConsistentResult(
        state.centre,
        state.T_base_grid,
        directions,
        covariance,
        noise,
        state.equations.cost,
        float(reduced),
        freedom,
        passes,
        state.converged,
        whitening,
    )


def _inverse(normal):
    """Inverse of a normal matrix. Raises CalibrationError where it is singular."""
    unit = 1.0 / np.sqrt(np.diag(normal))
    sizes, axes = np.linalg.eigh(normal * np.outer(unit, unit))
    if not sizes[0] > SINGULAR * sizes[-1]:
        raise CalibrationError(
            "adjustment: the grids do not determine the centre; they are parallel, or"
            " too few rays are common to them",
            code="parallel-grids",
        )
    return np.outer(unit, unit) * (axes / sizes @ axes.T)
