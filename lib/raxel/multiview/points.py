"""Points from two or more rays in known poses, each with its covariance.

Two estimates: the point with the least squared distances from its rays' lines, which is
linear (thesis 5.3.5), and the point with the smallest residuals in standard deviations
of the ray noise. The former gives all rays equal weight, near and far.

Source: Ramalingam, Lodha, Sturm 2006, doi:10.1016/j.cviu.2006.06.006 (the linear one).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from raxel.errors import CalibrationError
from raxel.geometry.poses import rotation_from_vector, tangent_bases
from raxel.multiview.ray_noise import are_rotations, with_noise

# Points seen along rays from several positions: residuals, derivatives, best points. A
# point is a unit vector h = (x, w) with X = x / w, so points at infinity need no
# special case. In a view with pose (R, t) and a ray (o, d) it is at U = R x + t w - o
# w, z = d . U, r = w / z (inverse depth), and B^T U / z, with B two vectors across d,
# is the tangent of the angle by which the ray misses it, in two components. Noise of
# origin and direction adds a covariance C(r) = C_dd + r (C_od + C_od^T) + r^2 C_oo, and
# L^-1 B^T U / z with C = L L^T is the residual, two values of unit variance. The
# derivative of C is included: without it, points would move to where the rays are
# uncertain. Frames: the world's and the views'; `metre` is the internal unit of length.


MIN_NORM = 1e-30
MAX_N_POINTS = 10_000_000
FIRST_DAMPING, MIN_DAMPING, MAX_DAMPING = 1e-6, 1e-12, 1e6
DAMPING_DECREASE, DAMPING_INCREASE = 0.1, 10.0
COST_TOL = 1e-14


class RayView(NamedTuple):
    """Rays of one view and the points that they see.

    Attributes
    ----------
    rays : NoisyRays or Rays
        Rays (n,) in the frame of the view, mm. Rays without noise are treated as by
        `angular_rays`.
    points : array_like of shape (n,), optional
        Index of the point of each ray, integers. None: ray k sees point k.
    """

    rays: object
    points: object = None


class PlacedPoints(NamedTuple):
    """Poses R (V, 3, 3), t (V, 3) of the views and points h (N, 4)."""

    R: np.ndarray
    t: np.ndarray
    h: np.ndarray


class RayTracks:
    """Rays of V views as arrays (V, N, ...), with `mask` where a point is seen.

    They start at their pivots, `back` (V, N) behind their origins: a mirror is far in
    front of these, and a weakly determined scale may put points in between. views:
    RayViews; count: N, by default one more than the largest point number; metre: mm;
    centre (3,): the internal origin of the views. Raises CalibrationError for numbers
    that do not fit.
    """

    def __init__(self, views, count=None, metre=1.0, centre=(0.0, 0.0, 0.0)):
        listed = [_listed(view) for view in views]
        most = max((max(index, default=-1) for _, index in listed), default=-1) + 1
        count = most if count is None else count
        if not count or most > count:
            raise CalibrationError(
                f"points: rays see point {most - 1}, but there are {count}; give "
                "matching rays and points"
            )
        self.metre, self.centre = float(metre), np.asarray(centre, float)
        self.mask = np.zeros((len(listed), count), bool)
        self.o = np.zeros((*self.mask.shape, 3))
        self.d = np.broadcast_to([0.0, 0.0, 1.0], self.o.shape).copy()
        self.C = np.broadcast_to(np.eye(6), (*self.mask.shape, 6, 6)).copy()
        unit = np.repeat([1 / self.metre, 1.0], 3)
        self.back = np.zeros(self.mask.shape)
        for v, (rays, index) in enumerate(listed):
            if len(np.unique(index)) < len(index):
                raise CalibrationError(
                    f"points: view {v} sees a point along two rays; give one ray"
                )
            self.mask[v, index] = True
            pivots, _ = rays.pivots()
            back = np.einsum("ni,ni->n", rays.origins - pivots, rays.directions)
            self.back[v, index], rays = back / self.metre, rays.slid(-back)
            self.o[v, index] = (rays.origins - self.centre) / self.metre
            self.d[v, index] = rays.directions
            self.C[v, index] = unit[:, None] * rays.covariance * unit
        self.B = tangent_bases(self.d.reshape(-1, 3)).reshape(*self.o.shape, 2)
        Bt = np.swapaxes(self.B, 2, 3)
        oo, od, dd = (
            Bt @ self.C[..., i : i + 3, j : j + 3] @ self.B
            for i, j in ((0, 0), (0, 3), (3, 3))
        )
        self.spread = dd, od + np.swapaxes(od, 2, 3), oo

    def poses(self, T_view_world):
        """Internal (R (V, 3, 3), t (V, 3)) of poses (V, 4, 4); CalibrationError where
        they are not finite."""
        T = np.asarray(T_view_world, float)
        if not np.isfinite(T).all():
            raise CalibrationError("points: poses of views must be finite; remove NaN")
        if not are_rotations(T[:, :3, :3]):
            raise CalibrationError(
                "points: poses of views must be rigid; give a rotation and a "
                "translation"
            )
        return T[:, :3, :3], (T[:, :3, 3] - self.centre) / self.metre

    def homogeneous(self, points):
        """h (N, 4) of points (N, 3), mm."""
        h = np.concatenate([points / self.metre, np.ones((len(points), 1))], axis=1)
        return h / np.linalg.norm(h, axis=1, keepdims=True)

    def starts(self, R, t, middle):
        """h (N, 4) of points (N, 3), mm; at infinity, along the mean of its rays, for a
        point that is NaN or behind a ray."""
        h = self.homogeneous(np.nan_to_num(middle))
        behind = PointSystem(self, PlacedPoints(R, t, h)).behind | np.isnan(
            middle[:, 0]
        )
        d = np.einsum("vji,vnj,vn->ni", R, self.d, self.mask)
        d /= np.maximum(np.linalg.norm(d, axis=1, keepdims=True), MIN_NORM)
        away = np.concatenate([d, np.zeros((len(d), 1))], axis=1)
        return np.where(behind[:, None], away, h)

    def midpoints(self, R, t):
        """Points (N, 3), mm, with the least squared distances from their rays' lines;
        NaN for parallel or single lines."""
        o = np.einsum("vji,vnj->vni", R, self.o - t[:, None])
        d = np.einsum("vji,vnj->vni", R, self.d)
        across = self.mask[..., None, None] * (
            np.eye(3) - d[..., :, None] * d[..., None, :]
        )
        normal, right = across.sum(0), np.einsum("vnij,vnj->ni", across, o)
        values, V = np.linalg.eigh(normal)
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.where(values > COST_TOL, 1 / values, np.nan)
        return self.metre * np.einsum("nij,nj,nkj,nk->ni", V, share, V, right)


class PointSystem:
    """Residuals (V, N, 2) of PlacedPoints, zero where not seen, and derivatives.

    cost: (N,) of each point; infinite where it is behind a ray.
    """

    def __init__(self, seen, state):
        self.seen, self.state = seen, state
        x, w = state.h[:, :3], state.h[:, 3:]
        self.placed = np.einsum("vij,nj->vni", state.R, x) + state.t[:, None] * w
        U = self.placed - seen.o * w
        z = np.einsum("vni,vni->vn", seen.d, U)
        self.behind = np.any((z <= 0) & seen.mask, axis=0)
        self.z = np.where(seen.mask & (z > 0), z, 1.0)
        self.r = w[:, 0] / self.z
        self.y = np.einsum("vnij,vni->vnj", seen.B, U) / self.z[..., None]
        dd, both, oo = seen.spread
        r = self.r[..., None, None]
        self.L = _lower(dd + r * both + r**2 * oo)
        self.by_r = both + 2 * r * oo
        self.residuals = _solved(self.L, self.y) * seen.mask[..., None]
        cost = np.einsum("vnk,vnk->n", self.residuals, self.residuals)
        self.cost = np.where(self.behind, np.inf, cost)

    def by_place(self):
        """Derivatives (V, N, 2, 3) by U, and (V, N, 2) by w in depth alone."""
        seen, z = self.seen, self.z[..., None]
        half = _half(self.L, self.by_r, self.residuals)
        across = np.swapaxes(seen.B, 2, 3) - self.y[..., None] * seen.d[..., None, :]
        J = _solved(self.L[..., None], across) / z[..., None]
        J = (
            J
            + half[..., None]
            * (self.r[..., None] / z)[..., None]
            * seen.d[..., None, :]
        )
        mask = seen.mask[..., None]
        return J * mask[..., None], -half / z * mask

    def by_points(self, by_place=None):
        """(V, N, 2, 3), by the points' steps of `moved_points`."""
        J, own = by_place or self.by_place()
        lever = self.state.t[:, None] - self.seen.o
        by_w = np.einsum("vnki,vni->vnk", J, lever) + own
        by_x = np.einsum("vnki,vij->vnkj", J, self.state.R)
        return np.concatenate([by_x, by_w[..., None]], axis=3) @ tangents(self.state.h)

    def by_poses(self, by_place=None):
        """(V, N, 2, 6), by the views' steps (w, v): exp([w]x) R, exp([w]x) t + v."""
        J, _ = by_place or self.by_place()
        w = np.cross(self.placed[..., None, :], J)
        return np.concatenate([w, J * self.state.h[:, None, 3:]], axis=3)


def tangents(h):
    """(N, 4, 3): three unit vectors across each of h (N, 4) and each other."""
    mirror = h.copy()
    mirror[:, 3] += np.where(h[:, 3] < 0, -1.0, 1.0)
    mirror /= np.linalg.norm(mirror, axis=1, keepdims=True)
    return np.eye(4)[:, :3] - 2 * mirror[:, :, None] * mirror[:, None, :3]


def moved_points(h, step):
    """h (N, 4) after steps (N, 3)."""
    moved = h + np.einsum("nij,nj->ni", tangents(h), step)
    return moved / np.linalg.norm(moved, axis=1, keepdims=True)


def moved_poses(state, steps):
    """The state after steps (V, 6) of the views."""
    turn = rotation_from_vector(steps[:, :3])
    t = np.einsum("vij,vj->vi", turn, state.t) + steps[:, 3:]
    return state._replace(R=turn @ state.R, t=t)


def settled_points(seen, state, steps):
    """State with the best points for its poses: independent damped steps per point."""
    damping = np.full(len(state.h), FIRST_DAMPING)
    system = PointSystem(seen, state)
    for _ in range(steps):
        J = system.by_points()
        normal = np.einsum("vnki,vnkj->nij", J, J)
        gradient = np.einsum("vnki,vnk->ni", J, system.residuals)
        size = np.sqrt(np.maximum(np.einsum("nii->ni", normal), MIN_NORM))
        normal = normal / (size[:, :, None] * size[:, None])
        normal += damping[:, None, None] * np.eye(3)
        step = -np.linalg.solve(normal, (gradient / size)[:, :, None])[:, :, 0] / size
        trial = PointSystem(seen, state._replace(h=moved_points(state.h, step)))
        better = trial.cost < system.cost
        rest = not np.any(trial.cost < (1 - COST_TOL) * system.cost)
        damping *= np.where(better, DAMPING_DECREASE, DAMPING_INCREASE)
        damping = np.clip(damping, MIN_DAMPING, MAX_DAMPING)
        state = state._replace(h=np.where(better[:, None], trial.state.h, state.h))
        system = PointSystem(seen, state)
        if rest:
            break
    return state, system


def euclidean(h):
    """Points (N, 3) of h (N, 4), and their derivatives (N, 3, 3) by `moved_points`."""
    X = h[:, :3] / h[:, 3:]
    by_h = np.concatenate(
        [np.broadcast_to(np.eye(3), (len(h), 3, 3)), -X[:, :, None]], 2
    )
    return X, by_h @ tangents(h) / h[:, 3, None, None]


def _listed(view):
    if not isinstance(view, RayView):
        raise CalibrationError(
            f"points: views: found {type(view).__name__}; give RayView(rays, points) "
            "for each"
        )
    rays = with_noise(view.rays)
    index = view.points
    index = np.arange(len(rays.origins)) if index is None else np.asarray(index)
    whole = index.dtype.kind in "iu" and index.shape == (len(rays.origins),)
    if not whole or index.min(initial=0) < 0 or index.max(initial=0) >= MAX_N_POINTS:
        raise CalibrationError(
            f"points: found numbers {index.shape} {index.dtype} for "
            f"{len(rays.origins)} rays; give an integer for each, from 0 to below "
            f"{MAX_N_POINTS}"
        )
    return rays, index


def _lower(C):
    """Cholesky factor's (11, 21, 22), each (V, N), of symmetric C (V, N, 2, 2)."""
    a = np.sqrt(np.maximum(C[..., 0, 0], MIN_NORM))
    b = C[..., 1, 0] / a
    return np.stack([a, b, np.sqrt(np.maximum(C[..., 1, 1] - b**2, MIN_NORM))])


def _solved(L, y):
    """L^-1 y of factors (3, V, N) and y (V, N, 2), or (V, N, 2, k) with L (..., 1)."""
    first = y[:, :, 0] / L[0]
    return np.stack([first, (y[:, :, 1] - L[1] * first) / L[2]], axis=2)


def _half(L, D, e):
    """Phi e (V, N, 2): Phi the lower half of L^-1 D L^-T, its diagonal halved; the
    residual e = L^-1 y of a factor that changes by D changes by -Phi e."""
    a, b, c = L
    one = D[..., 0, 0] / a
    two = (D[..., 1, 0] - b * one) / c
    cross = (D[..., 1, 1] - b * D[..., 0, 1] / a) / c
    k_21 = two / a
    k_22 = (cross - k_21 * b) / c
    return np.stack(
        [one / a * e[..., 0] / 2, k_21 * e[..., 0] + k_22 * e[..., 1] / 2], axis=2
    )


N_STEPS = 20
# Maximum standard deviation of the inverse distance, over that value, of a finite
# point: three standard deviations.
MAX_DISTANCE_SD_RATIO = 1 / 3
MIN_ANGLE_SINE, MIN_EIGENVALUE_RATIO, MIN_TRIANGULATED = 1e-9, 1e-15, 1e-60
DETERMINED, TOO_FEW_RAYS, PARALLEL_RAYS, UNDETERMINED_DISTANCE, BEHIND_RAY = (
    "",
    "fewer than two rays",
    "parallel rays",
    "open distance",
    "behind a ray",
)


class Triangulation(NamedTuple):
    """Points from rays of several views, with their covariances.

    Attributes
    ----------
    points : ndarray of shape (N, 3)
        Points in the world frame, mm; NaN if not valid.
    valid : ndarray of shape (N,)
        Whether a point has a position, bool.
    reason : ndarray of shape (N,)
        Reason why a point is not valid, "" if valid.
    covariance : ndarray of shape (N, 3, 3)
        Covariance of each point, mm^2.
    rms : ndarray of shape (N,)
        RMS of the residuals of a point, in standard deviations of the rays; 1 if the
        noise is as predicted.
    angle : ndarray of shape (N,)
        Largest angle between two rays of a point, rad.
    distance_sd : ndarray of shape (N,)
        Standard deviation of the distance from the nearest ray's pivot, as a share of
        it.
    variance : float
        Squares of all residuals over their degrees of freedom.
    """

    points: np.ndarray
    valid: np.ndarray
    reason: np.ndarray
    covariance: np.ndarray
    rms: np.ndarray
    angle: np.ndarray
    distance_sd: np.ndarray
    variance: float

    def __str__(self):
        words, counts = np.unique(self.reason[~self.valid], return_counts=True)
        left = ", ".join(f"{n} {word}" for word, n in zip(words, counts, strict=True))
        return f"{self.valid.sum()} of {len(self.valid)} points" + (
            f"; left out: {left}" if left else ""
        )


def triangulate(
    views: Sequence[RayView],
    T_view_world: ArrayLike,
    *,
    linear: bool = False,
    stated: bool = True,
) -> Triangulation:
    """Triangulate the points that rays of V views see.

    Points with fewer than two rays, with parallel rays or rays nearly parallel for
    their noise, and points behind a ray are flagged. They have no position. Of points
    nearly too far away, those pass whose parallax is enlarged by noise. Near a
    `distance_sd` of a third, points are biased towards the camera. The covariance does
    not include this bias.

    Parameters
    ----------
    views : sequence of RayView
        Rays of the V views.
    T_view_world : array_like of shape (V, 4, 4)
        Poses of the views, mm.
    linear : bool
        Whether to return the points nearest to the lines instead of those of least
        residuals.
    stated : bool
        Whether the noise of the rays is known. Otherwise its size is estimated from the
        residuals of all points together.

    Returns
    -------
    Triangulation
        Points in the world frame, mm, with covariances and reasons of rejection.

    Raises
    ------
    CalibrationError
        For numbers of views, poses or points that do not match.

    References
    ----------
    Thesis 5.3.5. Ramalingam, Lodha, Sturm 2006, doi:10.1016/j.cviu.2006.06.006.

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.cameras import PerspectiveCamera
    >>> from raxel.multiview import RayView, rays_of_pixels, triangulate
    >>> K = np.array([[500, 0, 320], [0, 500, 240], [0, 0, 1.0]])
    >>> camera = PerspectiveCamera(K, [], 640, 480)
    >>> T_view_world = np.stack([np.eye(4), np.eye(4)])
    >>> T_view_world[1, 0, 3] = -100.0
    >>> pixels = [[[320, 240]], [[270, 240]]]
    >>> views = [RayView(rays_of_pixels(camera, p, sd_px=0.1)) for p in pixels]
    >>> (triangulate(views, T_view_world).points.round(3) + 0.0).tolist()
    [[0.0, 0.0, 1000.0]]
    """
    T = np.asarray(T_view_world, float)
    if T.shape != (len(views), 4, 4):
        raise CalibrationError(
            f"triangulation: found {len(views)} views and poses {T.shape}; give one "
            "pose per view"
        )
    seen = RayTracks(views)
    middle = seen.midpoints(*seen.poses(T))
    reach = np.linalg.norm(middle[np.isfinite(middle[:, 0])], axis=1)
    seen = RayTracks(views, metre=np.median(reach) if len(reach) else 1.0)
    R, t = seen.poses(T)
    angle = largest_angles(seen, R)
    parallel = ~np.isfinite(middle[:, 0]) | ~(np.sin(angle) > MIN_ANGLE_SINE)
    h = seen.homogeneous(np.nan_to_num(middle))
    if linear:
        system = PointSystem(seen, PlacedPoints(R, t, h))
    else:
        starts = PlacedPoints(R, t, seen.starts(R, t, middle))
        system = settled_points(seen, starts, N_STEPS)[1]
    return _described(seen, system, parallel, angle, linear, stated)


def largest_angles(seen, R):
    """(N,), rad: largest angle between two rays of a point; 0 for a single ray."""
    d = np.einsum("vji,vnj->nvi", R, seen.d)
    away = np.zeros(seen.mask.shape[1])
    for v in range(1, len(R)):
        both = seen.mask[v] & seen.mask[:v]
        across = np.linalg.norm(np.cross(d[:, v, None], d[:, :v]), axis=2).T
        along = np.einsum("ni,nui->un", d[:, v], d[:, :v])
        turn = np.where(both, np.arctan2(across, along), 0.0)
        away = np.maximum(away, turn.max(axis=0))
    return away


def _described(seen, system, parallel, angle, linear, stated):
    h, rays = system.state.h, seen.mask.sum(axis=0)
    short = np.any(seen.mask & (seen.back * system.r >= 1), axis=0)
    behind, fit = system.behind | short | (h[:, 3] < 0), rays >= 2
    usable = fit & ~parallel & ~behind
    freedom = np.sum(2 * rays[usable] - 3)
    variance = float(system.cost[usable].sum() / freedom) if freedom else np.nan
    with np.errstate(all="ignore"):
        X, by_step = euclidean(h)
        if linear:
            covariance = _of_midpoints(seen, system)
        else:
            spread = _of_best(system)
            covariance = by_step @ spread @ np.swapaxes(by_step, 1, 2)
        covariance = covariance if stated else variance * covariance
        sd = _distance_sd(seen, system.state, X, covariance)
    far = ~system.behind & ~(sd < MAX_DISTANCE_SD_RATIO)
    reason = np.select(
        [~fit, parallel, far, behind],
        [TOO_FEW_RAYS, PARALLEL_RAYS, UNDETERMINED_DISTANCE, BEHIND_RAY],
        default=DETERMINED,
    )
    valid = reason == DETERMINED
    keep = valid[:, None]
    return Triangulation(
        np.where(keep, seen.metre * X, np.nan),
        valid,
        reason,
        np.where(keep[:, None], seen.metre**2 * covariance, np.nan),
        np.where(valid, np.sqrt(system.cost / np.maximum(2 * rays, 1)), np.nan),
        angle,
        np.where(parallel | ~fit, np.inf, sd),
        variance,
    )


def _of_best(system):
    """(N, 3, 3): covariance of the steps of points with the smallest residuals."""
    J = system.by_points()
    return inverses(np.einsum("vnki,vnkj->nij", J, J))


def _of_midpoints(seen, system):
    """(N, 3, 3): covariance of the points closest to the lines, world frame."""
    a, b, c = system.L / system.r
    across = np.swapaxes(seen.B, 2, 3) @ system.state.R[:, None]
    across = across * seen.mask[..., None, None]
    errors = [a[..., None] * across[:, :, 0] + b[..., None] * across[:, :, 1]]
    errors.append(c[..., None] * across[:, :, 1])
    normal = inverses(np.einsum("vnki,vnkj->nij", across, across))
    return normal @ sum(np.einsum("vni,vnj->nij", e, e) for e in errors) @ normal


def inverses(normal):
    """Inverses (N, 3, 3) of normal matrices; large for undetermined directions."""
    size = np.sqrt(np.maximum(np.einsum("nii->ni", normal), MIN_TRIANGULATED))
    scale = size[:, :, None] * size[:, None]
    values, V = np.linalg.eigh(normal / scale)
    values = np.maximum(values, MIN_EIGENVALUE_RATIO)
    return (V / values[:, None]) @ np.swapaxes(V, 1, 2) / scale


def _distance_sd(seen, state, X, covariance):
    """(N,): standard deviation of a point's distance from the nearest pivot of its
    rays, over that distance."""
    centres = -np.einsum("vji,vj->vi", state.R, state.t)
    origins = np.einsum("vji,vnj->vni", state.R, seen.o) + centres[:, None]
    away = X - origins
    distance = np.where(seen.mask, np.linalg.norm(away, axis=2), np.inf)
    nearest = np.argmin(distance, axis=0), np.arange(len(X))
    along, distance = away[nearest], distance[nearest]
    variance = np.einsum("ni,nij,nj->n", along, covariance, along)
    return np.sqrt(variance) / distance**2
