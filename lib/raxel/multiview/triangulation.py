"""Points from two or more rays in known places, each with its covariance.

Two ways: the point nearest on average to its rays' lines, which is linear (thesis
5.3.5), and the one that its rays miss least in standard deviations of their noise. The
former weighs all rays alike, near and far.
Source: Ramalingam, Lodha, Sturm 2006, doi:10.1016/j.cviu.2006.06.006 (the linear one).
"""

from typing import NamedTuple

import numpy as np

from raxel.errors import CalibrationError
from raxel.multiview.ray_points import (
    PlacedPoints,
    PointSystem,
    RayTracks,
    euclidean,
    settled_points,
)

STEPS = 20
# A point whose distance is known to no better than this share of itself may as well be
# at infinity: three standard deviations of one over the distance.
OPEN = 1 / 3
LEAST_SINE, LEAST_SHARE, LEAST = 1e-9, 1e-15, 1e-60
FINE, FEW, PARALLEL, FAR, BEHIND = (
    "",
    "fewer than two rays",
    "parallel rays",
    "open distance",
    "behind a ray",
)


class Triangulation(NamedTuple):
    """points (N, 3), mm, world frame, NaN where not valid; valid (N,) bool; reason
    (N,): why not, "" where valid; covariance (N, 3, 3), mm^2; rms (N,): of a point's
    residuals, in standard deviations of the rays, 1 where noise is as stated; angle
    (N,): the largest between two of its rays, radians; distance_sd (N,): share of the
    distance from its nearest ray's pivot by which it is uncertain; variance: squares of
    all residuals over their degrees of freedom."""

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


def triangulate(views, T_view_world, *, linear=False, stated=True):
    """Triangulation of the points that rays of V views see.

    views: RayViews (V); T_view_world: (V, 4, 4), mm; linear: nearest to the lines, else
    of least residuals. stated: whether the rays know the size of their noise; else all
    is told by the scatter of the residuals, of all points together. Points with fewer
    than two rays, with rays that are parallel or nearly so for their noise, and behind
    a ray are flagged and have no place. Of points that are nearly too far away those
    pass whose parallax noise has made larger: near a `distance_sd` of a third of the
    distance they are biased nearer, and the covariance does not say so. Raises
    CalibrationError for numbers that do not fit.
    """
    T = np.asarray(T_view_world, float)
    if T.shape != (len(views), 4, 4):
        raise CalibrationError(
            f"triangulation: {len(views)} views and poses {T.shape}; give one for each"
        )
    seen = RayTracks(views)
    middle = seen.midpoints(*seen.poses(T))
    reach = np.linalg.norm(middle[np.isfinite(middle[:, 0])], axis=1)
    seen = RayTracks(views, metre=np.median(reach) if len(reach) else 1.0)
    R, t = seen.poses(T)
    angle = largest_angles(seen, R)
    parallel = ~np.isfinite(middle[:, 0]) | ~(np.sin(angle) > LEAST_SINE)
    h = seen.homogeneous(np.nan_to_num(middle))
    if linear:
        system = PointSystem(seen, PlacedPoints(R, t, h))
    else:
        starts = PlacedPoints(R, t, seen.starts(R, t, middle))
        system = settled_points(seen, starts, STEPS)[1]
    return _described(seen, system, parallel, angle, linear, stated)


def largest_angles(seen, R):
    """(N,), radians: between any two rays of a point; 0 for a single one."""
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
    far = ~system.behind & ~(sd < OPEN)
    reason = np.select(
        [~fit, parallel, far, behind], [FEW, PARALLEL, FAR, BEHIND], default=FINE
    )
    valid = reason == FINE
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
    """(N, 3, 3): covariance of the steps of points of least residuals."""
    J = system.by_points()
    return inverses(np.einsum("vnki,vnkj->nij", J, J))


def _of_midpoints(seen, system):
    """(N, 3, 3): covariance of points nearest to the lines, world frame."""
    a, b, c = system.L / system.r
    across = np.swapaxes(seen.B, 2, 3) @ system.state.R[:, None]
    across = across * seen.mask[..., None, None]
    off = [a[..., None] * across[:, :, 0] + b[..., None] * across[:, :, 1]]
    off.append(c[..., None] * across[:, :, 1])
    normal = inverses(np.einsum("vnki,vnkj->nij", across, across))
    return normal @ sum(np.einsum("vni,vnj->nij", e, e) for e in off) @ normal


def inverses(normal):
    """Inverses (N, 3, 3) of normal matrices; large where one leaves something open."""
    size = np.sqrt(np.maximum(np.einsum("nii->ni", normal), LEAST))
    scale = size[:, :, None] * size[:, None]
    values, V = np.linalg.eigh(normal / scale)
    values = np.maximum(values, LEAST_SHARE)
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
