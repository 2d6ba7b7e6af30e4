"""What of section 4.1.4 can be counted or computed without noise."""

import numpy as np

from chapters.shared.wide_angle import CENTRE_MM, RAYS, SETTINGS, draw_poses
from raxel.calibration.adjust.bundle import ray_point_residuals
from raxel.calibration.adjust.relaxation import pose_vector
from raxel.geometry import on_plane
from repro.run.experiment import experiment
from repro.run.outcomes import Plan, crossed

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
    """How many numbers the adjustments move."""
    return Plan(unknowns_trial, crossed(grids=GRIDS), 1, SETTINGS)


def formula_trial(condition, rng):
    """(4.16) to (4.18) beside a search for the nearest point of each ray."""
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
