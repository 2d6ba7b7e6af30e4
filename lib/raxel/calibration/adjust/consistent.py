"""Bundle adjustment with a free centre and a consistent estimate (`ext_`).

Section 4.1.4 freed the camera's centre without success: a moving centre or a tilting
grid reduces the noise itself, and with it the distance of rays from points. Here a
residual is in the plane of its grid, where it was measured, and is whitened with a
constant matrix. So no parameter can reduce the noise, and with more rays the estimate
converges to the true value.

Adjusted are the centre, the poses of all grids but the base, and one direction per ray.
`raxel.calibration.adjust.ray_elimination` has the equations.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from raxel.calibration.adjust.bundle import (
    BundleResult,
    check_shared,
    frozen_whitening,
    homogeneous,
    residuals_of,
    squared_residuals,
    start_directions,
)
from raxel.calibration.adjust.ray_elimination import (
    LOSS_THRESHOLD_SIGMAS,
    LOSSES,
    moved,
    normal_equations,
    steps_of_poses,
)
from raxel.calibration.pose.three_point import motion_of_points, refine_pose_ray_point
from raxel.errors import CalibrationError, InputError
from raxel.geometry.least_squares import damped_step
from raxel.geometry.planes import on_plane
from raxel.geometry.poses import (
    pose,
    rotation_from_vector,
    transform,
    vector_from_rotation,
)

# Rays through the centre and the centroid of their points (4.1.3), and its weights. A
# point P_j on grid j, at distance l_j from the centre, has an error e_j across its ray.
# The centroid with weights w_j rotates the ray by sum(w_j e_j) / sum(w_j l_j). For
# independent errors with variances v_j, w_j = l_j / v_j is optimal. Image noise has v_j
# proportional to l_j^2, so near points have larger weights; noise in mm has one v, so
# far points have. The pose covariance of a grid adds to the errors of its points and
# reduces their weight. This explains the thesis's rule, which gives the grids of the
# linear stage more weight.


def centroid_directions(
    points: np.ndarray,
    seen: np.ndarray,
    centre: np.ndarray,
    T_base_grid: np.ndarray,
    weights: ArrayLike | None = None,
) -> np.ndarray:
    """Return unit directions from the centre to the weighted centroids of the points.

    Parameters
    ----------
    points
        (n, N, 2), points of N rays on n grids, mm.
    seen
        (n, N) bool.
    centre
        (3,), camera centre in the base frame.
    T_base_grid
        (n, 4, 4), poses of the grids.
    weights
        (n,) of the grids or (n, N), above zero. None: all equal.

    Returns
    -------
    ndarray
        (N, 3). NaN for a ray that sees no grid.

    Raises
    ------
    InputError
        A weight is not above zero.
    """
    return joined_rays(points, seen, centre, weights)(T_base_grid)


def joined_rays(points, seen, centre, weights=None):
    """T_base_grid -> `centroid_directions`, for points that do not change."""
    seen = np.asarray(seen, bool)
    weights = np.ones(len(seen)) if weights is None else np.asarray(weights, float)
    weights = np.broadcast_to(weights.T, seen.T.shape).T
    if not np.all(weights > 0, where=seen):
        raise InputError(
            "rays: field 'weights': not above 0 at a seen point; give positive ones"
        )
    flat, shares = _seen_points(points, seen), np.where(seen, weights, 0.0)

    def directions(T_base_grid):
        p = _from_centre(flat, seen, centre, T_base_grid)
        middle = np.einsum("jn,jnk->nk", shares, p)
        length = np.linalg.norm(middle, axis=1, keepdims=True)
        return middle / np.where(length > 0, length, np.nan)

    return directions


def centroid_weights(
    points: np.ndarray,
    seen: np.ndarray,
    centre: np.ndarray,
    T_base_grid: np.ndarray,
    covariances: np.ndarray,
    noise: float,
    domain: str,
) -> np.ndarray:
    """Return weights of points for `centroid_directions`: length over variance.

    Errors of neighbouring points on one grid are not independent: its pose moves them
    together. The weights are the best for each ray alone.

    Parameters
    ----------
    points, seen, centre, T_base_grid
        As `centroid_directions`.
    covariances
        (n, 6, 6) of the poses: rotation vector in the grid's frame and translation in
        the base frame. Zero for those taken as exact.
    noise
        Noise of the image in rad (domain "image") or of the points in mm ("plane").
    domain
        "image" or "plane".

    Returns
    -------
    ndarray
        (n, N), weights.

    Raises
    ------
    InputError
        The domain is neither of the two.
    """
    if domain not in ("image", "plane"):
        raise InputError(f"rays: domain: found {domain!r}; give 'image' or 'plane'")
    seen = np.asarray(seen, bool)
    p = _from_centre(_seen_points(points, seen), seen, centre, T_base_grid)
    length = np.linalg.norm(p, axis=2)
    u = p / np.where(length > 0, length, 1.0)[..., None]
    variance = (noise * length) ** 2
    if domain == "plane":
        # Component of the in-plane noise across the ray, per axis.
        normal = np.einsum("jnk,jk->jn", u, T_base_grid[:, :3, 2])
        variance = noise**2 * (1.0 + normal**2) / 2
    for j, covariance in enumerate(covariances):
        variance[j] += _moved_across(points[j], T_base_grid[j], covariance, u[j])
    return np.where(seen, length / np.where(variance > 0, variance, 1.0), 0.0)


def _moved_across(points, T, covariance, u):
    """Mean variance (N,) per axis across rays u of points of a grid, from its pose."""
    motion = motion_of_points(np.nan_to_num(points), T)
    motion[:, :, 3:] = np.eye(3)
    spread = motion @ covariance @ np.swapaxes(motion, 1, 2)
    along = np.einsum("ni,nik,nk->n", u, spread, u)
    return (np.trace(spread, axis1=1, axis2=2) - along) / 2


def _seen_points(points, seen):
    """Points (n, N, 3) of the grids in their own frames, zero where not seen."""
    return on_plane(np.where(seen[..., None], points, 0.0))


def _from_centre(flat, seen, centre, T_base_grid):
    """P - C (n, N, 3) in the base frame, zero where not seen."""
    return np.where(seen[..., None], transform(T_base_grid, flat) - centre, 0.0)


# Error of the first adjustment, in SDs, below which the weights are frozen again.
WEIGHT_UPDATE_TOL_SIGMAS = 0.1
STEP_ROUNDING_TOL = 1e-13  # smaller steps, relative to the scene, are rounding
# Smallest over largest eigenvalue, all unknowns in like units.
MIN_EIGENVALUE_RATIO = 1e-10
FIRST_DAMPING = 1e-9
MAX_DAMPING = 1e6
CHI2_MEDIAN = 2 * np.log(2)  # of a chi square with two degrees of freedom


class ConsistentResult(NamedTuple):
    """Hold the result of `adjust_consistent`.

    Attributes
    ----------
    centre : ndarray, shape (3,)
        Camera centre in the base frame, mm.
    T_base_grid : ndarray, shape (n, 4, 4)
        Poses of the grids; that of the base is kept.
    directions : ndarray, shape (N, 3)
        Unit directions in the base frame, NaN for a ray without grids.
    covariance : ndarray, shape (6 n - 3, 6 n - 3)
        Covariance of the centre (mm, base frame), then for each grid but the base of
        its rotation vector w (rad, its own frame: the true one is R exp([w]x)) and its
        translation (mm, base frame). It uses a given sigma as it is.
    noise : float
        Standard deviation of the whitened residuals: noise of directions, rad, without
        sigma, and near 1 with it.
    cost : float
        Sum of the loss of the squared whitened residuals.
    reduced_chi_square : float
        Cost over `degrees_of_freedom`.
    degrees_of_freedom : int
        Number of residuals minus number of unknowns.
    passes : int
        Number of passes over all rays.
    converged : bool
        Whether the adjustment converged within the allowed iterations.
    whitening : ndarray of float32, shape (n, N, 3)
        Frozen weights; the first one is 0 for points that are not used.
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
    points: ArrayLike,
    seen: ArrayLike | None,
    centre: ArrayLike,
    T_base_grid: ArrayLike,
    *,
    sigma: ArrayLike | None = None,
    loss: str = "none",
    iterations: int = 50,
    tolerance: float = 1e-3,
) -> ConsistentResult:
    """Return centre, poses and directions, adjusted by whitened in-plane residuals.

    The weights follow neither centre nor poses. They are computed at the start, and
    once more when the adjustment is within a tenth of a standard deviation of its end.

    Parameters
    ----------
    points
        (n, N, 2), where N rays meet n grids, mm. Entries not seen are ignored.
    seen
        (n, N) bool. None: where the points are finite.
    centre
        (3,), start (of the linear stage, say), base frame.
    T_base_grid
        (n, 4, 4), start. The pose of grid 0, the base, is kept.
    sigma
        None: noise of the image, equal for all directions of view, whose size is
        estimated from the residuals. Otherwise the predicted standard deviations of the
        points in mm, a number, (n, N) or (n, N, 2), such as those of a decoder of
        active grids. The covariance then takes them as given.
    loss
        "none", "huber" (bends at 2 standard deviations) or "cauchy" (3). The scale is
        the median's, frozen with the weights. The covariance is then that of the
        weighted points, which is an approximation.
    iterations
        Largest number of steps.
    tolerance
        The adjustment ends when a step is shorter than this, in standard deviations of
        the result.

    Returns
    -------
    ConsistentResult
        Centre, poses, directions and covariance.

    Raises
    ------
    CalibrationError
        A grid shares fewer than three rays with the others, or there are more unknowns
        than points ("too-few-rays"). Points that the start has behind the centre do not
        count.
    InputError
        A loss, a sigma or shapes do not fit.

    References
    ----------
    Thesis section 4.1.4.
    """
    centre, T = np.asarray(centre, float), np.asarray(T_base_grid, float)
    points, seen = _checked(points, seen, T, loss)
    directions = start_directions(points, seen, centre, T)
    # With known standard deviations and no robust loss, weights need no update.
    rounds = (
        (tolerance,)
        if sigma is not None and loss == "none"
        else (WEIGHT_UPDATE_TOL_SIGMAS, tolerance)
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


def _checked(
    points: ArrayLike, seen: ArrayLike | None, T: np.ndarray, loss: str
) -> tuple[np.ndarray, np.ndarray]:
    if loss not in LOSSES:
        raise InputError(f"adjustment: loss: found {loss!r}; give one of {[*LOSSES]}")
    points = np.ascontiguousarray(points, float)
    if points.ndim != 3 or points.shape[2] != 2:
        raise InputError(
            f"adjustment: field 'points': found shape {points.shape}; give (n, N, 2)"
        )
    if T.shape != (len(points), 4, 4):
        raise InputError(
            f"adjustment: field 'T_base_grid': found shape {T.shape}; give "
            f"{(len(points), 4, 4)}, one pose per grid"
        )
    if len(points) < 3:
        raise CalibrationError(
            f"adjustment: found {len(points)} grids; give three or more",
            code="too-few-grids",
        )
    finite = np.isfinite(points).all(axis=2)
    seen = finite if seen is None else np.asarray(seen, bool)
    if seen.shape != finite.shape or not finite[seen].all():
        raise CalibrationError(
            "adjustment: points must be finite where seen; remove NaN and infinity",
            code="not-finite",
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
            f"adjustment: {shared.sum()} rays see two grids or more; let more rays see "
            "several grids",
            code="too-few-rays",
        )
    return freedom


def _frozen_loss(rays, centre, T, loss, freedom):
    """Index of the loss, and the squared residual at its threshold."""
    if loss == "none":
        return LOSSES[loss], 1.0
    normal_equations(rays, centre, T, settle=2)
    return LOSSES[loss], LOSS_THRESHOLD_SIGMAS[loss] ** 2 * _median_variance(
        rays, centre, T, freedom
    )


def _median_variance(rays, centre, T, freedom):
    """Variance of a whitened coordinate, from the median of the squared residuals."""
    squares = squared_residuals(rays, centre, T)
    shared = squares[:, np.count_nonzero(rays[1][..., 0], axis=0) >= 2]
    retained = 2 * np.count_nonzero(~np.isnan(shared))
    return float(np.nanmedian(shared)) / CHI2_MEDIAN * retained / freedom


def _descend(rays, centre, T, bends, freedom, close_enough, iterations):
    """Levenberg-Marquardt until a step is short, in standard deviations."""
    now = normal_equations(rays, centre, T, bends, settle=2)
    if not np.isfinite(now.cost):
        raise CalibrationError(
            "adjustment: the initial values put points behind the centre; give others",
            code="behind-centre",
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
    """Whether a step (mm and rad) is below rounding at the scale of this scene."""
    return np.abs(step).max() <= STEP_ROUNDING_TOL * np.abs(centre).max()


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
    if not sizes[0] > MIN_EIGENVALUE_RATIO * sizes[-1]:
        raise CalibrationError(
            "adjustment: the grids do not determine the centre (parallel grids, or too "
            "few common rays); tilt them more",
            code="parallel-grids",
        )
    return np.outer(unit, unit) * (axes / sizes @ axes.T)


# Relaxation over the grids' poses: the bundle adjustment of the thesis (4.1.4). The
# centre is fixed. Each round moves the poses, 6 (n - 1) parameters, by one step against
# the ray-point distances (4.18) with fixed rays; then every ray is joined to the
# centroid of its points. The rays follow, they are not adjusted. Within a round the
# poses are independent, so each has its own step of six. `raxel.calibration.adjust
# .bundle` minimises the same distances over rays and poses together. Alternation
# converges slowly: rounds are cheap, but many.


def relax_poses(
    points: np.ndarray,
    seen: ArrayLike,
    centre: np.ndarray,
    T_base_grid: np.ndarray,
    *,
    weights: ArrayLike | None = None,
    iterations: int = 500,
    tolerance: float = 1e-6,
) -> BundleResult:
    """Return poses by relaxation, rays re-joined to the centroid after each round.

    Parameters
    ----------
    points
        (n, N, 2), points of N rays on n grids, mm.
    seen
        (n, N) bool.
    centre
        (3,), camera centre in the base frame, kept.
    T_base_grid
        (n, 4, 4), start. Grid 0 is the base, whose pose is the identity.
    weights
        (n,) or (n, N), of the centroid. The thesis gives the grids of the linear stage
        more.
    iterations
        Largest number of rounds.
    tolerance
        The relaxation ends when a round changes the cost by less than this share.

    Returns
    -------
    BundleResult
        Its costs, of ray-point distances, may also rise: a round does not minimise over
        the rays.

    Raises
    ------
    CalibrationError
        A grid shares fewer than three rays with the others ("too-few-rays"), or values
        are not finite ("not-finite").

    References
    ----------
    Thesis (4.18) and section 4.1.4.
    """
    seen = np.asarray(seen, bool)
    check_shared(seen)
    unknowns = pose_vector(T_base_grid)
    joined, q = joined_rays(points, seen, centre, weights), homogeneous(points, seen)
    looks = [points[j, seen[j]] for j in range(len(points))]
    costs = []
    for _ in range(iterations + 1):
        poses = poses_of_vector(unknowns)
        u = joined(poses)
        costs.append(float(np.sum(residuals_of(q, centre, poses, u) ** 2)))
        if not np.isfinite(costs[-1]):
            raise CalibrationError(
                "relaxation: points and poses must be finite; remove NaN and infinity",
                code="not-finite",
            )
        if len(costs) > 1 and abs(costs[-2] - costs[-1]) <= tolerance * costs[-1]:
            return BundleResult(poses, u, np.array(costs), True)
        unknowns = pose_vector(_moved_once(looks, seen, centre, poses, u))
    return BundleResult(poses, u, np.array(costs), False)


def pose_vector(T_base_grid: np.ndarray) -> np.ndarray:
    """Return the unknowns: Rodrigues vector and translation of all but the base.

    Parameters
    ----------
    T_base_grid
        (n, 4, 4), poses of the grids.

    Returns
    -------
    ndarray
        (6 (n - 1),), rad and the unit of the poses.
    """
    turns = vector_from_rotation(T_base_grid[1:, :3, :3])
    return np.concatenate([turns, T_base_grid[1:, :3, 3]], axis=1).ravel()


def poses_of_vector(unknowns):
    """Poses (n, 4, 4) of a vector (6 (n - 1),), the base's first."""
    both = unknowns.reshape(-1, 2, 3)
    moving = pose(rotation_from_vector(both[:, 0]), both[:, 1])
    return np.concatenate([np.eye(4)[None], moving])


def _moved_once(looks, seen, centre, poses, u):
    """Poses after one step each, with fixed rays; looks: the seen points of each
    grid."""
    moved = poses.copy()
    for j in range(1, len(poses)):
        moved[j], _ = refine_pose_ray_point(
            u[seen[j]], looks[j], poses[j], origins=centre, iterations=1
        )
    return moved
