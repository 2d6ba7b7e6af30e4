"""From the standard linear stage to CGSP, one change at a time."""

import numpy as np

from chapters.shared.wide_angle import (
    CENTRE_MM,
    SETTINGS,
    SIDE,
    OutOfView,
    draw_pixels,
    draw_poses,
    draw_scene,
    observe,
    radial_lens,
)
from raxel.calibration.adjust.consistent import adjust_consistent
from raxel.calibration.linear.bilinear import solve_coefficients
from raxel.calibration.linear.cgsp import linear_cgsp
from raxel.calibration.linear.standard import (
    LinearSolution,
    linear_as_printed,
    linear_well_conditioned,
    normalising_similarity,
    printed_depth,
    printed_pose,
    solve_unknowns,
)
from raxel.errors import CalibrationError
from raxel.geometry import pose
from repro.run.experiment import experiment
from repro.run.outcomes import Plan, crossed

NOISE_PX = 0.5
TRIALS = {"quick": 3, "full": 100}
GRIDS = (3, 4, 6, 10)
OUTLIERS = (0.0, 0.003, 0.01, 0.05)
OUTLIER_MM = 300.0
# name: (what is varied, its values); all else as in 4.1.5.
SWEEPS = {
    "tilt": ("euler_deg", (5.0, 10.0, 20.0, 30.0, 40.0)),
    "extent": ("half_mm", (200.0, 300.0, 500.0, 800.0)),
    "rays": ("rays", (30, 100, 300, 1000, 3000)),
}


def as_printed(points):
    """(2.15) to (2.25) in mm, t_z from V_6."""
    return linear_as_printed(*points, side=SIDE, tz="corrected")


def in_normalised_coordinates(solve, points):
    """The solution of ``solve`` in coordinates of every grid about its middle.

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
    """As printed, but V and W brought to one scale by all they share."""
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


def well_conditioned(points):
    """Normalised, least squares, and no division by what may vanish."""
    return linear_well_conditioned(points, side=SIDE)


def cgsp(points):
    """The base grid as image plane: V and W are estimated together."""
    return linear_cgsp(points, side=SIDE)


def cgsp_weighted(points):
    """CGSP with each ray's equations weighted by what noise does to them."""
    return linear_cgsp(points, side=SIDE, weights="image noise")


def consistent(points):
    """CGSP, then an adjustment of centre, poses and rays together."""
    start = cgsp(points)
    return adjust_consistent(points, None, start.centre, start.T_base_grid)


# Every one differs from that before it by one change.
STEPS = {
    "as_printed": as_printed,
    "normalised": lambda points: in_normalised_coordinates(as_printed, points),
    "one_scale": lambda points: in_normalised_coordinates(one_scale, points),
    "well_conditioned": well_conditioned,
    "cgsp": cgsp,
    "cgsp_weighted": cgsp_weighted,
    "consistent": consistent,
}
OF_MANY_GRIDS = ("well_conditioned", "cgsp", "cgsp_weighted", "consistent")


def centre_errors(points, methods):
    """Error (mm) of the centre by method, and why one gave nothing."""
    out = {}
    for name, method in methods.items():
        try:
            off = method(points).centre - CENTRE_MM
            out[name] = {"centre_mm": float(np.linalg.norm(off))}
        except CalibrationError as fault:
            out[name] = {"failed": str(fault)}
    return out


def grids_trial(condition, rng):
    """More than three grids: methods that take any number."""
    scene = draw_scene(radial_lens(), NOISE_PX, rng, grids=condition["grids"])
    return centre_errors(scene.noisy, {name: STEPS[name] for name in OF_MANY_GRIDS})


@experiment("ext_cgsp_grids", artefact="ext_cgsp_sensitivity_figure")
def grids_sweep(effort):
    """Three to ten grids, 0.5 px."""
    return Plan(grids_trial, crossed(grids=GRIDS), TRIALS[effort], SETTINGS)


def with_outliers(points, share, rng):
    """A share of the points of every grid but the base, put anywhere on it."""
    spoiled = points.copy()
    for on_grid in spoiled[1:]:
        wrong = rng.permutation(len(on_grid))[: round(share * len(on_grid))]
        on_grid[wrong] = rng.uniform(-OUTLIER_MM, OUTLIER_MM, (len(wrong), 2))
    return spoiled


def outliers_trial(condition, rng):
    """Wrong points, with and without a search for them."""
    scene = draw_scene(radial_lens(), NOISE_PX, rng)
    points = with_outliers(scene.noisy, condition["outliers"], rng)

    def robust(points):
        return linear_cgsp(points, side=SIDE, robust="ransac", rng=rng)

    def standard_on_inliers(points):
        kept = robust(points).inliers.all(axis=0)
        return well_conditioned(points[:, kept])

    return centre_errors(
        points,
        {
            "well_conditioned": well_conditioned,
            "cgsp": cgsp,
            "cgsp_robust": robust,
            "well_conditioned_robust": standard_on_inliers,
        },
    )


@experiment("ext_cgsp_outliers", artefact="ext_cgsp_outliers_table")
def outliers_sweep(effort):
    """None to 5 % of wrong points, 0.5 px."""
    conditions = crossed(outliers=OUTLIERS)
    settings = SETTINGS | {"outliers_within_mm": OUTLIER_MM}
    return Plan(outliers_trial, conditions, TRIALS[effort], settings)


def sensitivity_trial(condition, rng):
    """One thing of the scene is other than in 4.1.5."""
    camera = radial_lens()
    poses, pixels, drawn_again = _in_view(camera, condition, rng)
    scene = observe(camera, poses, pixels, NOISE_PX, "px", rng)
    methods = {name: STEPS[name] for name in OF_MANY_GRIDS}
    return centre_errors(scene.noisy, methods) | {"drawn_again": drawn_again}


def _in_view(camera, condition, rng):
    """Poses, pixels that see all grids, and how often there were none."""
    drawn_again = 0
    while True:
        poses = draw_poses(rng, euler_deg=condition.get("euler_deg", 30.0))
        try:
            pixels = draw_pixels(
                camera,
                poses,
                rng,
                condition.get("rays", SETTINGS["rays_per_trial"]),
                condition.get("half_mm", np.inf),
            )
        except OutOfView:
            drawn_again += 1
            continue
        return poses, pixels, drawn_again


@experiment("ext_cgsp_sensitivity", artefact="ext_cgsp_sensitivity_figure")
def sensitivity_sweep(effort):
    """Tilts, sizes of the grids and numbers of rays, three grids, 0.5 px."""
    conditions = [
        {"sweep": sweep, name: level}
        for sweep, (name, levels) in SWEEPS.items()
        for level in levels
    ]
    return Plan(sensitivity_trial, conditions, TRIALS[effort], SETTINGS)
