"""Section 5.1: mirrors that are exact splines, and what directions determine."""

import numpy as np

from raxel.calibration.mirror.clamp import Clamp, clamped
from raxel.calibration.mirror.linear import (
    orthogonality_rows,
    reflection_normals,
    shape_up_to_scale,
    shape_with_clamp,
)
from raxel.calibration.mirror.ray_points import RayPoints
from raxel.calibration.mirror.refine import refine_shape
from raxel.geometry.spline_grid import spline_grid

QUANTITY, SHAPE = "distance", (7, 3)
CORNERS = np.array([[-0.2, -0.15], [0.2, 0.15]])
DEPTH_MM, TILT_DEG, TIP_MM = 400.0, (50.0, 70.0), (5.0, 20.0)
MANY, SCENE_MM = 80, (300.0, 600.0)
START_OFF = 0.01
PAIRS = (8, 9, 10, 11, 14, 21, 60)
RANK = 1e-9
"""Of the largest singular value: what lies below is rounding."""
ENDS = {"u": 0, "v": 1}


def draw_mirror(rng, shape=SHAPE):
    """A SplineGrid over the image and coefficients (K,): a bent and twisted plane.

    The plane is rotated about the clamped edge, along y, and bent by a beam's cubic
    with a tip that differs along the edge. The nearest spline is the mirror.
    """
    grid = spline_grid(CORNERS, shape)
    tilt = np.radians(rng.uniform(*TILT_DEG))
    tip, twist = rng.uniform(*TIP_MM), rng.uniform(-0.3, 0.3)
    p = draw_pixels(rng, 20 * grid.size)
    along = (p[:, 0] - CORNERS[0, 0]) / np.ptp(CORNERS[:, 0])
    bend = tip * (1 + twist * p[:, 1] / CORNERS[1, 1])
    depth = DEPTH_MM / (1 - p[:, 0] / np.tan(tilt)) + bend * (3 - along) * along**2 / 2
    distance = depth * np.sqrt(1 + np.sum(p**2, axis=1))
    return grid, np.linalg.lstsq(grid.rows(p)[0], distance, rcond=None)[0]


def draw_pixels(rng, count):
    """Normalised image coordinates (count, 2), uniform over the mirror's image."""
    return rng.uniform(*CORNERS, (count, 2))


def spread_pixels(rng, count, grid):
    """Coordinates (count, 2) that use all knot intervals along u in turn.

    Both halves along v as well; within these cells at random.
    """
    low, high = grid.breaks[0][:-1], grid.breaks[0][1:]
    cell = np.arange(count)
    u = rng.uniform(low[cell % len(low)], high[cell % len(low)])
    half = (cell // len(low)) % 2
    share = (half + rng.uniform(0, 1, count)) / 2
    return np.column_stack([u, CORNERS[0, 1] + share * np.ptp(CORNERS[:, 1])])


def equations(p, grid, c):
    """The rows of (5.15, 5.16), with normals of the true viewing and scene rays."""
    rays = RayPoints(p, grid, QUANTITY)
    normals = reflection_normals(rays.viewing, rays.surface(c)[1])
    return orthogonality_rows(p, normals, grid, QUANTITY), normals


def singular(A):
    """Singular values of a matrix whose columns are brought to one length first."""
    length = np.linalg.norm(A, axis=0)
    return np.linalg.svd(A / np.where(length > 0, length, 1.0), compute_uv=False)


def rank_of(A):
    """Numerical rank, with columns of one length."""
    size = singular(A)
    return int(np.count_nonzero(size > RANK * size[0]))


def depth_trial(condition, rng):
    """Rank of the equations, and how far their null vector is from the true mirror."""
    grid, c = draw_mirror(rng)
    p = draw_pixels(rng, MANY)
    A, normals = equations(p, grid, c)
    size = singular(A)
    found = shape_up_to_scale(p, normals, grid, QUANTITY)
    return {
        "open": grid.size - rank_of(A),
        "off": float(np.linalg.norm(found - c / np.linalg.norm(c))),
        "last": float(size[-1] / size[0]),
        "last_but_one": float(size[-2] / size[0]),
    }


def fixed_trial(condition, rng):
    """One fixed point of the mirror: rank, and errors of both stages, without noise."""
    grid, c = draw_mirror(rng)
    p = draw_pixels(rng, MANY)
    A, normals = equations(p, grid, c)
    at = np.array([[CORNERS[0, 0], rng.uniform(*CORNERS[:, 1])]])
    clamp = Clamp(at, grid.rows(at)[0] @ c)
    space = clamped(grid, clamp)
    linear = shape_with_clamp(p, normals, grid, QUANTITY, clamp)
    S, V_r = RayPoints(p, grid, QUANTITY).surface(c)
    points = S + rng.uniform(*SCENE_MM, (MANY, 1)) * V_r
    start = c * (1 + START_OFF * rng.standard_normal(len(c)) / 10)
    refined = refine_shape(
        p, points, grid, QUANTITY, start, noise=1e-4, clamp=clamp
    ).coefficients
    return {
        "open": space.directions.shape[1] - rank_of(A @ space.directions),
        "linear_mm": float(np.abs(linear - c).max()),
        "refined_mm": float(np.abs(refined - c).max()),
        "start_mm": float(np.abs(start - c).max()),
    }


def pairs_trial(condition, rng):
    """Rank of the equations of so many pairs of rays, well spread or at random."""
    grid, c = draw_mirror(rng)
    count = condition["pairs"]
    sets = {
        "spread": spread_pixels(rng, count, grid),
        "random": draw_pixels(rng, count),
    }
    ranks = {name: rank_of(equations(p, grid, c)[0]) for name, p in sets.items()}
    return ranks | {"size": grid.size}


def ends_trial(condition, rng):
    """Rank with all features, and without those of an end interval.

    reciprocal: last singular value but one over the first, one over the condition.
    """
    grid, c = draw_mirror(rng, tuple(condition["shape"]))
    p = draw_pixels(rng, 8 * MANY)
    axis = ENDS[condition["axis"]]
    intervals = grid.intervals(p)[:, axis]
    end = intervals.max() if condition["end"] == "last" else 0
    out = {"size": grid.size}
    for name, kept in (("all", p), ("without", p[intervals != end])):
        A, _ = equations(kept, grid, c)
        size = singular(A)
        out[name] = {"rank": rank_of(A), "reciprocal": float(size[-2] / size[0])}
    return out
