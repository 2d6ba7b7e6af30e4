"""Section 4.1.5: the methods on one trial's data, and their errors."""

import numpy as np

from chapters.shared.methods import LINEAR_STAGES
from chapters.shared.wide_angle import (
    CENTRE_MM,
    SETTINGS,
    SIDE,
    draw_pixels,
    draw_poses,
    observe,
    radial_lens,
)
from raxel.calibration.adjust.bundle import ray_point_distances
from raxel.calibration.adjust.centroid_rays import centroid_directions
from raxel.calibration.adjust.consistent import adjust_consistent
from raxel.calibration.adjust.relaxation import relax_poses
from raxel.calibration.linear.cgsp import linear_cgsp
from raxel.errors import CalibrationError
from raxel.geometry import angle_between_rotations, on_plane, transform
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

LEVELS = (0.1, 0.25, 0.5, 1.0, 2.0)
DOMAINS = ("px", "mm")
TRIALS = {"quick": 3, "full": 50}
FIXED_SEED = 0  # of the one configuration whose noise alone is drawn again


def errors(centre, T_base_grid, directions, scene):
    """Errors of one calibration in the base grid's frame, which needs no fit.

    ray_mm: mean distance of the rays from the true points of all grids;
    own_ray_mm: from the noisy points under the estimated poses; point_mm:
    mean displacement of the true points of grids 2 and 3 by the estimated
    poses.
    """
    found, true = T_base_grid[1:], scene.T_base_grid[1:]
    out = {"centre_mm": _length(centre - CENTRE_MM)}
    for number, (T, T_true) in enumerate(zip(found, true, strict=True), 2):
        t, t_true = T[:3, 3], T_true[:3, 3]
        out[f"t{number}_mm"] = _length(t - t_true)
        out[f"t{number}_length_mm"] = abs(_length(t) - _length(t_true))

        out[f"r{number}_deg"] = float(
            np.degrees(angle_between_rotations(T_true[:3, :3], T[:3, :3]))
        )
    placed = _placed(scene.T_base_grid, scene.points)
    own = _placed(T_base_grid, scene.noisy)
    moved = _placed(T_base_grid, scene.points)
    return out | {
        "ray_mm": float(ray_point_distances(placed, centre, directions).mean()),
        "own_ray_mm": float(ray_point_distances(own, centre, directions).mean()),
        "point_mm": float(np.linalg.norm(moved[1:] - placed[1:], axis=2).mean()),
    }


def _placed(T_base_grid, points):
    """Points (n, N, 2) of n grids in the base frame, (n, N, 3)."""
    return transform(T_base_grid, on_plane(points))


def _length(vector):
    return float(np.linalg.norm(vector))


def relaxed(points, centre, T_base_grid):
    """Poses and rays after the thesis's bundle adjustment, the centre kept."""
    found = relax_poses(points, np.ones(points.shape[:2], bool), centre, T_base_grid)
    return found.T_base_grid, found.directions


def unadjusted(scene, start):
    """Errors of a linear stage as it is, rays joined to their centroids."""
    seen = np.ones(scene.noisy.shape[:2], bool)
    centre, poses = start.centre, start.T_base_grid
    rays = centroid_directions(scene.noisy, seen, centre, poses)
    return errors(centre, poses, rays, scene)


def calibrate(scene, linear):
    """Errors of one linear stage as it is, and adjusted about two centres."""
    start = linear(scene.noisy, side=SIDE)
    poses = start.T_base_grid
    return {"linear": unadjusted(scene, start)} | {
        name: errors(centre, *relaxed(scene.noisy, centre, poses), scene)
        for name, centre in (("ba", start.centre), ("ba_true_centre", CENTRE_MM))
    }


def calibrate_consistent(scene):
    """Errors of CGSP after an adjustment of centre, poses and rays together."""
    start = linear_cgsp(scene.noisy, side=SIDE)
    found = adjust_consistent(scene.noisy, None, start.centre, start.T_base_grid)
    return errors(found.centre, found.T_base_grid, found.directions, scene)


def each_method(scene, run):
    """What ``run(scene, linear)`` gives for every method, or why it failed."""
    out = {}
    for name, linear in LINEAR_STAGES.items():
        try:
            out[name] = run(scene, linear)
        except CalibrationError as fault:
            out[name] = {"failed": fault.code}
    return out


def fixed_trial(condition, rng):
    """One trial of the same grids and rays; noise alone is drawn."""
    drawn = np.random.default_rng(FIXED_SEED)
    camera = radial_lens()
    poses = draw_poses(drawn)
    pixels = draw_pixels(camera, poses, drawn)
    noise, domain = condition["noise"], condition["domain"]
    scene = observe(camera, poses, pixels, noise, domain, rng)
    return each_method(
        scene,
        lambda scene, linear: {
            "linear": unadjusted(scene, linear(scene.noisy, side=SIDE))
        },
    )


def levels():
    """All sizes of noise, in px and in mm."""
    return [
        {"domain": domain, "noise": level} for domain in DOMAINS for level in LEVELS
    ]


@experiment("fig_4_2_fixed", artefact="fig_4_2", shards={"full": 2})
def fixed_sweep(effort):
    """The sweep of Fig. 4.2 with one configuration of grids and rays."""
    settings = SETTINGS | {"fixed_seed": FIXED_SEED}
    return Plan(fixed_trial, levels(), TRIALS[effort], settings)
