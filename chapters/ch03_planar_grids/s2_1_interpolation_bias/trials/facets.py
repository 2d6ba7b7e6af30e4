"""A camera that views a monitor in two flat mirrors."""

import math
from functools import cache

import numpy as np

from chapters.ch03_planar_grids.s2_1_interpolation_bias.trials.interpolators import (
    nearest_four,
    through_four,
)
from raxel.cameras import PerspectiveCamera, PlanarMirrorsCamera
from raxel.geometry.planes import intersect_rays_plane, on_plane
from raxel.geometry.poses import pose, rotation_from_vector, transform
from raxel.sets import ActiveGrid

WIDTH_PX, FOCAL_PX = 480, 600.0
RIDGE_MM, MONITOR_MM = 300.0, 400.0  # camera to ridge, ridge to monitor
RAISED_DEG, FACET_DEG = 20.0, 1.5
RIDGE_PX = (WIDTH_PX - 1) / 2  # column of the ridge, which is upright
TILT_DEG, SHIFT_MM = 10.0, 20.0
PITCH_MM = 20.0
GROSS_MM = 1.0
GRID = ActiveGrid((1920, 1200), (518.0, 324.0))


def turned(*vector_deg):
    """Rotation (3, 3) by a vector in degrees."""
    return rotation_from_vector(np.radians(vector_deg))


@cache
def two_facets(facet_deg, height_px):
    """The camera: facet 0 at the left of an upright ridge, facet 1 at its right.

    Each is rotated away from the other by facet_deg, and raised so that the camera
    views the monitor above itself.
    """
    middle = [RIDGE_PX, (height_px - 1) / 2]
    K = [[FOCAL_PX, 0, middle[0]], [0, FOCAL_PX, middle[1]], [0, 0, 1]]
    viewer = PerspectiveCamera(K, (), WIDTH_PX, height_px)
    raised = turned(-RAISED_DEG, 0, 0)
    poses, outlines = [], []
    for side in (-1, 1):
        R = raised @ turned(0, -side * facet_deg, 0)
        poses.append(pose(R, [0, 0, RIDGE_MM]))
        outline = np.array([[0, -200], [side * 250, -200]])
        outlines.append(np.vstack([outline, outline[::-1] * [1, -1]]))
    return PlanarMirrorsCamera(viewer, np.array(poses), outlines)


def monitor_pose(rng):
    """Pose (4, 4) of the screen, orthogonal to the reflected axis, then perturbed."""
    up = math.radians(2 * RAISED_DEG)
    away = np.array([0.0, -math.sin(up), -math.cos(up)])
    across = np.array([-1.0, 0.0, 0.0])
    R = np.column_stack([across, np.cross(away, across), away])
    R = R @ turned(*rng.uniform(-TILT_DEG, TILT_DEG, 2), 0)
    middle = [0, 0, RIDGE_MM] + MONITOR_MM * away
    middle = middle + R @ [*rng.uniform(-SHIFT_MM, SHIFT_MM, 2), 0]
    return pose(R, middle - R @ [*np.divide(GRID.monitor_mm, 2), 0])


def chessboard_corners(camera, T_camera_monitor):
    """Visible corners of a chessboard in place of the monitor's screen.

    Returns pixels (N, 2), points (N, 2) mm, places (N, 2) int and the facet (N,).
    """
    count = np.array(GRID.monitor_mm) // PITCH_MM
    places = np.stack(
        np.meshgrid(*(np.arange(n + 1, dtype=int) for n in count)), -1
    ).reshape(-1, 2)
    points = PITCH_MM * places
    space = transform(T_camera_monitor, on_plane(points))
    found = []
    for facet in range(2):
        seen = camera.project_facet(space, facet)
        here = np.flatnonzero(seen.valid)
        own = np.full(len(here), facet)
        found.append((seen.pixels[here], points[here], places[here], own))
    return [np.concatenate(part) for part in zip(*found, strict=True)]


def interpolated(pixels, corners, facets=None):
    """Points (M, 2) of pixels by their four nearest corners, NaN without four.

    corners: as `chessboard_corners`. facets: (M,) facet of each pixel, if known.
    Then only corners of the same facet are used.
    """
    seen, points, places, own = corners
    found = np.full(pixels.shape, np.nan)
    groups = [(slice(None), slice(None))]
    if facets is not None:
        groups = [(facets == k, own == k) for k in range(2)]
    for asked, given in groups:
        four = nearest_four(pixels[asked], seen[given], places[given])
        part = np.full((len(four), 2), np.nan)
        good = four[:, 0] >= 0
        four = four[good]
        part[good] = through_four(
            pixels[asked][good], seen[given][four], points[given][four]
        )
        found[asked] = part
    return found


def ridge_distance(pixels):
    """Distance (M,) px of pixels (M, 2) from the ridge."""
    return np.abs(pixels[:, 0] - RIDGE_PX)


def jump_mm(camera, T_camera_monitor):
    """Distance in mm on the monitor between both sides of the ridge, mid-image."""
    sides = [[RIDGE_PX + d, camera.height / 2] for d in (-1e-6, 1e-6)]
    rays = camera.rays(np.array(sides))
    met = intersect_rays_plane(rays.origins, rays.directions, T_camera_monitor)
    return float(np.linalg.norm(met[0][1] - met[0][0]))


def square_px(corners):
    """Mean width in px of a square, over neighbours in a row within a facet."""
    seen, _, places, own = corners
    beside = np.all(np.diff(places, axis=0) == [1, 0], axis=1)
    beside &= np.diff(own) == 0
    steps = np.linalg.norm(np.diff(seen, axis=0), axis=1)
    return float(steps[beside].mean())
