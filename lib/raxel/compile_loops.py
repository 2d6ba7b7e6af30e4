"""Compile the library's loops in advance: `python -m raxel.compile_loops`.

numba compiles a loop when it first runs, and caches the machine code next to the
module. All loops take one to two minutes, once. Programs that start many short
processes compile them first.
"""

import sys

import numpy as np

from raxel.calibration import (
    BoardView,
    DistanceCurve,
    adjust_consistent,
    calibrate_lens,
    dense_view,
    pose_from_rays,
    relax_centrality,
)
from raxel.calibration.generic.board_growth import ray_table
from raxel.calibration.linear.cgsp import homography_to_base, image_noise_weights
from raxel.calibration.smooth.adjustment import adjust_spline
from raxel.calibration.smooth.table import smoothed_rays
from raxel.cameras import (
    FisheyeCamera,
    GeneralCamera,
    PerspectiveCamera,
    QuadricMirrorCamera,
)
from raxel.cameras.mirrors.profiles import BeamProfile
from raxel.features import find_board
from raxel.features.active_grid import decode
from raxel.features.active_grid.lines import corrected_waves, no_ripple
from raxel.features.active_grid.positions import pixels_of
from raxel.features.celect import celect
from raxel.geometry import (
    intersect_rays_plane,
    on_plane,
    pose,
    rotation_from_vector,
    transform,
)
from raxel.lab import Laboratory, Optics, Sensor, board_scene
from raxel.multiview.views import remap_to_plane
from raxel.sets import ActiveGrid, Chessboard, pattern_image, patterns_of, plan_of_cells

BOARD = Chessboard(columns=7, rows=5, pitch_mm=20.0)
CAMERA = FisheyeCamera("equidistance", 150.0, [159.5, 119.5], 320, 240, np.pi / 2)
PINHOLE = PerspectiveCamera([[150, 0, 160], [0, 150, 120], [0, 0, 1]], [], 320, 240)
MIRROR = QuadricMirrorCamera.aligned(PINHOLE, "hyperboloid", (30, 20), 25.0)
DISTANCE_MM = 110.0
MONITOR_PX = 96, 64  # large enough to estimate a response


def compile_loops():
    """Detect a rendered board, and decode a grid, so that every loop has run.

    Returns the detected corners (35, 2), px.
    """
    middle = np.append(BOARD.points().mean(axis=0), -DISTANCE_MM)
    T_camera_board = np.eye(4)
    T_camera_board[:3, 3] = -middle
    scene, optics = board_scene(BOARD, T_camera_board), Optics(blur_sd_px=(0.8, 0.8))
    for well in (10_000, 100_000):
        laboratory = Laboratory(CAMERA, Sensor(0.8 * well, well), optics)
        image = laboratory.render(scene, np.eye(4), np.random.default_rng(0))
    points = on_plane(BOARD.points())
    true = CAMERA.project(transform(T_camera_board, points)).pixels
    clicks = true.reshape(BOARD.rows, BOARD.columns, 2)[[0, 0, -1, -1], [0, -1, -1, 0]]
    view = BoardView(true, BOARD.points(), BOARD.columns, BOARD.rows)
    ray_table([view], T_camera_board[None], np.zeros(3), CAMERA.width, CAMERA.height)
    celect(image, clicks, BOARD.columns, BOARD.rows)
    find_board(image)
    patterns = patterns_of(plan_of_cells(MONITOR_PX, cells=4, phase_steps=4))
    shown = [pattern_image(pattern, MONITOR_PX) for pattern in patterns]
    grid = ActiveGrid(MONITOR_PX)
    decoded = decode(np.array(shown), patterns, grid, neighbours=True, fill=True)
    pixels_of(decoded.location, np.array([[9.0, 9.0]]))
    place = np.moveaxis(np.indices(MONITOR_PX[::-1], float)[::-1], 0, 2)
    remap_to_plane(shown[0], place, None, None, MONITOR_PX, 1.0)
    ray_table([dense_view(place)], T_camera_board[None], np.zeros(3), *MONITOR_PX)
    ripple = no_ripple()._replace(steps=patterns[-1].of, times=1)
    corrected_waves(ripple, np.ones(1, complex), np.zeros(1), np.zeros(1))
    for kind in (np.float32, np.float64):
        grids = np.stack([place.reshape(-1, 2)] * 2).astype(kind)
        fit = homography_to_base(grids, np.ones(grids.shape[:2], bool), 1)
        image_noise_weights(*grids, fit.H, [0.0, 0.0, 1.0])
    _adjust_grids()
    _smooth_rays()
    _look_up_rays()
    BeamProfile([1.0], [0.0]).at(np.zeros(1))
    DistanceCurve(np.ones(4), (0.0, 1.0)).tangents(np.ones(1))
    return find_board(image, BOARD.columns, BOARD.rows).corners


def _adjust_grids():
    """Adjust three tilted grids in front of a pinhole camera, central and not."""
    centre = np.array([0.0, 0.0, -DISTANCE_MM])
    rays = on_plane(BOARD.points()) - centre
    grids = pose(
        rotation_from_vector([[0, 0, 0], [0.3, 0, 0], [0, 0.3, 0]]), np.zeros(3)
    )
    points = intersect_rays_plane(centre, rays, grids).points
    found = adjust_consistent(points, None, centre, grids, loss="huber")
    pose_from_rays(found.directions, points[1], np.random.default_rng(0), 1.0)
    return relax_centrality(points, found)


def _smooth_rays():
    """Lens formulas and a field of rays, from boards and from rays of a table."""
    places = pose(
        rotation_from_vector([[0, 0, 0], [0.3, 0, 0], [0, 0.3, 0]]),
        [-60.0, -40.0, DISTANCE_MM],
    )
    flat = on_plane(BOARD.points())
    boards = [
        (CAMERA.project(transform(T, flat)).pixels, BOARD.points()) for T in places
    ]
    for law in ("kannala-brandt", "unified"):
        views = [BoardView(*board, BOARD.columns, BOARD.rows) for board in boards]
        calibrate_lens(views, CAMERA.width, CAMERA.height, law)
    adjust_spline(CAMERA, places, boards, CAMERA.width, CAMERA.height)
    pixels = np.concatenate([found for found, _ in boards])
    return smoothed_rays(
        pixels, CAMERA.rays(pixels).directions, CAMERA.width, CAMERA.height
    )


def _look_up_rays():
    """Look up rays of a table, and points inside and outside its field of view."""

    table = GeneralCamera.from_camera(CAMERA)
    axis = np.array([0.0, 0.0, DISTANCE_MM])
    seen = table.project([axis, -axis])
    return table.rays(seen.pixels)


def main(words=()):
    """Run `compile_loops`; return the exit status."""
    compile_loops()
    return 0


if __name__ == "__main__":
    sys.exit(main())
