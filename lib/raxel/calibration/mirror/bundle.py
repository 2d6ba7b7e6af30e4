"""Bundle adjustment of a flexible mirror: shapes of all stages and poses of all grids.

Stage by stage, the grid pose depends on one shape and the next shape on that pose, so
errors accumulate. Here the splines of all stages and the poses of all grids are
estimated together. The first shape is fixed or known with its covariance, and every
corner in every image counts. Not in the thesis.

Residuals are in standard deviations of a corner. An image point p moved by dp changes
the ray-point vector r (5.29) by dr = D dp, so D^+ r is the error of p, which is divided
by its standard deviation. D is computed at the start of each round.

The normal matrix has arrow form: a block for each stage, a block for each grid, and the
coupling of a stage with its grids. With about two hundred unknowns a dense solver
suffices.

Frame: that of the viewing camera; mm, rad.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.calibration.mirror.clamp import (
    Clamp,
    FixedLine,
    PriorRows,
    bending_prior,
    clamped,
    plane_through,
    soft_clamp,
)
from raxel.calibration.mirror.observations import (
    MIN_N_POSE_CORNERS,
    MIN_SD_PX,
    RayPoints,
    clamped_end,
    need_support,
    normalised,
    sighting,
    support_of,
)
from raxel.calibration.mirror.refine import camera_of_shape, ray_sd
from raxel.calibration.pose.three_point import (
    motion_of_points,
    moved_pose,
    placed_points,
)
from raxel.cameras.mirrors.spline import SplineMirrorCamera
from raxel.errors import CalibrationError, InputError
from raxel.geometry.least_squares import descend

# Least squares of the bundle adjustment: residuals and normal matrix.


# Smallest over largest eigenvalue of the scaled normal matrix: below, undetermined.
MIN_EIGENVALUE_RATIO = 1e-13


class State(NamedTuple):
    """free: unknowns (F,) of each stage, empty for a fixed one; T: grid poses."""

    free: list[np.ndarray]
    T: np.ndarray


class SeenCorners(NamedTuple):
    """One view: stage, grid, its RayPoints, points (N, 2) of the grid, sd (N,) in
    normalised units, scale (N,), px per normalised unit."""

    stage: int
    grid: int
    rays: RayPoints
    points: np.ndarray
    sd: np.ndarray
    scale: np.ndarray
    unknown_sd: bool


class BundleProblem(NamedTuple):
    """Least squares of one round. whiten: (N, 2, 3) of each view, maps ray-point
    vectors to residuals."""

    seen: list[SeenCorners]
    spaces: list
    further: list
    whiten: list[np.ndarray]

    @property
    def count(self):
        """Number of equations."""
        own = sum(len(rows) for rows, _ in self.further)
        return own + 2 * sum(len(view.points) for view in self.seen)

    def coefficients(self, state):
        return [
            space.coefficients(free)
            for space, free in zip(self.spaces, state.free, strict=True)
        ]

    def residuals(self, state):
        """Residuals (N, 2) of each view, and of the additional rows of each stage."""
        c = self.coefficients(state)
        views = []
        for view, whiten in zip(self.seen, self.whiten, strict=True):
            placed = placed_points(view.points, state.T[view.grid])
            errors = view.rays.residuals(c[view.stage], placed)
            views.append((whiten @ errors[:, :, None])[:, :, 0])
        rows = [
            rows @ one - values
            for one, (rows, values) in zip(c, self.further, strict=True)
        ]
        return views, rows

    def evaluate(self, state):
        c = self.coefficients(state)
        if not all(view.rays.in_front(c[view.stage]) for view in self.seen):
            return np.inf, None
        views, rows = self.residuals(state)
        cost = sum(np.sum(part**2) for part in [*views, *rows])
        return cost, lambda: self.equations(state, views, rows)

    def equations(self, state, views, rows):
        """Normal matrix (P, P) and half the gradient (P,): stages first, then poses."""
        starts, size = self.layout(state)
        normal, gradient = np.zeros((size, size)), np.zeros(size)
        for view, whiten, errors in zip(self.seen, self.whiten, views, strict=True):
            by_shape, by_pose = self.jacobians(view, whiten, state)
            shape = slice(*starts[view.stage : view.stage + 2])
            k = starts[-1] + 6 * view.grid
            pose = slice(k, k + 6)
            both = by_shape.T @ by_pose
            normal[shape, shape] += by_shape.T @ by_shape
            normal[pose, pose] += by_pose.T @ by_pose
            normal[shape, pose] += both
            normal[pose, shape] += both.T
            gradient[shape] += by_shape.T @ errors.ravel()
            gradient[pose] += by_pose.T @ errors.ravel()
        for stage, errors in enumerate(rows):
            shape = slice(*starts[stage : stage + 2])
            own = self.further[stage][0] @ self.spaces[stage].directions
            normal[shape, shape] += own.T @ own
            gradient[shape] += own.T @ errors
        return normal, gradient

    def jacobians(self, view, whiten, state):
        """(2N, F) with respect to the stage's unknowns, (2N, 6) to (w, s) of the
        grid."""
        space, T = self.spaces[view.stage], state.T[view.grid]
        c = space.coefficients(state.free[view.stage])
        by_shape = np.zeros((2 * len(view.points), 0))
        if space.directions.shape[1]:
            change = view.rays.jacobian(c, placed_points(view.points, T))
            by_shape = (whiten @ change).reshape(-1, change.shape[2]) @ space.directions
        by_pose = whiten @ view.rays.across(c) @ motion_of_points(view.points, T)
        return by_shape, by_pose.reshape(-1, 6)

    def layout(self, state):
        """Index of each stage's first unknown and of the poses'; total number."""
        starts = np.concatenate([[0], np.cumsum([len(f) for f in state.free])])
        return starts, starts[-1] + 6 * len(state.T)


def moved(state, step):
    """State after a step: free unknowns of all stages, then six for each pose."""
    free, start = [], 0
    for own in state.free:
        free.append(own + step[start : start + len(own)])
        start += len(own)
    steps = step[start:].reshape(-1, 6)
    return State(
        free, np.stack([moved_pose(T, s) for T, s in zip(state.T, steps, strict=True)])
    )


def inverse_of(normal):
    """Inverse of a normal matrix (K, K); CalibrationError for undetermined unknowns."""
    scale = np.sqrt(np.maximum(np.diag(normal), 1e-300))
    values, vectors = np.linalg.eigh(normal / np.outer(scale, scale))
    if not values[0] > MIN_EIGENVALUE_RATIO * values[-1]:
        raise CalibrationError(
            f"bundle: {np.sum(values <= MIN_EIGENVALUE_RATIO * values[-1])} of "
            f"{len(values)} unknowns are undetermined; show a grid in all knot "
            "intervals of each stage, each grid in two stages, or add a prior",
            code="open-coefficients",
        )
    return (vectors / values) @ vectors.T / np.outer(scale, scale)


MAX_N_ROUNDS, MAX_N_STEPS, COST_TOL, ROUNDING_TOL = 3, 30, 1e-7, 1e-12
# Number of corners with a common misfit, which averages out less than noise. Chosen on
# simulated sheets, smooth and uneven by 10 um, in poses that no test uses.
MISFIT_CORRELATION = 3.0
# Standard deviations by which residuals exceed noise before a misfit is reported.
MISFIT_SIGMAS = 3.0


class StageView(NamedTuple):
    """Hold a view of a grid in the mirror at one stage.

    A grid that was seen before and after a deflection, or over several, without being
    moved has one number.

    Attributes
    ----------
    stage : int
        Number of the stage; 0 is the first shape.
    grid : int
        Number of the grid among the poses.
    view : BoardView or DenseView
        The view.
    """

    stage: int
    grid: int
    view: object


class StageBundle(NamedTuple):
    """Hold the result of `bundle_stages`.

    Attributes
    ----------
    cameras : tuple of SplineMirrorCamera
        Camera of each stage.
    T_camera_grid : ndarray, shape (m, 4, 4)
        Poses of the grids.
    residuals : tuple of ndarray
        Errors (N, 2) of the corners in the image, px, for each view.
    costs : ndarray
        Costs of the last rounds, in squared standard deviations.
    freedom : int
        Degrees of freedom: coordinates of corners in excess of the unknowns.
    variance : float
        Squares of the corners' residuals over `freedom`, in units of their standard
        deviations (px^2 where these are not known). It is 1 for corner noise alone, and
        larger where the splines do not fit the mirror. Then all corners count less,
        also against clamp, prior and first shape.
    covariance : ndarray, shape (P, P)
        Covariance of the coefficients, stage after stage, and of (w, s) of the poses.
        It uses the corners' standard deviations so widened.
    misfit : ndarray, shape (n,)
        Standard deviation of scene rays that the splines of a stage leave, rad. It
        follows from the residuals beyond the corners' noise, and is zero where their
        standard deviations are not known.
    converged : bool
        Whether the adjustment converged.
    corners : tuple of ndarray
        Normalised image points (M, 2) of what each stage shows.
    flags : tuple of str
        Knot intervals with little support from the corners, a text for each.
    """

    cameras: tuple
    T_camera_grid: np.ndarray
    residuals: tuple
    costs: np.ndarray
    freedom: int
    variance: float
    covariance: np.ndarray
    misfit: np.ndarray
    converged: bool
    corners: tuple
    flags: tuple

    def coefficient_covariance(self, stage: int) -> NDArray[np.float64]:
        """Return the covariance (K, K) of vec(C) of a stage."""
        sizes = [camera.grid.size for camera in self.cameras]
        start = sum(sizes[:stage])
        own = slice(start, start + sizes[stage])
        return self.covariance[own, own]

    def ray_sd(self, stage: int, pixels: ArrayLike) -> NDArray[np.float64]:
        """Return the predicted standard deviation of a stage's scene rays.

        It combines the covariance with the part of the misfit that no spline can
        follow. Beyond the outermost corners it includes the
        covariance alone.

        Parameters
        ----------
        stage : int
            Number of the stage.
        pixels : array_like, shape (N, 2)
            Pixels, px.

        Returns
        -------
        ndarray, shape (N,)
            Standard deviation of each of a direction's two components, rad. NaN outside
            the knots.
        """
        camera = self.cameras[stage]
        known = ray_sd(
            normalised(camera.viewer, np.asarray(pixels, float)),
            camera.grid,
            camera.quantity,
            camera.coefficients.ravel("F"),
            self.coefficient_covariance(stage),
        )
        return np.hypot(known, self.misfit[stage])


def bundle_stages(
    cameras: Iterable[SplineMirrorCamera],
    views: Iterable[StageView],
    T_camera_grid: ArrayLike,
    *,
    clamp: Clamp | FixedLine | None = None,
    first_covariance: NDArray[np.float64] | None = None,
    prior_sd: float | None = None,
) -> StageBundle:
    """Adjust a mirror's shapes and the poses of the grids seen in it together.

    Wrong matches must be excluded before. Corners without a standard deviation count
    alike, and those outside a stage's knots not at all.

    Parameters
    ----------
    cameras : iterable of SplineMirrorCamera
        n cameras with one viewing camera: the first shape, and starts for the others.
    views : iterable of StageView
        Views of the grids.
    T_camera_grid : array_like, shape (m, 4, 4)
        Initial poses of the grids.
    clamp : Clamp, FixedLine or None
        Clamp that holds from stage 1 on.
    first_covariance : ndarray, shape (K, K), or None
        Covariance of the first shape's coefficients, which are then estimated as well.
        None: the first shape is fixed.
    prior_sd : float or None
        Standard deviation of `bending_prior` from stage 1 on, mm; None for no prior.

    Returns
    -------
    StageBundle
        Cameras and poses with their covariance.

    Raises
    ------
    InputError
        Numbers of views do not fit.
    CalibrationError
        ``too-few-corners``: too few corners. ``behind-camera``: a start behind the
        camera. ``no-feature-at-end``: knot intervals without a corner, except the
        clamp's and with a prior. ``open-coefficients``: stages or grids are
        undetermined.

    Notes
    -----
    Not in the thesis.
    """
    cameras, T = tuple(cameras), np.array(T_camera_grid, float)
    seen = _sightings(cameras, views, T)
    flags = _supported(cameras, seen, clamp, prior_sd is not None)
    further = _further(cameras, clamp, first_covariance, prior_sd)
    spaces = _spaces(cameras, clamp, first_covariance)
    free = [
        space.free(camera.coefficients.ravel("F"))
        for space, camera in zip(spaces, cameras, strict=True)
    ]
    state = State(free, T)
    widening = np.ones(len(cameras))
    problem, state, costs, converged = _settled(seen, spaces, further, state, widening)
    widening = _widening(problem, state)
    if np.any(widening != 1.0):
        problem, state, costs, converged = _settled(
            seen, spaces, further, state, widening
        )
    return _result(cameras, problem, state, costs, converged, widening, flags)


def _settled(seen, spaces, further, state, widening):
    """(problem, state, costs, converged): rounds until the corners' weights
    converge."""
    costs = []
    for _ in range(MAX_N_ROUNDS):
        whiten = _whitening(seen, spaces, state, widening)
        problem = BundleProblem(seen, spaces, further, whiten)
        state, fell, converged = descend(
            problem.evaluate,
            moved,
            state,
            iterations=MAX_N_STEPS,
            tolerance=COST_TOL,
            rounding=ROUNDING_TOL * problem.count,
        )
        costs.extend(fell)
        # After a negligible step the whitening would not change.
        if len(fell) <= 2:
            break
    return problem, state, np.array(costs), converged


def _widening(problem, state):
    """(n,): factor of the corners' variance for each stage.

    It brings the variance to its actual value where that is unknown, and includes the
    misfit, which neighbouring corners share. Corners of the first shape compete with a
    thousand points of the monitor, and with a misfit they would rotate the shape. The
    misfit of K functions has about K independent values, however many corners show it;
    the corners are weighted accordingly.
    """
    views = problem.residuals(state)[0]
    variance, freedom = _variance(problem, views, state)
    every = np.ones(len(problem.spaces))
    if problem.seen[0].unknown_sd:
        return every * max(variance, MIN_SD_PX**2)
    if variance <= 1 + MISFIT_SIGMAS * np.sqrt(2 / freedom):
        return every
    widening = every + MISFIT_CORRELATION * (variance - 1)
    first = [o for v, o in zip(problem.seen, views, strict=True) if v.stage == 0]
    if problem.spaces[0].directions.shape[1] and first:
        own = np.concatenate(first)
        beyond = max(np.mean(own**2) - 1, 0.0)
        widening[0] = 1 + beyond * own.size / len(problem.spaces[0].directions)
    return widening


def _variance(problem, views, state):
    """Sum of the corners' squared residuals per degree of freedom, and that number."""
    unknowns = problem.layout(state)[1]
    corners = sum(len(errors) for errors in views)
    if 2 * corners <= unknowns:
        raise CalibrationError(
            f"bundle: found {corners} corners for {unknowns} unknowns; show more "
            "corners, or use fewer knots",
            code="too-few-corners",
        )
    freedom = 2 * corners - unknowns
    return float(sum(np.sum(errors**2) for errors in views) / freedom), freedom


def _sightings(cameras, views, T):
    found = []
    for k, (stage, grid, view) in enumerate(views):
        if not (0 <= stage < len(cameras) and 0 <= grid < len(T)):
            raise InputError(
                f"bundle: view {k}: found stage {stage} and grid {grid}; number "
                f"{len(cameras)} stages and {len(T)} grids from 0"
            )
        camera = cameras[stage]
        one = sighting(camera.viewer, view, f"bundle: view {k}")
        inside = camera.grid.inside(one.image)
        if np.count_nonzero(inside) < MIN_N_POSE_CORNERS:
            raise CalibrationError(
                f"bundle: view {k}: found {np.count_nonzero(inside)} corners within "
                f"the knots of stage {stage}; give at least {MIN_N_POSE_CORNERS}",
                code="too-few-corners",
            )
        rays = RayPoints(one.image[inside], camera.grid, camera.quantity)
        sd, scale = one.sd[inside], one.scale[inside]
        found.append(
            SeenCorners(stage, grid, rays, one.points[inside], sd, scale, False)
        )
    if not all(np.isfinite(view.sd).all() for view in found):
        found = [v._replace(sd=np.ones(len(v.sd)), unknown_sd=True) for v in found]
    return [view._replace(sd=view.sd / view.scale) for view in found]


def _supported(cameras, seen, clamp, prior):
    """Flags of stages 1 on; CalibrationError for a stage without corners at an edge."""
    flags = []
    for stage, camera in enumerate(cameras[1:], 1):
        support = support_of(camera.grid, _corners(seen, stage))
        try:
            own = need_support(support, clamped_end(camera.grid, clamp), prior)
        except CalibrationError as error:
            raise CalibrationError(
                f"bundle: stage {stage}: {error}", code=error.code
            ) from None
        flags += [f"stage {stage}: {text}" for text in own]
    return tuple(flags)


def _spaces(cameras, clamp, first_covariance):
    """Subspace of each stage's coefficients; that of a fixed stage is empty."""
    firm = None if soft_clamp(cameras[0].grid, clamp) is not None else clamp
    spaces = [clamped(cameras[0].grid, None)]
    if first_covariance is None:
        c = cameras[0].coefficients.ravel("F")
        spaces = [spaces[0]._replace(particular=c, directions=np.zeros((len(c), 0)))]
    return spaces + [clamped(camera.grid, firm) for camera in cameras[1:]]


def _further(cameras, clamp, first_covariance, prior_sd):
    """Rows (R, K) and values (R,) of each stage, over their standard deviations."""
    found = []
    for stage, camera in enumerate(cameras):
        parts = []
        if stage == 0 and first_covariance is not None:
            values, vectors = np.linalg.eigh(first_covariance)
            sd = np.sqrt(np.maximum(values, 1e-12 * values[-1]))
            start = vectors.T @ camera.coefficients.ravel("F")
            parts = [PriorRows(vectors.T, start, sd)]
        if stage > 0:
            soft = soft_clamp(camera.grid, clamp)
            parts = [] if soft is None else [soft]
            if prior_sd is not None:
                parts.append(_prior(camera, prior_sd))
        rows = [part.rows / np.reshape(part.sd, (-1, 1)) for part in parts]
        values = [part.values / part.sd for part in parts]
        empty = np.zeros((0, camera.grid.size))
        found.append((np.vstack([empty, *rows]), np.concatenate([[], *values])))
    return found


def _prior(camera, sd):
    """Bending prior about the plane through the initial shape of a stage."""
    u, v = (np.linspace(b[0], b[-1], 7) for b in camera.grid.breaks)
    p = camera.grid.unturned(np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2))
    plane = plane_through(camera.mirror.points(p))
    return bending_prior(camera.grid, camera.quantity, plane, sd)


def _whitening(seen, spaces, state, widening):
    found = []
    for view in seen:
        c = spaces[view.stage].coefficients(state.free[view.stage])
        if not view.rays.in_front(c):
            raise CalibrationError(
                f"bundle: stage {view.stage}: the initial shape is partly behind the "
                "camera; give another one",
                code="behind-camera",
            )
        placed = placed_points(view.points, state.T[view.grid])
        shift = view.rays.image_jacobian(c, placed)
        sd = view.sd * np.sqrt(widening[view.stage])
        found.append(np.linalg.pinv(shift) / sd[:, None, None])
    return found


def _result(cameras, problem, state, costs, converged, widening, flags):
    views, rows = problem.residuals(state)
    inverse = inverse_of(problem.equations(state, views, rows)[0])
    # Convert from the widened standard deviations to those of the corners.
    views = [
        errors * np.sqrt(widening[view.stage])
        for view, errors in zip(problem.seen, views, strict=True)
    ]
    variance, freedom = _variance(problem, views, state)
    outward = _outward(problem, state)
    coefficients = problem.coefficients(state)
    found = tuple(
        camera_of_shape(camera.viewer, camera.grid, c, camera.quantity)
        for camera, c in zip(cameras, coefficients, strict=True)
    )
    in_px = tuple(
        errors * (view.sd * view.scale)[:, None]
        for errors, view in zip(views, problem.seen, strict=True)
    )
    return StageBundle(
        found,
        state.T,
        in_px,
        costs,
        freedom,
        variance,
        outward @ inverse @ outward.T,
        _misfit(problem, state, views),
        converged,
        tuple(_corners(problem.seen, stage) for stage in range(len(cameras))),
        flags,
    )


def _corners(seen, stage):
    own = [view.rays.p for view in seen if view.stage == stage]
    return np.concatenate([np.zeros((0, 2)), *own])


def _outward(problem, state):
    """(P, F): change of all coefficients and poses with the free unknowns."""
    from scipy.linalg import block_diag

    parts = [space.directions for space in problem.spaces]
    return block_diag(*parts, np.eye(6 * len(state.T)))


def _misfit(problem, state, views):
    """(n,) rad: part of the residuals of each stage's views beyond noise."""
    c = problem.coefficients(state)
    squares, counts = np.zeros(len(c)), np.zeros(len(c))
    for view, errors in zip(problem.seen, views, strict=True):
        if view.unknown_sd:
            continue
        placed = placed_points(view.points, state.T[view.grid])
        S, scene = view.rays.surface(c[view.stage])
        away = np.sum((placed - S) * scene, axis=1)
        vectors = view.rays.residuals(c[view.stage], placed)
        found = np.sum((vectors / away[:, None]) ** 2, axis=1)
        # Under noise alone the mean is 1, with standard deviation 1 / sqrt(N).
        mean, chance = np.mean(errors**2), MISFIT_SIGMAS / np.sqrt(len(errors))
        beyond = 1 - 1 / mean if mean > 1 + chance else 0.0
        squares[view.stage] += beyond * np.sum(found) / 2
        counts[view.stage] += len(errors)
    return np.sqrt(squares / np.maximum(counts, 1))
