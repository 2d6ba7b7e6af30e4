"""Section 4.1.4: its schemes of adjustment on simulated grids, and their errors."""

import numpy as np
from scipy.spatial.transform import Rotation

from chapters.shared.wide_angle import (
    CENTRE_MM,
    SETTINGS,
    SIDE,
    draw_pixels,
    draw_poses,
    draw_scene,
    equidistance,
    observe,
    radial_lens,
)
from raxel.calibration.adjust.bundle import (
    bundle_adjust_fixed_centre,
    ray_point_distances,
    ray_point_residuals,
)
from raxel.calibration.adjust.centroid_rays import centroid_directions
from raxel.calibration.adjust.consistent import adjust_consistent
from raxel.calibration.adjust.free_centre import adjust_concurrence, adjust_ray_point
from raxel.calibration.adjust.relaxation import relax_poses
from raxel.calibration.linear.cgsp import linear_cgsp
from raxel.errors import CalibrationError
from raxel.geometry import on_plane, transform
from repro.run.experiment import experiment
from repro.run.outcomes import Plan, crossed

NOISE_PX = 0.5
# Conditions of the targets: grids, camera, noise.
TARGETS = {
    "three grids": {"grids": 3, "camera": "radial", "noise": NOISE_PX},
    "ten grids": {"grids": 10, "camera": "radial", "noise": NOISE_PX},
    "fisheye of 150 deg": {"grids": 3, "camera": "equidistance 150", "noise": NOISE_PX},
    "no noise": {"grids": 3, "camera": "radial", "noise": 0.0},
}
SCHEMES = ("line_fitting", "ray_point", "consistent")
STARTS = {"quick": 3, "full": 20}
SCENES = {"quick": 1, "full": 15}


def everything(points):
    """Every ray sees every grid."""
    return np.ones(points.shape[:2], bool)


def linear(points):
    """CGSP's linear stage, which all adjustments start from."""
    return linear_cgsp(points, side=SIDE)


def fixed_centre(points, start):
    """Scheme 1: poses and ray directions, the centre kept."""
    seen = everything(points)
    found = bundle_adjust_fixed_centre(points, seen, start.centre, start.T_base_grid)
    rounds = len(found.costs) - 1
    return start.centre, found.T_base_grid, found.directions, rounds


def relaxed(points, start):
    """Scheme 2: the poses alone; rays are joined anew after each round."""
    seen = everything(points)
    found = relax_poses(points, seen, start.centre, start.T_base_grid)
    rounds = len(found.costs) - 1
    return start.centre, found.T_base_grid, found.directions, rounds


def line_fitting(points, start):
    """Scheme 3: lines through each ray's points, as concurrent as can be."""
    return _freed(adjust_concurrence, points, start)


def ray_point(points, start):
    """Scheme 1 with the centre set free."""
    return _freed(adjust_ray_point, points, start)


def _freed(adjust, points, start):
    seen = everything(points)
    found = adjust(points, seen, start.centre, start.T_base_grid)
    rays = centroid_directions(points, seen, found.centre, found.T_base_grid)
    return found.centre, found.T_base_grid, rays, len(found.costs) - 1


def consistent(points, start):
    """The consistent adjustment: in the grids' planes, weights frozen."""
    found = adjust_consistent(points, None, start.centre, start.T_base_grid)
    rays, rounds = found.directions, found.passes
    return found.centre, found.T_base_grid, rays, rounds


def unadjusted(points, start):
    """The linear stage as it is."""
    seen = everything(points)
    rays = centroid_directions(points, seen, start.centre, start.T_base_grid)
    return start.centre, start.T_base_grid, rays, 0


METHODS = {
    "linear": unadjusted,
    "fixed_centre": fixed_centre,
    "relaxed": relaxed,
    "line_fitting": line_fitting,
    "ray_point": ray_point,
    "consistent": consistent,
}


def centre_error(centre):
    """Distance from the true centre in mm."""
    return float(np.linalg.norm(centre - CENTRE_MM))


def scheme_trial(condition, rng):
    """Every adjustment on one scene.

    ray_mm: mean distance of the rays from the true points of all grids;
    own_ray_mm: RMS distance from the noisy points under the found poses,
    which is what the thesis's schemes make small.
    """
    scene = draw_scene(radial_lens(), condition["noise"], rng)
    try:
        start = linear(scene.noisy)
    except CalibrationError as fault:
        return {"refused": str(fault)}
    true = transform(scene.T_base_grid, on_plane(scene.points))
    out = {}
    for name, method in METHODS.items():
        centre, poses, rays, rounds = method(scene.noisy, start)
        own = ray_point_residuals(scene.noisy, everything(true), centre, poses, rays)
        out[name] = {
            "centre_mm": centre_error(centre),
            "ray_mm": float(ray_point_distances(true, centre, rays).mean()),
            "own_ray_mm": float(np.sqrt(np.mean(np.sum(own**2, axis=2)))),
            "rounds": rounds,
        }
    return out


@experiment("ext_schemes_trials", artefact="ext_adjustment_schemes")
def schemes(effort):
    """All schemes of adjustment on the same data."""
    trials = {"quick": 2, "full": 50}[effort]
    return Plan(scheme_trial, [{"noise": NOISE_PX}], trials, SETTINGS)


def target_trial(condition, rng):
    """The consistent adjustment, and its error beside what it states.

    nees: squared error of centre and poses in units of the stated
    covariance, per unknown; 1 on average if that covariance is right.
    """
    case = TARGETS[condition["case"]]
    camera = radial_lens()
    if case["camera"] == "equidistance 150":
        camera = equidistance(150)
    scene = draw_scene(camera, case["noise"], rng, grids=case["grids"])
    try:
        start = linear(scene.noisy)
    except CalibrationError as fault:
        return {"refused": str(fault)}
    found = adjust_consistent(scene.noisy, None, start.centre, start.T_base_grid)
    out = {
        "linear_mm": centre_error(start.centre),
        "consistent_mm": centre_error(found.centre),
        "passes": found.passes,
        "converged": float(found.converged),
    }
    if case["noise"] > 0:
        out["nees"] = normalised_square(found, scene)
    return out


def normalised_square(found, scene):
    """Squared error of centre and poses over its covariance, per unknown."""
    off = [found.centre - CENTRE_MM]
    for T, T_true in zip(found.T_base_grid[1:], scene.T_base_grid[1:], strict=True):
        turn = Rotation.from_matrix(T[:3, :3].T @ T_true[:3, :3])
        off += [-turn.as_rotvec(), T[:3, 3] - T_true[:3, 3]]
    off = np.concatenate(off)
    return float(off @ np.linalg.solve(found.covariance, off) / len(off))


@experiment("ext_adjustment_targets_trials", artefact="ext_adjustment_targets")
def targets(effort):
    """Accuracy of the consistent adjustment, and of the error it states."""
    trials = {"quick": 4, "full": 200}[effort]
    settings = SETTINGS | {"cases": TARGETS}
    return Plan(target_trial, crossed(case=TARGETS), trials, settings)


def starts_trial(condition, rng):
    """One scene, many draws of its noise, and where each start ends.

    The starts are the linear stage's solutions of the draws, so they lie
    within its own error. On one draw's data, from all starts: the centres
    and costs at the end. On every draw's own data: the centres at the end.
    A fixed centre stays at its start in either case.
    """
    camera = radial_lens()
    poses = draw_poses(rng)
    pixels = draw_pixels(camera, poses, rng)
    draws = []
    while len(draws) < condition["starts"]:
        scene = observe(camera, poses, pixels, NOISE_PX, "px", rng)
        try:
            draws.append((scene.noisy, linear(scene.noisy)))
        except CalibrationError:
            continue
    starts = np.array([start.centre for _, start in draws])
    return {scheme: _ends(scheme, draws, starts) for scheme in SCHEMES}


def _ends(scheme, draws, starts):
    """Where one scheme ends, from all starts and on all draws."""
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
    """Centre, cost, and whether it came to rest, of a scheme that frees it."""
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


@experiment("exp_c4_centre_ba_unstable", artefact="sec_4_1_4", shards={"full": 2})
def unstable(effort):
    """Where adjustments with a free centre end, from many starts."""
    return Plan(starts_trial, [{"starts": STARTS[effort]}], SCENES[effort], SETTINGS)
