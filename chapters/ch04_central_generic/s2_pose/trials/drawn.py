"""The case that Fig. 4.3 is drawn from."""

import numpy as np

from chapters.ch04_central_generic.s2_pose.trials.simulated import moved, normalised
from chapters.shared.wide_angle import CENTRE_MM
from raxel.calibration.pose.grid_pose import linear_grid_pose, synthetic_plane_normal
from raxel.geometry import on_plane, pose, rotation_from_vector, transform
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

COLUMNS, ROWS, PITCH_MM = 5, 4, 60.0
SHIFT_MM = (330.0, 60.0, -40.0)
TURN_DEG = (20.0, -25.0, 10.0)
PLANE_MM = 260.0  # from the centre to the synthetic plane


def lattice():
    """Points (N, 2) of the drawn grid, its middle at the origin."""
    x = PITCH_MM * (np.arange(COLUMNS) - (COLUMNS - 1) / 2)
    y = PITCH_MM * (np.arange(ROWS) - (ROWS - 1) / 2)
    return np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)


def case_trial(condition, rng):
    """Points, rays, synthetic plane and image of one case, and its pose."""
    true = pose(rotation_from_vector(np.radians(TURN_DEG)), SHIFT_MM)
    points = lattice()
    there = transform(true, on_plane(points))
    rays = normalised(there - CENTRE_MM)
    normal = synthetic_plane_normal(rays)
    image = CENTRE_MM + PLANE_MM * rays / (rays @ normal)[:, None]
    found = linear_grid_pose(rays, points, normal=normal).T_camera_grid
    return {
        "there": there,
        "rays": rays,
        "normal": normal,
        "image": image,
        "true": true,
        "found": moved(found, CENTRE_MM),
    }


@experiment("fig_4_3_case", artefact="fig_4_3")
def drawn_case(effort):
    """One grid, its image on the synthetic plane, and the pose from it."""
    return Plan(case_trial, [{}], 1, {"shift_mm": SHIFT_MM, "turn_deg": TURN_DEG})
