"""Two grids in known poses: calibration of any camera, and errors of a motion."""

import numpy as np

from chapters.shared.general_cameras import CAMERAS, draw_two_grids
from raxel.calibration import rays_from_known_motion
from raxel.cameras import GeneralCamera
from raxel.cameras.core.base import pixel_grid
from raxel.geometry import intersect_rays_plane, pose, rotation_from_vector
from repro.run.experiment import experiment
from repro.run.outcomes import Plan, crossed

# Viewing direction of each camera, along z of its frame.
AHEAD = {"pinhole": 1.0, "fisheye": 1.0, "faceted": -1.0}

# Errors of T_1, in mm or degrees.
LEVELS = (0.1, 0.2, 0.5, 1.0, 2.0)

POSES = {"quick": 3, "full": 30}


def known_motion_trial(condition, rng):
    """Calibrate every pixel of a camera by two known grids, no noise."""
    name = condition["camera"]
    camera = CAMERAS[name](160, 120)
    pixels = pixel_grid(camera.width, camera.height)
    true = camera.rays(pixels)
    grids = draw_two_grids(rng, AHEAD[name])
    hits = intersect_rays_plane(true.origins, true.directions, grids)
    found = rays_from_known_motion(hits.points, grids)
    both = found.valid & true.valid
    angle, gap = ray_errors(found, true, both)
    shape = (camera.height, camera.width)
    table = GeneralCamera(
        found.directions.reshape(*shape, 3),
        found.valid.reshape(shape),
        found.origins.reshape(*shape, 3),
    )
    stored = table.rays(pixels[both])
    return {
        "angle_rad": angle.max(),
        "gap_mm": gap.max(),
        "share": both.sum() / true.valid.sum(),
        "table_angle_rad": angles(stored.directions, true.directions[both]).max(),
        "jump_deg": largest_jump(camera),
    }


def ray_errors(found, true, rows):
    """Return angle (rad) and distance (mm) of estimated rays from true ones, (M,).

    The distance is that of the true origin from the estimated line.
    """
    angle = angles(found.directions[rows], true.directions[rows])
    offset = true.origins[rows] - found.origins[rows]
    across = np.cross(offset, found.directions[rows])
    return angle, np.linalg.norm(across, axis=1)


def angles(a, b):
    """Return angles (N,) in radians between unit vectors (N, 3)."""
    across = np.linalg.norm(np.cross(a, b), axis=1)
    return np.arctan2(across, np.sum(a * b, axis=1))


def largest_jump(camera):
    """Return the largest angle (deg) between rays of neighbours in a row."""
    rays = camera.rays(pixel_grid(camera.width, camera.height)).directions
    rays = rays.reshape(camera.height, camera.width, 3)
    left, right = rays[:, :-1].reshape(-1, 3), rays[:, 1:].reshape(-1, 3)
    return float(np.degrees(np.nanmax(angles(left, right))))


def error_pose(kind, error):
    """Return the pose (4, 4) of an error (3,) in mm, or in degrees about an axis."""
    if kind == "translation":
        return pose(np.eye(3), error)
    return pose(rotation_from_vector(np.radians(error)), np.zeros(3))


@experiment("exp_c2_nonparam_any", artefact="fig_2_1", shards={"full": 2})
def two_known_grids(effort):
    """Every pixel of three cameras, calibrated by two known grids."""
    settings = {
        "image_px": [160, 120],
        "grids": "near one 350 to 450 mm away, the far one 200 to 400 mm "
        "behind it, each turned by up to 6 deg about every axis; no noise",
    }
    conditions = crossed(camera=("pinhole", "fisheye", "faceted"))
    return Plan(known_motion_trial, conditions, POSES[effort], settings)
