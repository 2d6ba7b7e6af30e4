"""Section 4.1.5: the methods on one trial, and the steps between them."""

from functools import partial

import numpy as np

from chapters.shared.central import (
    CENTRE_MM,
    SETTINGS,
    SIDE,
    draw_pixels,
    draw_poses,
    draw_scene,
    observe,
    radial_lens,
)
from chapters.shared.methods import LINEAR_STAGES, as_printed
from raxel.calibration import (
    LinearSolution,
    adjust_consistent,
    centroid_directions,
    linear_cgsp,
    linear_well_conditioned,
    normalising_similarity,
    printed_depth,
    printed_pose,
    ray_point_distances,
    relax_poses,
    solve_coefficients,
    solve_unknowns,
)
from raxel.errors import CalibrationError
from raxel.geometry import angle_between_rotations, on_plane, pose, transform
from repro.run import Plan, experiment

LEVELS = (0.1, 0.25, 0.5, 1.0, 2.0)
DOMAINS = ("px", "mm")
TRIALS = {"quick": 3, "full": 50}
FIXED_SEED = 0  # of the configuration in which only the noise changes


def errors(centre, T_base_grid, directions, scene):
    """Errors of one calibration in the frame of the base grid, without alignment.

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
    """Poses and rays after the thesis's bundle adjustment, with fixed centre."""
    found = relax_poses(points, np.ones(points.shape[:2], bool), centre, T_base_grid)
    return found.T_base_grid, found.directions


def unadjusted(scene, start):
    """Errors of an unadjusted linear stage, with rays through the centroids."""
    seen = np.ones(scene.noisy.shape[:2], bool)
    centre, poses = start.centre, start.T_base_grid
    rays = centroid_directions(scene.noisy, seen, centre, poses)
    return errors(centre, poses, rays, scene)


def calibrate(scene, linear):
    """Errors of one linear stage, unadjusted and adjusted about two centres."""
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
    """Result of ``run(scene, linear)`` for every method, or its error code."""
    out = {}
    for name, linear in LINEAR_STAGES.items():
        try:
            out[name] = run(scene, linear)
        except CalibrationError as fault:
            out[name] = {"failed": fault.code}
    return out


def fixed_trial(condition, rng):
    """One trial with fixed grids and rays; only the noise is drawn."""
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
    """All noise levels, in px and in mm."""
    return [
        {"domain": domain, "noise": level} for domain in DOMAINS for level in LEVELS
    ]


@experiment("fig_4_2_fixed", artefact="fig_4_2")
def fixed_sweep(effort):
    """The sweep of Fig. 4.2 with one configuration of grids and rays."""
    settings = SETTINGS | {"fixed_seed": FIXED_SEED}
    return Plan(fixed_trial, levels(), TRIALS[effort], settings)


NOISE_PX = 0.5
STEPS_TRIALS = {"quick": 3, "full": 100}
MANY_GRIDS = 10


def printed(points):
    """(2.15) to (2.25) in mm, t_z from V_6."""
    return as_printed(points, side=SIDE)


def in_normalised_coordinates(solve, points):
    """Solution of ``solve`` in coordinates relative to the middle of each grid.

    All grids share one scale, so that a pose stays a pose.
    """
    similarities = [normalising_similarity(p) for p in points]
    scale = np.mean([s.scale for s in similarities])
    offsets = [s.offset for s in similarities]
    found = solve([scale * (p - o) for p, o in zip(points, offsets, strict=True)])
    base = np.append(offsets[0], 0.0)
    poses = []
    for T, offset in zip(found.T_base_grid, offsets, strict=True):
        R = T[:3, :3]
        shift = T[:3, 3] / scale + base - R @ np.append(offset, 0.0)
        poses.append(pose(R, shift))
    centre = found.centre / scale + base
    return LinearSolution(centre, np.stack(poses), found.degeneracy)


def one_scale(points):
    """As printed, but with one scale of V and W from all shared entries."""
    coefficients = []
    for other in points[1:]:
        v, w, _ = solve_coefficients(points[0], other)
        shared = np.column_stack([v[3:6], w[:3]])
        scale_v, scale_w = np.linalg.svd(shared)[2][0]
        coefficients += [v, w * (scale_v / scale_w)]
    v, w, m, n = coefficients
    u, degeneracy = solve_unknowns(v, w, m, n)
    centre = np.array([u[0], u[1], printed_depth(u, v, SIDE)])
    poses = [np.eye(4)] + [
        printed_pose(vector, part, centre, on_grid, "corrected")
        for vector, part, on_grid in ((v, u[2:8], points[1]), (m, u[8:14], points[2]))
    ]
    return LinearSolution(centre, np.stack(poses), degeneracy)


def consistent(points):
    """CGSP, then an adjustment of centre, poses and rays together."""
    start = linear_cgsp(points, side=SIDE)
    return adjust_consistent(points, None, start.centre, start.T_base_grid)


# Each step makes one change to the one before.
STEPS = {
    "as_printed": printed,
    "normalised": lambda points: in_normalised_coordinates(printed, points),
    "one_scale": lambda points: in_normalised_coordinates(one_scale, points),
    "well_conditioned": partial(linear_well_conditioned, side=SIDE),
    "cgsp": partial(linear_cgsp, side=SIDE),
    "cgsp_weighted": partial(linear_cgsp, side=SIDE, weights="image noise"),
    "consistent": consistent,
}
OF_MANY_GRIDS = ("well_conditioned", "cgsp", "cgsp_weighted", "consistent")


def centre_errors(points, methods):
    """Error (mm) of the centre by method, or the error code of a failure."""
    out = {}
    for name, method in methods.items():
        try:
            off = method(points).centre - CENTRE_MM
            out[name] = {"centre_mm": float(np.linalg.norm(off))}
        except CalibrationError as fault:
            out[name] = {"failed": fault.code}
    return out


def steps_trial(condition, rng):
    """One scene of three grids, and the error of the centre after every step."""
    return centre_errors(draw_scene(radial_lens(), NOISE_PX, rng).noisy, STEPS)


@experiment("ext_cgsp_steps", artefact="ext_what_cgsp_buys_figure")
def steps(effort):
    """All steps, three grids, 0.5 px."""
    return Plan(steps_trial, [{"noise": NOISE_PX}], STEPS_TRIALS[effort], SETTINGS)


def grids_trial(condition, rng):
    """More than three grids: methods that accept any number."""
    scene = draw_scene(radial_lens(), NOISE_PX, rng, grids=condition["grids"])
    return centre_errors(scene.noisy, {name: STEPS[name] for name in OF_MANY_GRIDS})


@experiment("ext_cgsp_grids", artefact="ext_cgsp_sensitivity_figure")
def many_grids(effort):
    """Ten grids, 0.5 px."""
    return Plan(grids_trial, [{"grids": MANY_GRIDS}], STEPS_TRIALS[effort], SETTINGS)
