"""Linear stage of section 2.4.1 on data without noise: trials and plans."""

import numpy as np

from chapters.ch02_general_camera_model.s4_1_linear_and_pose.trials.systems import (
    RANK_TOLERANCE,
    SCENE,
    depth_squared,
    matrix_a,
    matrix_d,
    null_entries,
    rank_of,
    scaled_coefficients,
    scene_points,
    singular_values,
    solution_space,
    solve_u,
)
from raxel.calibration import (
    bundle_adjust_fixed_centre,
    linear_as_printed,
    linear_well_conditioned,
    rays_from_known_motion,
)
from raxel.errors import CalibrationError
from raxel.geometry import angle_between_rotations, on_plane
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

WRONG_MM = 1.0

SCENES = {"quick": 10, "full": 100}

LINEAR_SETTINGS = {
    "scene": SCENE,
    "rays": 999,
    "grids": "as in the simulation of section 2.5.1",
    "rank_tolerance": RANK_TOLERANCE,
}


def unit_of(points):
    """Return a length (mm) that scales the points of the base grid to order 1."""
    return np.sqrt(np.mean(np.sum(points[0] ** 2, axis=1)))


def rank_a_trial(condition, rng):
    """Return the rank of A and its relative singular values, in one scene."""
    points, _, _ = scene_points(rng)
    A, _ = matrix_a(scaled_coefficients(points / unit_of(points)))
    values = singular_values(A)
    return {"unknowns": A.shape[1], "rank": rank_of(values), "smallest": values[-1]}


@experiment("exp_c2_rank_A", artefact="sec_2_4_1")
def rank_of_a(effort):
    """Singular values of A (2.24) in random noise-free scenes."""
    return Plan(rank_a_trial, [{}], SCENES[effort], LINEAR_SETTINGS)


def rank_d_trial(condition, rng):
    """Return rank and null vectors of D, for two bases of A's null space."""
    points, _, _ = scene_points(rng)
    coefficients = scaled_coefficients(points / unit_of(points))
    a, basis = solution_space(*matrix_a(coefficients))
    mixed = rng.normal(size=(2, 2)) @ basis
    out = {}
    for name, used in (("orthonormal", basis), ("any", mixed)):
        D, _ = matrix_d(a, used, coefficients)
        values = singular_values(D)
        out[name] = {
            "rank": rank_of(values),
            "fifth": values[4],
            "sixth": values[5],
            "null_entry": null_entries(D),
            "l1_l2_column": np.linalg.norm(D[:, 2]) / np.linalg.norm(D[:, 3]),
        }
    return out


@experiment("exp_c2_rank_D", artefact="sec_2_4_1")
def rank_of_d(effort):
    """Singular values and null vectors of D (2.25), the same way."""
    return Plan(rank_d_trial, [{}], SCENES[effort], LINEAR_SETTINGS)


def exact_trial(condition, rng):
    """Return the errors of the linear stage on exact data, for each form."""
    points, centre, poses = scene_points(rng)
    side = np.sign(centre[2])
    forms = {
        "corrected": lambda: linear_as_printed(*points, side=side, tz="corrected"),
        "tz_printed": lambda: linear_as_printed(*points, side=side),
        "well_conditioned": lambda: linear_well_conditioned(points, side=side),
    }
    out = {name: _linear_errors(form, centre, poses) for name, form in forms.items()}
    unit = unit_of(points)
    u, coefficients = solve_u(points / unit)
    for name, printed in (("corrected", False), ("printed", True)):
        square = depth_squared(u, coefficients, printed)
        out[f"{name}_negative"] = bool(square < 0)
        depth = unit * np.sqrt(square) if square >= 0 else np.nan
        out[f"{name}_depth_mm"] = abs(depth - abs(centre[2]))
    return out


@experiment("exp_c2_linear_exact", artefact="sec_2_4_1")
def exact_data(effort):
    """The linear stage on exact data, in three forms of its formulas."""
    return Plan(exact_trial, [{}], SCENES[effort], LINEAR_SETTINGS)


def _linear_errors(form, centre, poses):
    try:
        found = form()
    except CalibrationError as error:
        return {"failed": error.code}
    return {
        "centre_mm": np.linalg.norm(found.centre - centre),
        **pose_errors(found.T_base_grid, poses),
    }


def pose_errors(found, true):
    """Return the largest error of translations (mm) and of rotations (rad)."""
    shift = np.linalg.norm((found - true)[:, :3, 3], axis=1)
    turn = angle_between_rotations(found[:, :3, :3], true[:, :3, :3])
    return {"translation_mm": shift.max(), "rotation_rad": turn.max()}


def no_motion_trial(condition, rng):
    """Return poses from intersections alone, and results of the two-pose method.

    T_1 of the two-pose method is right, or wrong by 1 mm along a random
    direction.
    """
    points, centre, poses = scene_points(rng)
    way = rng.normal(size=3)
    way *= WRONG_MM / np.linalg.norm(way)
    out = {"two_pose_deg": {}}
    true = on_plane(points[0]) - centre
    true /= np.linalg.norm(true, axis=1, keepdims=True)
    for name, error in (("right", np.zeros(3)), ("wrong", way)):
        known = poses[:2].copy()
        known[1, :3, 3] += error
        found = rays_from_known_motion(points[:2], known)
        # Lines: the grids of this scene may cross within the view.
        cosine = np.sum(found.directions * true, axis=1)
        sine = np.linalg.norm(np.cross(found.directions, true), axis=1)
        angle = np.arctan2(sine, np.abs(cosine))
        out["two_pose_deg"][name] = np.nanmedian(np.degrees(angle))
    try:
        start = linear_well_conditioned(points)
        adjusted = bundle_adjust_fixed_centre(
            points, np.ones(points.shape[:2], bool), start.centre, start.T_base_grid
        )
    except CalibrationError as error:
        return out | {"failed": error.code}
    errors = pose_errors(adjusted.T_base_grid, poses)
    return out | {
        "pose_mm": errors["translation_mm"],
        "pose_rad": errors["rotation_rad"],
    }


@experiment("exp_c2_generic_no_motion", artefact="alg_1")
def no_motion(effort):
    """Poses from intersections alone, compared with the two-pose method."""
    settings = LINEAR_SETTINGS | {"error_put_on_T_1_mm": 1.0}
    return Plan(no_motion_trial, [{}], SCENES[effort], settings)
