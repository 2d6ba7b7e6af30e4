"""Linear stage of the primary calibration, without points that were decoded wrongly.

Each pixel sees a point of every grid, so its scene ray is known without any model
(2.3.3), and where it comes nearest to the viewing ray lies the mirror. The normals of
the rays' pairs give a spline up to scale (5.15, 5.16); the mirror points give the
scale. Frame: the viewer's; mm.
"""

from typing import NamedTuple

import numpy as np

from raxel.calibration.generic.known_motion import rays_from_known_motion
from raxel.calibration.mirror.linear import (
    reflection_normals,
    scaled_to_points,
    shape_up_to_scale,
)
from raxel.calibration.mirror.matches import wrong_matches
from raxel.calibration.mirror.ray_points import RayPoints
from raxel.calibration.mirror.support import need_support, support_of
from raxel.calibration.pose.three_point import placed_points
from raxel.errors import CalibrationError
from raxel.geometry.spline_grid import spline_grid

# Sine of the angle between viewing ray and scene ray below which they fix no point.
GRAZING = 0.02
# mm, mean: rays of one mirror pass each other more closely than this.
LARGEST_MISS = 20.0
# Points of the grids beyond this many medians are wrong, where no median is less, mm;
# more than this share is not left out in silence.
FAR, LEAST_MM, ROUNDS, MOST_WRONG = 6.0, 0.01, 6, 0.25


class MirrorPoints(NamedTuple):
    """Where viewing rays and scene rays come nearest to each other.

    points (N, 3): amid the shortest line between both; misses (N,) mm: distance of the
    point from either ray, half of that line (the thesis's ray-point distance of 5.3.3);
    directions (N, 3): of the scene rays, unit, away from the mirror; valid (N,) bool:
    elsewhere the others are NaN.
    """

    points: np.ndarray
    misses: np.ndarray
    directions: np.ndarray
    valid: np.ndarray


def mirror_points(viewing, rays):
    """MirrorPoints of N pixels.

    viewing: (N, 3) unit directions of viewing rays, from the origin; rays:
    KnownMotionRays, whose sense does not matter: their origins, on a grid, lie ahead of
    the mirror. Not valid where a ray is missing, both are nearly parallel, or the point
    lies behind the camera.
    """
    o, d = rays.origins, rays.directions
    cosine = np.sum(viewing * d, axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        square = 1 - cosine**2
        # Least |a v - o - b d|: two equations for a and b.
        along_v, along_d = np.sum(viewing * o, axis=1), np.sum(d * o, axis=1)
        a = (along_v - cosine * along_d) / square
        b = (cosine * along_v - along_d) / square
        valid = rays.valid & (square > GRAZING**2) & (a > 0) & np.isfinite(a)
    keep = valid[:, None]
    first, second = a[:, None] * viewing, o + b[:, None] * d
    # The grid's point is ahead of the mirror's: b < 0 if the ray runs away from it.
    away = -np.sign(b)[:, None] * d
    return MirrorPoints(
        np.where(keep, (first + second) / 2, np.nan),
        np.where(valid, np.linalg.norm(first - second, axis=1) / 2, np.nan),
        np.where(keep, away, np.nan),
        valid,
    )


class PrimaryStart(NamedTuple):
    """The linear stage: coefficients (K,) on a grid, from the MirrorPoints of those
    pixels, `common` (N,) bool, that see two grids, and their points (n, M, 2)."""

    grid: object
    coefficients: np.ndarray
    mirror: MirrorPoints
    common: np.ndarray
    points: np.ndarray
    flags: list


def robust_start(seen, given, T, spline, span):
    """(PrimaryStart, what the refinement takes of each grid, flags), wrong points left
    out.

    seen, given: (normalised image points (N, 2), points (N, 2) mm) of each grid, for
    the linear stage and for the refinement, where that takes others; spline: shape,
    degree, angle, quantity. Points off a smooth picture are left out of the first
    round; then those far off the linear stage, which is better each time without them.
    It bears a third of points that are wrong each in its own way, in one grid, and a
    sixth that are wrong alike along a border.
    """
    every = [seen] if given is None else [seen, given]
    wrong = [[_off_the_smooth(*grid) for grid in one] for one in every]
    for left in reversed(range(ROUNDS + 1)):
        kept = [_without(*pair) for pair in zip(every, wrong, strict=True)]
        sighted = [_known(*grid) for grid in kept[-1]]
        start = _linear_stage(kept[0], sighted, T, spline, span)
        # Of all points: one that a poor start took for wrong comes back.
        pairs = zip(every, wrong, strict=True)
        found = [_far(start, *pair, T, spline[-1]) for pair in pairs]
        if not left or np.array_equal(np.hstack(found[0]), np.hstack(wrong[0])):
            break
        wrong = found
    whole = sum(len(_known(*grid)[0]) for grid in every[-1])
    out = whole - sum(len(xy) for _, xy in sighted)
    if out > MOST_WRONG * whole:
        raise CalibrationError(
            f"primary calibration: {out} of {whole} points of the grids do not fit the "
            "others; photograph the grids anew, with nothing moved",
            code="wrong-matches",
        )
    flags = [f"{out} of {whole} points of the grids left out as wrong"] if out else []
    return start, sighted, flags


def _linear_stage(seen, sighted, T, spline, span):
    """PrimaryStart from what is seen of grids in poses T (n, 4, 4); the knots span
    that, what is sighted, and `span`."""
    shape, degree, angle, quantity = spline
    p, points = seen[0][0], np.stack([xy for _, xy in seen])
    common = np.count_nonzero(np.isfinite(points).all(axis=2), axis=0) >= 2
    p, points = p[common], points[:, common]
    along = np.column_stack([p, np.ones(len(p))])
    unit = along / np.linalg.norm(along, axis=1, keepdims=True)
    mirror = mirror_points(unit, rays_from_known_motion(points, T))
    _check_meeting(mirror)
    good = mirror.valid
    spanned = np.concatenate([p[good], *(image for image, _ in sighted)])
    box = spanned if span is None else np.concatenate([spanned, span])
    grid = spline_grid(box, shape, degree, angle)
    flags = need_support(support_of(grid, spanned))
    normals = reflection_normals(unit[good], mirror.directions[good])
    c = shape_up_to_scale(p[good], normals, grid, quantity)
    c = scaled_to_points(c, grid, quantity, mirror.points[good])
    return PrimaryStart(grid, c, mirror, common, points, flags)


def _far(start, seen, wrong, T, quantity):
    """For each grid, which of its points (N,) bool lie far off a PrimaryStart's rays;
    outside its knots, those that were wrong before."""
    found = []
    for (p, xy), pose in zip(seen, T, strict=True):
        off, there = np.full(len(p), np.nan), start.grid.inside(p)
        rays = RayPoints(p[there], start.grid, quantity)
        gap = rays.residuals(start.coefficients, placed_points(xy[there], pose))
        off[there] = np.linalg.norm(gap, axis=1)
        found.append(off)
    limit = FAR * max(np.nanmedian(np.concatenate(found)), LEAST_MM)
    return [
        np.where(np.isfinite(off), off > limit, before)
        for off, before in zip(found, wrong, strict=True)
    ]


def _off_the_smooth(p, xy):
    """Which points (N,) bool of a grid lie far off a smooth function of p (N, 2)."""
    known = np.isfinite(p + xy).all(axis=1)
    wrong = np.zeros(len(p), bool)
    wrong[known] = wrong_matches(p[known], xy[known])
    return wrong


def _without(seen, wrong):
    """What is seen of each grid, NaN where wrong."""
    return [
        (p, np.where(out[:, None], np.nan, xy))
        for (p, xy), out in zip(seen, wrong, strict=True)
    ]


def _known(p, xy):
    """Those of p (N, 2) and xy (N, 2) that are both known."""
    known = np.isfinite(p + xy).all(axis=1)
    return p[known], xy[known]


def _check_meeting(mirror):
    if np.count_nonzero(mirror.valid) < np.count_nonzero(~mirror.valid):
        raise CalibrationError(
            f"primary calibration: {np.count_nonzero(~mirror.valid)} of "
            f"{len(mirror.valid)} scene rays meet no viewing ray before the camera; "
            "check the grids' poses, and that these are the pictures in the mirror",
            code="rays-do-not-meet",
        )
    miss = np.mean(mirror.misses[mirror.valid])
    if miss > LARGEST_MISS:
        raise CalibrationError(
            f"primary calibration: scene rays pass viewing rays by {miss:.0f} mm on "
            "average; check the grids' poses and which pose belongs to which view",
            code="rays-do-not-meet",
        )
