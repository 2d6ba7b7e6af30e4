"""Section 4.1.4: counts of unknowns, and adjustments that free the centre."""

import numpy as np

from chapters.shared.central import (
    CENTRE_MM,
    RAYS,
    SETTINGS,
    SIDE,
    draw_pixels,
    draw_poses,
    observe,
    radial_lens,
)
from raxel.calibration import (
    adjust_concurrence,
    adjust_consistent,
    adjust_ray_point,
    linear_cgsp,
    pose_vector,
    ray_point_residuals,
)
from raxel.errors import CalibrationError
from raxel.geometry import on_plane
from repro.run import Plan, crossed, experiment

POINTS = 400
HALF_MM = 300.0  # of the grid that the points lie on
GRIDS = (3, 4, 6, 10)


def unknowns_trial(condition, rng):
    """The unknowns of scheme 2, and those of scheme 1 with its rays."""
    poses = draw_poses(rng, condition["grids"])
    return {
        "poses": len(pose_vector(poses)),
        "with_rays": len(pose_vector(poses)) + 2 * RAYS,
    }


@experiment("exp_c4_ba_param_count", artefact="sec_4_1_4")
def unknowns(effort):
    """Number of parameters of the adjustments."""
    return Plan(unknowns_trial, crossed(grids=GRIDS), 1, SETTINGS)


def formula_trial(condition, rng):
    """(4.16) to (4.18) compared with a search for the nearest point of each ray."""
    on_grid = rng.uniform(-HALF_MM, HALF_MM, (POINTS, 2))
    reach = on_plane(on_grid) - CENTRE_MM
    rays = reach + rng.standard_normal(reach.shape)
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    residuals = ray_point_residuals(
        on_grid[None], np.ones((1, POINTS), bool), CENTRE_MM, np.eye(4)[None], rays
    )
    formula = np.linalg.norm(residuals[0], axis=1)
    return {"largest_mm": np.abs(formula - nearest(rays, reach)).max()}


def nearest(rays, reach, rounds=90):
    """Least distance (N,) of points from rays, by golden-section search."""
    golden = (np.sqrt(5) - 1) / 2
    low, high = np.zeros(len(rays)), np.full(len(rays), 1200.0)

    def distance(depth):
        return np.linalg.norm(depth[:, None] * rays - reach, axis=1)

    for _ in range(rounds):
        left = high - golden * (high - low)
        right = low + golden * (high - low)
        nearer = distance(left) < distance(right)
        low, high = (np.where(nearer, low, left), np.where(nearer, right, high))
    return distance((low + high) / 2)


@experiment("exp_c4_raypoint_formula", artefact="sec_4_1_4")
def formula(effort):
    """The closed form of the ray-point distance."""
    return Plan(formula_trial, [{}], 5, {"points": POINTS})


NOISE_PX = 0.5
SCHEMES = ("line_fitting", "ray_point", "consistent")
STARTS = {"quick": 3, "full": 20}
SCENES = {"quick": 1, "full": 15}


def everything(points):
    """Mask in which every ray meets every grid."""
    return np.ones(points.shape[:2], bool)


def starts_trial(condition, rng):
    """One scene, many draws of its noise, and the end of each start.

    The starts are the linear stage's solutions of the draws, so they lie
    within its own error. On one draw's data, from all starts: the centres
    and costs at the end. On every draw's own data: the centres at the end.
    A fixed centre stays at its start in both cases.
    """
    camera = radial_lens()
    poses = draw_poses(rng)
    pixels = draw_pixels(camera, poses, rng)
    draws = []
    while len(draws) < condition["starts"]:
        scene = observe(camera, poses, pixels, NOISE_PX, "px", rng)
        try:
            draws.append((scene.noisy, linear_cgsp(scene.noisy, side=SIDE)))
        except CalibrationError:
            continue
    starts = np.array([start.centre for _, start in draws])
    return {scheme: _ends(scheme, draws, starts) for scheme in SCHEMES}


def _ends(scheme, draws, starts):
    """Ends of one scheme, from all starts and on all draws."""
    data = draws[0][0]
    same = [ended(scheme, data, start) for _, start in draws]
    own = [ended(scheme, points, start) for points, start in draws]
    ends = np.array([centre for centre, _, _ in same])
    costs = np.array([cost for _, cost, _ in same])
    own_ends = np.array([centre for centre, _, _ in own])
    return {
        "above_best": float(np.mean(costs > 1.1 * costs.min())),
        "spread_over_starts": _spread(ends) / _spread(starts),
        "spread_over_draws": _spread(own_ends) / _spread(starts),
        "at_rest": float(np.mean([converged for _, _, converged in same])),
        "starts_mm": np.linalg.norm(starts - CENTRE_MM, axis=1),
        "ends_mm": np.linalg.norm(ends - CENTRE_MM, axis=1),
    }


def ended(scheme, points, start):
    """Centre, cost and convergence of a scheme that frees the centre."""
    begin = everything(points), start.centre, start.T_base_grid
    if scheme == "consistent":
        found = adjust_consistent(points, *begin)
        return found.centre, found.cost, found.converged
    adjust = {"line_fitting": adjust_concurrence, "ray_point": adjust_ray_point}
    found = adjust[scheme](points, *begin)
    return found.centre, found.costs[-1], found.converged


def _spread(centres):
    """RMS distance (mm) of centres (N, 3) from their mean."""
    off = centres - centres.mean(axis=0)
    return float(np.sqrt(np.mean(np.sum(off**2, axis=1))))


@experiment("exp_c4_centre_ba_unstable", artefact="sec_4_1_4")
def unstable(effort):
    """Ends of adjustments with a free centre, from many starts."""
    return Plan(starts_trial, [{"starts": STARTS[effort]}], SCENES[effort], SETTINGS)
