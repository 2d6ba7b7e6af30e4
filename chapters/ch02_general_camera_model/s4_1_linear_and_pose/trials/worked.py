"""One scene with numbers: what the symbols of the linear stage stand for."""

import numpy as np

from chapters.ch02_general_camera_model.s4_1_linear_and_pose.trials.systems import (
    matrix_a,
    scaled_coefficients,
    scene_points,
)
from raxel.geometry import on_plane, transform
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

NEAR_MM = 130.0
HALF_TRACE_MM = 170.0


def unknowns_of(centre, T_base_grid, scales):
    """u (14,) of (2.20) from the truth: centre, two poses, two scales.

    T_base_grid: (2, 4, 4) of grids 2 and 3; scales: lambda_1, lambda_2.
    """
    u = [centre[0], centre[1]]
    for T, scale in zip(T_base_grid, scales, strict=True):
        shift = T[:2, 3] - centre[:2]
        turn = T[:2, :2].ravel()
        u += list(scale * centre[2] * np.concatenate([shift, turn]))
    return np.array(u)


def traces(met, centre, T_base_grid):
    """Ends (3, 2, 3) of the lines that the grids draw on a plane through a ray.

    The plane holds the ray and the x axis of the base grid; met: (3, 3),
    where the ray meets the grids.
    """
    across = np.cross(met[0] - centre, [1.0, 0.0, 0.0])
    along = np.cross(T_base_grid[:, :3, 2], across)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    ends = HALF_TRACE_MM * np.array([-1.0, 1.0])
    return met[:, None] + ends[:, None] * along[:, None]


def worked_trial(condition, rng):
    """A scene, one of its rays, and both sides of the twelve rows (2.24)."""
    points, centre, T_base_grid = scene_points(rng)
    coefficients = scaled_coefficients(points)
    scales = coefficients[[0, 2], 3] / T_base_grid[1:, 2, 0]
    u = unknowns_of(centre, T_base_grid[1:], scales)
    A, x = matrix_a(coefficients)
    ray = np.argmax(np.linalg.norm(points[0], axis=1) < NEAR_MM)
    flat = on_plane(points[:, ray])
    met = np.array([transform(T, p) for T, p in zip(T_base_grid, flat, strict=True)])
    return {
        "centre": centre,
        "met": met,
        "traces": traces(met, centre, T_base_grid),
        "coefficients": coefficients,
        "scales": scales,
        "unknowns": u,
        "left": A @ u,
        "right": x,
    }


@experiment("ext_worked_row_scene", artefact="ext_worked_row")
def worked_scene(effort):
    """One scene without noise, with every symbol of (2.24) as a number."""
    return Plan(worked_trial, [{}], 1, {"drawn_mm": 2 * HALF_TRACE_MM})
