"""Geometry A of chapter 5: camera, platter on its board, monitor in two places."""

import numpy as np

from raxel.calibration import BoardView, FlatMirrorImage, StageView, dense_view
from raxel.cameras import (
    FlexibleMirrorCamera,
    PerspectiveCamera,
    PlanarMirrorsCamera,
    SplineMirrorCamera,
    pixel_grid,
)
from raxel.geometry import (
    intersect_rays_plane,
    on_plane,
    pose,
    rotation_from_vector,
    spline_grid,
    transform,
)

W, H = 3072, 2304
VIEWER = PerspectiveCamera(
    [[7600, 0, 1540.0], [0, 7600, 1160.0], [0, 0, 1]], [-0.08, 0.02], W, H
)
# A 180-degree rotation about this axis puts the clamp to the right and the sheet at 60
# degrees.
SHEET = pose(
    rotation_from_vector(np.pi * np.array([np.sin(np.pi / 12), 0, np.cos(np.pi / 12)])),
    np.array([68.0, 0, 370]),
)
THICKNESS, RADIUS = 0.8, 32.5  # of a platter of 2.5 inches, mm


def lattice(columns, rows, pitch):
    """Corners (N, 2) of a flat grid about its own origin at the first corner."""
    y, x = np.mgrid[:rows, :columns]
    return pitch * np.column_stack([x.ravel(), y.ravel()]).astype(float)


def posed(turn_deg, shift):
    return pose(rotation_from_vector(np.radians(turn_deg)), np.array(shift, float))


def view(camera, T_camera_grid, points, columns, rows, rng=None, sd=0.0):
    """BoardView of points (N, 2) in a pose, with noise of sd px; NaN where unseen."""
    pixels = camera.project(transform(T_camera_grid, on_plane(points))).pixels
    if rng is not None:
        pixels = pixels + sd * rng.standard_normal(pixels.shape)
    spread = np.full(len(points), sd) if sd else None
    return BoardView(pixels, points, columns, rows, "", spread)


def platter_scene(rng=None, sd=0.0, places=1, pitch=10.0, grid_sd=None):
    """Pictures of a monitor in two places 100 mm apart, seen in a platter on a board.

    sd, grid_sd: px, of the board's and the monitor's corners; places: of the platter;
    pitch: of the corners on the monitor, 240 x 180 mm. Returns PlatterPictures and the
    true T_camera_grid (2, 4, 4).
    """
    boards, cells = lattice(13, 10, 9.0), (13, 10)
    lit = int(240 / pitch) + 1, int(180 / pitch) + 1
    monitor, grid_sd = lattice(*lit, pitch), sd if grid_sd is None else grid_sd
    grids = np.stack([monitor_pose(0.0), monitor_pose(100.0)])
    pictures = []
    for place in range(places):
        T = posed([2 - 4 * place, 37 - 3 * place, 1], [-40, -42, 366 - 6 * place])
        mirror = disc_camera(T, [54, 40])
        free = np.linalg.norm(boards - [54, 40], axis=1) > RADIUS + 3
        for position, T_grid in enumerate(grids):
            board = view(VIEWER, T, boards, *cells, rng, sd)
            board.pixels[~free | ~VIEWER.in_image(board.pixels)] = np.nan
            grid = view(mirror, T_grid, monitor, *lit, rng, grid_sd)
            pictures.append(FlatMirrorImage(board, grid, place, position))
    return pictures, grids


AWAY = np.array([-0.957, 0.0, -0.29]) / np.hypot(0.957, 0.29)


def monitor_pose(shift):
    """T_camera_grid of the monitor, moved by mm away from the mirror."""
    T = posed([3, 73, 4], [0, 0, 0])
    centre = np.array([-226, 12, 264.0]) + shift * AWAY
    T[:3, 3] = centre - T[:3, :2] @ [120, 90]
    return T


def disc_camera(T_camera_board, centre):
    """The viewer with the platter: a disc, THICKNESS nearer than its board."""
    around = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    outline = RADIUS * np.column_stack([np.cos(around), np.sin(around)])
    return PlanarMirrorsCamera(
        VIEWER, [T_camera_board @ posed([0, 0, 0], [*centre, -THICKNESS])], [outline]
    )


def small(share=16):
    """The viewer with pixels `share` times as wide, for images of every pixel."""
    scale = np.diag([1 / share, 1 / share, 1])
    return PerspectiveCamera(scale @ VIEWER.K, VIEWER.radial, W // share, H // share)


def flexible_camera(deflection=0.0, viewer=VIEWER, **changes):
    """Geometry A: a sheet of 160 x 100 mm, clamped at the right, 370 mm deep there."""
    more = {"holder": 3.0, "T_viewer_mirror": SHEET} | changes
    return FlexibleMirrorCamera(viewer, (160.0, 100.0), 150.0, deflection, **more)


def spline_camera(quantity="inverse depth", deflection=6.0, viewer=VIEWER):
    """A bent mirror of the spline's own space, near a sheet so deflected."""
    sheet = flexible_camera(deflection)
    v, u = np.mgrid[0:H:60, 0:W:60]
    seen = sheet.rays(np.column_stack([u.ravel(), v.ravel()]).astype(float))
    points = seen.origins[seen.valid]
    grid = spline_grid(points[:, :2] / points[:, 2:])
    return SplineMirrorCamera.fitted(viewer, grid, points, quantity)


def lit_views(camera, T_camera_grid, rng=None, sd_mm=0.0):
    """DenseViews of a monitor that lights every pixel, by a camera with a mirror."""
    rays = camera.rays(pixel_grid(camera.width, camera.height))
    views = []
    for T in T_camera_grid:
        location = intersect_rays_plane(rays.origins, rays.directions, T).points
        if rng is not None:
            location = location + sd_mm * rng.standard_normal(location.shape)
        view = dense_view(location.reshape(camera.height, camera.width, 2))
        views.append(view)
    return views


BOARD = lattice(14, 13, 18.0)


def board_pose(turn_deg, shift=(0, 0, 0)):
    """T_camera_grid of the 14 x 13 corner board, about 260 mm in front of the
    mirror."""
    T = posed(np.array([0, 70.0, 0]) + turn_deg, [0, 0, 0])
    centre = np.array([-232.0, 0, 305]) + shift
    T[:3, 3] = centre - T[:3, :2] @ BOARD.mean(axis=0)
    return T


def stage_pictures(cameras, pairs, T_camera_grid, rng=None, sd=0.0):
    """StageViews of the board: for each pair (stage, grid), as the mirror shows it."""
    return [
        StageView(s, g, view(cameras[s], T_camera_grid[g], BOARD, 14, 13, rng, sd))
        for s, g in pairs
    ]
