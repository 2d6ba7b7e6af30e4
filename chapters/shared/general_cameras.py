"""Cameras of section 2.3, and what two grids in known poses say of them."""

from __future__ import annotations

import numpy as np

from raxel.calibration import rays_from_known_motion
from raxel.cameras import FisheyeCamera, GeneralCamera, PerspectiveCamera
from raxel.cameras.base import pixel_grid
from raxel.cameras.planar_mirrors import PlanarMirrorsCamera
from raxel.geometry import (
    intersect_rays_plane,
    pluecker_matrix,
    pluecker_vector,
    pose,
    rotation_from_vector,
)

APEX_MM = 300.0
EDGE_MM = 260.0
SLOPE = 0.12
FOCAL_PER_WIDTH = 0.9
FISHEYE_FOV_DEG = 120.0


def pinhole(width, height):
    """A plain perspective camera, its principal point in mid-image."""
    focal = FOCAL_PER_WIDTH * width
    u, v = (width - 1) / 2, (height - 1) / 2
    K = np.array([[focal, 0, u], [0, focal, v], [0, 0, 1.0]])
    return PerspectiveCamera(K, (), width, height)


def fisheye(width, height):
    """An equidistance fisheye, 120 degrees across its diagonal."""
    middle = np.array([(width - 1) / 2, (height - 1) / 2])
    half = np.radians(FISHEYE_FOV_DEG) / 2
    focal = np.hypot(*middle) / half
    return FisheyeCamera(
        "equidistance", focal, middle, width, height, 1.01 * half
    )


def faceted(width, height):
    """A pinhole before a blunt pyramid of four mirrors, its point ahead.

    The mirrors throw the view back past the camera, in four directions.
    """
    T_viewer_facets, outlines = [], []
    for x, y in ((1, 1), (-1, 1), (-1, -1), (1, -1)):
        corners = EDGE_MM * np.array([[0, 0], [x, 0], [x, y], [0, y]])
        rise = APEX_MM + SLOPE * np.abs(corners).sum(axis=1)
        normal = np.array([SLOPE * x, SLOPE * y, -1.0])
        normal /= np.linalg.norm(normal)
        across = np.cross([0.0, 1.0, 0.0], normal)
        across /= np.linalg.norm(across)
        R = np.column_stack([across, np.cross(normal, across), normal])
        apex = np.array([0.0, 0.0, APEX_MM])
        solid = np.column_stack([corners, rise]) - apex
        T_viewer_facets.append(pose(R, apex))
        outlines.append((solid @ R)[:, :2])
    return PlanarMirrorsCamera(
        pinhole(width, height), np.stack(T_viewer_facets), outlines
    )


CAMERAS = {"pinhole": pinhole, "fisheye": fisheye, "faceted": faceted}
# The way each camera looks, along z of its frame.
AHEAD = {"pinhole": 1.0, "fisheye": 1.0, "faceted": -1.0}


def draw_two_grids(rng, ahead):
    """Poses T_camera_grid (2, 4, 4), near before far, tilted."""
    tilt = rotation_from_vector(np.radians(rng.uniform(-6, 6, (2, 3))))
    near, step = rng.uniform(350, 450), rng.uniform(200, 400)
    shift = np.zeros((2, 3))
    shift[:, :2] = rng.uniform(-30, 30, (2, 2))
    shift[:, 2] = ahead * np.array([near, near + step])
    return pose(tilt, shift)


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
        "table_angle_rad": angles(
            stored.directions, true.directions[both]
        ).max(),
        "jump_deg": largest_jump(camera),
    }


def ray_errors(found, true, rows):
    """Angle (rad) and distance (mm) of found rays from true ones, (M,).

    The distance is that of the true origin from the found line.
    """
    angle = angles(found.directions[rows], true.directions[rows])
    offset = true.origins[rows] - found.origins[rows]
    across = np.cross(offset, found.directions[rows])
    return angle, np.linalg.norm(across, axis=1)


def angles(a, b):
    """Angles (N,) in radians between unit vectors (N, 3)."""
    across = np.linalg.norm(np.cross(a, b), axis=1)
    return np.arctan2(across, np.sum(a * b, axis=1))


def largest_jump(camera):
    """Largest angle (deg) between the rays of neighbours in a row."""
    rays = camera.rays(pixel_grid(camera.width, camera.height)).directions
    rays = rays.reshape(camera.height, camera.width, 3)
    left, right = rays[:, :-1].reshape(-1, 3), rays[:, 1:].reshape(-1, 3)
    return float(np.degrees(np.nanmax(angles(left, right))))


# Plücker matrices

LINES = 100
LARGEST = 1.0  # metres: points and distances are of order one
LEAST_APART = 0.05


def two_pairs_trial(condition, rng):
    """100 lines, each by two pairs of its points: differences of (2.11)."""
    origins, directions = draw_lines(rng)
    first, second = (
        normalised(pluecker_matrix(*homogeneous_pair(o, directions, rng)))
        for o in (origins, origins)
    )
    return {
        "difference": np.abs(first - second).max(),
        "asymmetry": np.abs(first + np.swapaxes(first, 1, 2)).max(),
    }


def origin_trial(condition, rng):
    """Moments of (2.12): 100 lines through the origin, and 100 beside."""
    origins, directions = draw_lines(rng)
    ratio = {}
    for name, place in (("through", 0.0), ("beside", origins)):
        pair = homogeneous_pair(place, directions, rng)
        vectors = pluecker_vector(pluecker_matrix(*pair))
        ratio[name] = np.linalg.norm(vectors[:, 3:], axis=1)
        ratio[name] /= np.linalg.norm(vectors, axis=1)
    nearest = np.linalg.norm(np.cross(origins, directions), axis=1)
    return {
        "through_origin": ratio["through"].max(),
        "beside_origin": ratio["beside"].min(),
        "least_distance_m": nearest.min(),
    }


def draw_lines(rng):
    """Points (100, 3) and unit directions of lines, any way up."""
    origins = rng.uniform(-LARGEST, LARGEST, (LINES, 3))
    directions = rng.normal(size=(LINES, 3))
    return origins, directions / np.linalg.norm(
        directions, axis=1, keepdims=True
    )


def homogeneous_pair(origins, directions, rng):
    """Two points (N, 4) on each line, apart, each at a scale of its own."""
    places = rng.uniform(-LARGEST, LARGEST, (2, len(directions)))
    close = np.abs(places[0] - places[1]) < LEAST_APART * LARGEST
    places[1, close] = places[0, close] + LARGEST
    for place in places:
        point = origins + place[:, None] * directions
        scale = rng.uniform(0.2, 5.0, (len(point), 1))
        yield scale * np.column_stack([point, np.ones(len(point))])


def normalised(matrices):
    """Matrices at unit norm, their largest entry positive."""
    flat = matrices.reshape(len(matrices), -1)
    flat = flat / np.linalg.norm(flat, axis=1, keepdims=True)
    largest = np.argmax(np.abs(np.triu(matrices)).reshape(flat.shape), 1)
    sign = np.sign(flat[np.arange(len(flat)), largest])
    return (sign[:, None] * flat).reshape(matrices.shape)


# An error put on T_1

LEVELS = (0.1, 0.2, 0.5, 1.0, 2.0)
KINDS = {"translation": "mm", "rotation": "deg"}
STEP_MM = 250.0


def wrong_motion_trial(condition, rng):
    """Ray error (deg) of the two-pose method with T_1 wrong by a level.

    The wrong T_1 goes the same way at every level of a trial: a shift
    along a random direction, or a turn about a random axis of grid 2.
    """
    camera = fisheye(160, 120)
    pixels = rng.uniform([0, 0], [159, 119], (400, 2))
    true = camera.rays(pixels)
    grids = draw_two_grids(rng, 1.0)
    hits = intersect_rays_plane(true.origins, true.directions, grids)
    way = rng.normal(size=3)
    way /= np.linalg.norm(way)
    out = {"step_mm": float(grids[1, 2, 3] - grids[0, 2, 3])}
    for level in (0.0, *LEVELS):
        wrong = grids.copy()
        wrong[1] = grids[1] @ error_pose(condition["kind"], level * way)
        found = rays_from_known_motion(hits.points, wrong)
        both = found.valid & true.valid
        angle, gap = ray_errors(found, true, both)
        out[f"ray_deg.{level:g}"] = np.degrees(np.median(angle))
        out[f"gap_mm.{level:g}"] = np.median(gap)
    return out


def error_pose(kind, error):
    """Pose (4, 4) of an error (3,) in mm, or in degrees about an axis."""
    if kind == "translation":
        return pose(np.eye(3), error)
    return pose(rotation_from_vector(np.radians(error)), np.zeros(3))
