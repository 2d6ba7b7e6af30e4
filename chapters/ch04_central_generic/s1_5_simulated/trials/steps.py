"""From the standard linear stage to CGSP, one change at a time."""

import numpy as np

from chapters.shared.methods import as_printed
from chapters.shared.wide_angle import (
    CENTRE_MM,
    SETTINGS,
    SIDE,
    draw_scene,
    radial_lens,
)
from raxel.calibration.adjust.consistent import adjust_consistent
from raxel.calibration.linear.bilinear import solve_coefficients
from raxel.calibration.linear.cgsp import linear_cgsp
from raxel.calibration.linear.standard import (
    LinearSolution,
    linear_well_conditioned,
    normalising_similarity,
    printed_depth,
    printed_pose,
    solve_unknowns,
)
from raxel.errors import CalibrationError
from raxel.geometry import pose
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

NOISE_PX = 0.5
TRIALS = {"quick": 3, "full": 100}
MANY_GRIDS = 10


def printed(points):
    """(2.15) to (2.25) in mm, t_z from V_6."""
    return as_printed(points, side=SIDE)


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
    "as_printed": printed,
    "normalised": lambda points: in_normalised_coordinates(printed, points),
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
            out[name] = {"failed": fault.code}
    return out


def steps_trial(condition, rng):
    """One scene of three grids, and the error of the centre after every step."""
    return centre_errors(draw_scene(radial_lens(), NOISE_PX, rng).noisy, STEPS)


@experiment("ext_cgsp_steps", artefact="ext_what_cgsp_buys_figure")
def steps(effort):
    """All steps, three grids, 0.5 px."""
    return Plan(steps_trial, [{"noise": NOISE_PX}], TRIALS[effort], SETTINGS)


def grids_trial(condition, rng):
    """More than three grids: methods that take any number."""
    scene = draw_scene(radial_lens(), NOISE_PX, rng, grids=condition["grids"])
    return centre_errors(scene.noisy, {name: STEPS[name] for name in OF_MANY_GRIDS})


@experiment("ext_cgsp_grids", artefact="ext_cgsp_sensitivity_figure")
def many_grids(effort):
    """Ten grids, 0.5 px."""
    return Plan(grids_trial, [{"grids": MANY_GRIDS}], TRIALS[effort], SETTINGS)
