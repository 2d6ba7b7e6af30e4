"""Ray bundle adjustment: poses of a general camera and points of the scene together.

Input are several images of a rigid scene. The residuals are the distances of rays from
their points, in standard deviations of the ray. The points follow the poses: for every
trial of poses each point has its best position, and the poses' normal matrix has the
points eliminated (Schur complement).

Gauge: the world is the first view's frame, whose pose is fixed. A general camera's rays
determine the scale; where they do not, or it is known, the distance between the first
view and another is fixed. Frame: the camera's, the same in all views; mm, rad.

Source: Ramalingam, Lodha, Sturm 2006, doi:10.1016/j.cviu.2006.06.006; Triggs et al.
2000, doi:10.1007/3-540-44480-7_21 (elimination, gauge).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.cameras.core.base import Rays, centrality, closest_point
from raxel.errors import CalibrationError
from raxel.geometry.least_squares import descend
from raxel.geometry.poses import inverse_pose, pose, tangent_bases
from raxel.multiview.generalised_motion import inverse_information
from raxel.multiview.points import (
    MAX_DISTANCE_SD_RATIO,
    PlacedPoints,
    PointSystem,
    RayTracks,
    RayView,
    euclidean,
    inverses,
    moved_poses,
    settled_points,
)
from raxel.multiview.ray_noise import COINCIDENCE_TOL, with_noise

N_FIRST_STEPS, N_FOLLOWING_STEPS, MAX_N_STEPS = 30, 4, 60
COST_TOL, ROUNDING_TOL = 1e-10, 1e-22
MIN_N_POINTS = 5  # points in each view
MAX_INFINITY_FRACTION = 0.5  # points at infinity


class RayBundle(NamedTuple):
    """Poses of a general camera and points of the scene, with covariances.

    Attributes
    ----------
    T_view_world : ndarray of shape (V, 4, 4)
        Poses, mm; the first is as given.
    points : ndarray of shape (N, 3)
        Points, mm; NaN if not used.
    used : ndarray of shape (N,)
        Points that took part, bool.
    open_points : ndarray of shape (N,)
        Used points uncertain by more than a third of their distance from the rays'
        centre in the nearest view, bool.
    rms : float
        RMS of all residuals, in standard deviations of the rays.
    costs : ndarray
        Sums of squared residuals from the start on.
    converged : bool
        Whether the iteration converged.
    variance : float
        Last cost over the degrees of freedom: 1 if the noise of the rays is as
        predicted, NaN without degrees of freedom.
    covariance : ndarray of shape (6 V, 6 V)
        Covariance of (w, v) of each view. The view rotates by w (rad), in its frame,
        about `centre`, which is displaced by v (mm).
    point_covariance : ndarray of shape (N, 3, 3)
        Covariance of each point, mm^2.
    centre : ndarray of shape (3,)
        Centre of the rays, mm.
    spread : float
        RMS distance of the rays from the centre, mm.
    rays : int
        Number of rays.
    """

    T_view_world: np.ndarray
    points: np.ndarray
    used: np.ndarray
    open_points: np.ndarray
    rms: float
    costs: np.ndarray
    converged: bool
    variance: float
    covariance: np.ndarray
    point_covariance: np.ndarray
    centre: np.ndarray
    spread: float
    rays: int

    def shift(self, view: int) -> NDArray[np.float64]:
        """Return the shift (3,) of the rays' centre between the first view and another.

        It is the first centre as seen from the other view, frame of the other view,
        mm.
        """
        T = self.T_view_world[view] @ inverse_pose(self.T_view_world[0])
        return T[:3, :3] @ self.centre + T[:3, 3] - self.centre

    def scale_sd(self, view: int) -> float:
        """Return the standard deviation of a view's distance, as a share of it.

        The distance is that from the first view. It is 0 for a distance that was held.
        """
        u, own = self.shift(view), slice(6 * view + 3, 6 * view + 6)
        variance = u @ self.covariance[own, own] @ u
        return float(np.sqrt(max(variance, 0.0)) / (u @ u))

    def rotation_sd(self, view: int) -> float:
        """Return the root of the summed variances of a view's three rotations, rad."""
        own = slice(6 * view, 6 * view + 3)
        return float(np.sqrt(np.trace(self.covariance[own, own])))


def bundle_rays(
    views: Sequence[RayView],
    T_view_world: ArrayLike,
    *,
    points: ArrayLike | None = None,
    held: int | None = None,
    stated: bool = True,
    most: int = MAX_N_STEPS,
) -> RayBundle:
    """Adjust poses and points to the rays of V views.

    Points with fewer than two rays are excluded. Points that the start puts behind a
    ray start at infinity.

    Parameters
    ----------
    views : sequence of RayView
        Rays of the views, V >= 2.
    T_view_world : array_like of shape (V, 4, 4)
        Start poses, mm.
    points : array_like of shape (N, 3), optional
        Start points, mm. None: the points nearest to the lines of their rays.
    held : int, optional
        Index of a view whose centre keeps its start distance from that of the first
        view. It is required if the rays do not determine the scale.
    stated : bool
        Whether the noise of the rays is known. Otherwise covariances are scaled by the
        scatter of the residuals.
    most : int
        Maximum number of iterations.

    Returns
    -------
    RayBundle
        Poses and points with their covariances.

    Raises
    ------
    CalibrationError
        With code ``shape``, ``held-view`` or ``too-few-points``. ``no-scale`` for rays
        through one point with nothing held, and for a scale that grew beyond all
        bounds.

    References
    ----------
    Ramalingam, Lodha, Sturm 2006, doi:10.1016/j.cviu.2006.06.006; Triggs et al. 2000,
    doi:10.1007/3-540-44480-7_21.
    """
    T = np.array(T_view_world, float)
    _check_shapes(len(views), T, held)
    centre, spread = _centre(views)
    _check_scale(T, centre, spread, held)
    seen, used, h = _start(views, T, points, centre)
    problem = _Poses(seen, held, PlacedPoints(*seen.poses(T), h))  # type: ignore[call-arg]
    state, costs, converged = descend(
        problem.evaluate,
        problem.move,
        settled_points(seen, problem.start, N_FIRST_STEPS)[0],
        iterations=most,
        tolerance=COST_TOL,
        rounding=ROUNDING_TOL * len(h),
    )
    if held is None and np.mean(state.h[:, 3] <= 0) > MAX_INFINITY_FRACTION:
        raise CalibrationError(
            "bundle: the scale diverged (undetermined by the rays); fix the distance "
            "of a view from the first",
            code="no-scale",
        )
    return _described(problem, state, costs, converged, used, spread, stated)


class _Poses:
    """The views' poses as unknowns, points eliminated, gauge fixed.

    start: PlacedPoints. Steps are (w, v) of all views, about the rays' centre; allowed
    ones are D y, D (6 V, p) by `free`.
    """

    def __init__(self, seen, held, start):
        self.seen, self.held, self.start = seen, held, start
        if held is not None:
            self.length = np.linalg.norm(self._baseline(start))

    def evaluate(self, state):
        """Cost and equations, in the form that `descend` requires."""
        system = PointSystem(self.seen, state)
        return system.cost.sum(), lambda: self._reduced(system)[:2]

    def move(self, state, step):
        """State after a step (p,), with re-estimated points."""
        steps = (self.free(state) @ step).reshape(-1, 6)
        moved = moved_poses(state, steps)
        if self.held is not None:
            moved = self._with_held_distance(moved)
        return settled_points(self.seen, moved, N_FOLLOWING_STEPS)[0]

    def free(self, state):
        """D (6 V, p) at a state: the first view and a fixed distance do not change."""
        D = np.eye(6 * len(state.R))[:, 6:]
        if self.held is None:
            return D
        # No step of the view with a fixed distance along its baseline.
        u = self._baseline(state)
        across = tangent_bases((u / np.linalg.norm(u))[None])[0]
        first = 6 * (self.held - 1) + 3
        rows = slice(6 * self.held + 3, 6 * self.held + 6)
        D[rows, first : first + 2] = across
        return np.delete(D, first + 2, axis=1)

    def _baseline(self, state):
        """(3,): centre of the first view's rays in the frame of the held view."""
        R = state.R[self.held] @ state.R[0].T
        return state.t[self.held] - R @ state.t[0]

    def _with_held_distance(self, state):
        u = self._baseline(state)
        t = state.t.copy()
        t[self.held] += u * (self.length / np.linalg.norm(u) - 1)
        return state._replace(t=t)

    def _reduced(self, system):
        """(normal (p, p), gradient (p,), coupling (6 V, N, 3), inverses (N, 3, 3)):
        poses with the points eliminated, and the terms of the elimination."""
        by_place = system.by_place()
        A, B = system.by_poses(by_place), system.by_points(by_place)
        views, count = A.shape[:2]
        inverse = inverses(np.einsum("vnki,vnkj->nij", B, B))
        e = system.residuals
        coupling = np.einsum("vnki,vnkj->vinj", A, B).reshape(6 * views, count, 3)
        taken = np.einsum("pnj,njk->pnk", coupling, inverse)
        flat = coupling.reshape(6 * views, -1)
        normal = -taken.reshape(6 * views, -1) @ flat.T
        own = np.einsum("vnki,vnkj->vij", A, A)
        for v in range(views):
            normal[6 * v : 6 * v + 6, 6 * v : 6 * v + 6] += own[v]
        gradient = np.einsum("vnki,vnk->vi", A, e).ravel()
        by_points = np.einsum("vnki,vnk->ni", B, e)
        gradient -= taken.reshape(6 * views, -1) @ by_points.ravel()
        D = self.free(system.state)
        return D.T @ normal @ D, D.T @ gradient, coupling, inverse

    def covariances(self, state):
        """(6 V, 6 V) of the steps and (N, 3, 3) of the points, internal units."""
        system = PointSystem(self.seen, state)
        normal, _, coupling, inverse = self._reduced(system)
        D = self.free(state)
        poses = D @ inverse_information(normal) @ D.T
        taken = np.einsum("pnj,njk->npk", coupling, inverse)
        points = inverse + np.einsum("npi,pq,nqj->nij", taken, poses, taken)
        X, by_step = euclidean(state.h)
        return poses, by_step @ points @ np.swapaxes(by_step, 1, 2), X


def _described(problem, state, costs, converged, used, spread, stated):
    seen = problem.seen
    covariance, of_points, X = problem.covariances(state)
    rays = int(seen.mask.sum())
    freedom = 2 * rays - 3 * len(X) - problem.free(state).shape[1]
    variance = float(costs[-1] / freedom) if freedom > 0 else np.nan
    scale = 1.0 if stated else variance
    unit = np.tile(np.repeat([1.0, seen.metre], 3), len(state.R))
    points = np.full((len(used), 3), np.nan)
    point_covariance = np.full((len(used), 3, 3), np.nan)
    points[used] = seen.metre * X
    point_covariance[used] = scale * seen.metre**2 * of_points
    away = np.einsum("vij,nj->vni", state.R, X) + state.t[:, None]
    near = np.where(seen.mask, np.linalg.norm(away, axis=2), np.inf).min(axis=0)
    largest = np.sqrt(scale * np.linalg.eigvalsh(of_points)[:, 2])
    open_points = np.zeros(len(used), bool)
    open_points[used] = (state.h[:, 3] <= 0) | ~(largest < MAX_DISTANCE_SD_RATIO * near)
    t = seen.metre * state.t + seen.centre
    return RayBundle(
        pose(state.R, t),
        points,
        used,
        open_points,
        float(np.sqrt(costs[-1] / (2 * rays))),
        costs,
        converged,
        variance,
        scale * unit[:, None] * covariance * unit,
        point_covariance,
        seen.centre,
        spread,
        rays,
    )


def _start(views, T, points, centre):
    """(RayTracks, used (N,), h (n, 4)): adjusted points and their initial values."""
    seen = RayTracks(views)
    R, t = seen.poses(T)
    middle = seen.midpoints(R, t) if points is None else np.asarray(points, float)
    if middle.shape != (seen.mask.shape[1], 3):
        raise CalibrationError(
            f"bundle: found points {middle.shape} for {seen.mask.shape[1]} points of "
            "the rays; give one each"
        )
    middle = np.where(np.isfinite(middle).all(axis=1)[:, None], middle, np.nan)
    used = seen.mask.sum(axis=0) >= 2
    number = np.cumsum(used) - 1
    retained = [_only(view, used, number) for view in views]
    counts = [len(view.points) for view in retained]
    if min(counts) < MIN_N_POINTS:
        raise CalibrationError(
            f"bundle: view {int(np.argmin(counts))} shares {min(counts)} points with "
            f"other views; give {MIN_N_POINTS} or more",
            code="too-few-points",
        )
    middle = middle[used]
    reach = np.linalg.norm(middle[np.isfinite(middle[:, 0])], axis=1)
    metre = np.median(reach) if len(reach) else 1.0
    seen = RayTracks(retained, used.sum(), metre, centre)
    return seen, used, seen.starts(*seen.poses(T), middle)


def _only(view, used, number):
    rays = with_noise(view.rays)
    index = np.arange(len(rays.origins)) if view.points is None else view.points
    index = np.asarray(index)
    return RayView(rays.of(used[index]), number[index[used[index]]])


def _centre(views):
    """(centre (3,), spread): of the rays of all views, in the camera's frame."""
    rays = [with_noise(view.rays) for view in views]
    o, d = (np.concatenate([getattr(r, f) for r in rays]) for f in Rays._fields[:2])
    both = Rays(o, d, np.ones(len(o), bool))
    spread, centre = centrality(both), closest_point(both)
    reach = np.abs(o).max() + np.abs(centre).max()
    return centre, spread if spread > COINCIDENCE_TOL * reach else 0.0


def _check_shapes(count, T, held):
    if count < 2 or T.shape != (count, 4, 4):
        raise CalibrationError(
            f"bundle: found {count} views and poses {T.shape}; give two or more views "
            "with a pose (4, 4) each",
            code="shape",
        )
    whole = isinstance(held, (int, np.integer)) and not isinstance(held, bool)
    if held is not None and not (whole and 0 < held < count):
        raise CalibrationError(
            f"bundle: held: found view {held}; give one from 1 to {count - 1}",
            code="held-view",
        )


def _check_scale(T, centre, spread, held):
    if held is not None:
        motion = T[held] @ inverse_pose(T[0])
        separation = np.linalg.norm(motion[:3, :3] @ centre + motion[:3, 3] - centre)
        if not separation > COINCIDENCE_TOL * (
            np.abs(centre).max() + np.abs(T[:, :3, 3]).max()
        ):
            raise CalibrationError(
                f"bundle: view {held} has a fixed distance of 0 from the first; give "
                "another start",
                code="held-view",
            )
    if held is None and not spread:
        raise CalibrationError(
            "bundle: all rays pass through one point (undetermined scale); fix the "
            "distance of a view from the first",
            code="no-scale",
        )
