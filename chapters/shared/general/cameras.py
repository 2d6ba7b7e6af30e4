"""Cameras of section 2.3, and two grids in drawn poses in front of them."""

import numpy as np

from raxel.cameras import FisheyeCamera, PerspectiveCamera, PlanarMirrorsCamera
from raxel.geometry import pose, rotation_from_vector

APEX_MM = 300.0
EDGE_MM = 260.0
SLOPE = 0.12
FOCAL_PER_WIDTH = 0.9
FISHEYE_FOV_DEG = 120.0
# How a known motion can be wrong, and in what that is measured.
KINDS = {"translation": "mm", "rotation": "deg"}


def pinhole(width, height):
    """Return a perspective camera with its principal point in mid-image."""
    focal = FOCAL_PER_WIDTH * width
    u, v = (width - 1) / 2, (height - 1) / 2
    K = np.array([[focal, 0, u], [0, focal, v], [0, 0, 1.0]])
    return PerspectiveCamera(K, (), width, height)


def fisheye(width, height):
    """Return an equidistance fisheye, 120 degrees across its diagonal."""
    middle = np.array([(width - 1) / 2, (height - 1) / 2])
    half = np.radians(FISHEYE_FOV_DEG) / 2
    focal = np.hypot(*middle) / half
    return FisheyeCamera("equidistance", focal, middle, width, height, 1.01 * half)


def faceted(width, height):
    """Return a pinhole in front of a blunt pyramid of four mirrors.

    The apex points to the camera. The mirrors reflect the view past the camera, in
    four directions.
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


def draw_two_grids(rng, ahead):
    """Draw poses T_camera_grid (2, 4, 4), tilted, the near one first."""
    tilt = rotation_from_vector(np.radians(rng.uniform(-6, 6, (2, 3))))
    near, step = rng.uniform(350, 450), rng.uniform(200, 400)
    shift = np.zeros((2, 3))
    shift[:, :2] = rng.uniform(-30, 30, (2, 2))
    shift[:, 2] = ahead * np.array([near, near + step])
    return pose(tilt, shift)
