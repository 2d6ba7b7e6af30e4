"""A sheet clamped at one edge and bent in stages, with a grid that it shows."""

import numpy as np

from raxel.calibration.mirror.observations import normalised
from raxel.cameras import BentMirrorCamera, PerspectiveCamera, SplineMirrorCamera
from raxel.geometry import on_plane, pose, rotation_from_vector, spline_grid, transform
from tests.mirror_scenes import lattice

W, H = 3072, 2304
VIEWER = PerspectiveCamera(
    [[7600, 0, 1540.0], [0, 7600, 1160.0], [0, 0, 1]], [-0.08, 0.02], W, H
)
SIZE = (160.0, 100.0)
FORCE = 150.0  # mm from the clamp, which is the edge x = -80 of the sheet
TURN, CENTRE = np.array([0.02, np.radians(-30), 0.0]), np.array([0.0, 0.0, 410.0])
T_VIEWER_MIRROR = pose(rotation_from_vector(TURN), CENTRE)
GRID = lattice(14, 13, 18.0)


def bent(deflection, viewer=VIEWER):
    """The beam's cubic (5.1): zero and level at the clamp, `deflection` mm at FORCE."""
    half = SIZE[0] / 2
    one, two = np.array([1, 2, 1.0]), np.array([1, 3, 3, 1.0])
    heights = np.append(3 * FORCE * half**2 * one, 0) - half**3 * two
    heights *= deflection / (2 * FORCE**3)
    return BentMirrorCamera(
        viewer, SIZE, heights[:, None], T_viewer_mirror=T_VIEWER_MIRROR
    )


def edge_pixels(x=-79.9, count=9):
    """Pixels (count, 2) along a line of the sheet that bending does not move."""
    y = np.linspace(-48, 48, count)
    points = np.column_stack([np.full(count, x), y, np.zeros(count)])
    return VIEWER.project(transform(T_VIEWER_MIRROR, points)).pixels


def force_pixel(deflection):
    """Pixel (1, 2) that sees the point where the force acts."""
    point = np.array([[FORCE - SIZE[0] / 2, 0.0, deflection]])
    return VIEWER.project(transform(T_VIEWER_MIRROR, point)).pixels


def heights_at(camera, pixels):
    """Heights (N,) over the flat sheet, mm, of the mirror points that pixels see."""
    points = camera.rays(pixels).origins
    return (points - CENTRE) @ T_VIEWER_MIRROR[:3, 2]


def visible_pixels(deflection, across=25, down=17):
    """Pixels (N, 2) all over the image of the sheet."""
    x, y = np.meshgrid(np.linspace(-79.9, 79.9, across), np.linspace(-49.9, 49.9, down))
    sheet = bent(deflection).mirror
    points = sheet.point(np.column_stack([x.ravel(), y.ravel()]) / sheet.radius)[0]
    return VIEWER.project(transform(T_VIEWER_MIRROR, points)).pixels


def spline_like(camera, deflection, shape=(7, 3), quantity="inverse depth", **more):
    """The spline nearest to a bent sheet, over its whole image."""
    pixels = visible_pixels(deflection, 60, 40)
    grid = spline_grid(normalised(VIEWER, pixels), shape, **more)
    points = camera.rays(pixels).origins
    points = points[np.isfinite(points[:, 0])]
    return SplineMirrorCamera.fitted(VIEWER, grid, points, quantity)


def grid_pose(distance=260.0, turn=(4.0, -3.0, 5.0)):
    """T_camera_grid of the grid, its middle on the middle pixel's ray, `distance` mm
    from the flat mirror, facing it but for a turn in degrees."""
    middle = bent(0.0).rays(VIEWER.project(CENTRE[None]).pixels)
    z = middle.directions[0]
    x = np.cross([0, 1.0, 0], z)
    x /= np.linalg.norm(x)
    R = np.column_stack([x, np.cross(z, x), z])
    R = R @ rotation_from_vector(np.radians(turn))
    return pose(R, middle.origins[0] + distance * z - R[:, :2] @ GRID.mean(axis=0))


def seen(camera, T_camera_grid, rng=None, sd=0.2, points=GRID):
    """Pixels (N, 2) of the grid's corners with noise of sd px; NaN where unseen."""
    pixels = camera.project(transform(T_camera_grid, on_plane(points))).pixels
    pixels[~VIEWER.in_image(pixels)] = np.nan
    if rng is not None:
        pixels = pixels + sd * rng.standard_normal(pixels.shape)
    return pixels
