"""The scene of Fig. 4.1: a board, the base grid before it, a wide camera above."""

import numpy as np

from chapters.ch04_central_generic.s1_1_synthetic_pinhole.trials.cameras import (
    WIDE_FOV_DEG,
)
from chapters.shared.wide_angle import CENTRE_MM, SETTINGS, T_BASE_CAMERA, equidistance
from raxel.geometry import (
    intersect_rays_plane,
    inverse_pose,
    on_plane,
    pose,
    rotation_from_vector,
    transform,
)
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

COLUMNS, ROWS, PITCH_MM = 9, 7, 190.0
BOARD_MM = np.array([0.0, 0.0, -480.0])
TILT_DEG = np.array([24.0, -12.0, 12.0])


def board_pose():
    """T_base_board: the board is behind the base grid, seen from the camera."""
    return pose(rotation_from_vector(np.radians(TILT_DEG)), BOARD_MM)


def scene_trial(condition, rng):
    """Corners of the board: in space, in the camera's picture, on the base grid."""
    camera = equidistance(WIDE_FOV_DEG)
    at = PITCH_MM * (np.indices((ROWS, COLUMNS))[::-1].T - [4, 3])
    corners = on_plane(np.swapaxes(at, 0, 1))
    corners = transform(board_pose(), corners.reshape(-1, 3))
    seen = camera.project(transform(inverse_pose(T_BASE_CAMERA), corners))
    rays = corners - CENTRE_MM
    rays /= np.linalg.norm(rays, axis=1)[:, None]
    hits = intersect_rays_plane(CENTRE_MM, rays, np.eye(4))
    lattice = ROWS, COLUMNS
    return {
        "corners": corners.reshape(*lattice, 3),
        "picture": seen.pixels.reshape(*lattice, 2),
        "synthetic": hits.points.reshape(*lattice, 2),
    }


@experiment("fig_4_1_scene", artefact="fig_4_1")
def scene(effort):
    """One board, its bent picture in a fisheye and the one on the base grid."""
    settings = SETTINGS | {"fov_deg": WIDE_FOV_DEG, "pitch_mm": PITCH_MM}
    return Plan(scene_trial, [{}], 1, settings)
