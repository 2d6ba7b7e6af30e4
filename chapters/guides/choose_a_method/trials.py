"""The methods timed while the page is made, on the boards of one fisheye."""

import numpy as np

from chapters.shared.algorithm_1 import COLUMNS as BOARD_COLUMNS
from chapters.shared.algorithm_1 import ROWS as BOARD_ROWS
from chapters.shared.algorithm_1 import SIZE_PX, board_points, draw_poses
from chapters.shared.general_cameras import draw_two_grids, fisheye
from chapters.shared.run_times import timed
from raxel.calibration import (
    BoardView,
    calibrate_generic,
    calibrate_zhang,
    rays_from_known_motion,
)
from raxel.calibration.parametric.opencv_fisheye import calibrate_opencv_fisheye
from raxel.cameras.core.base import pixel_grid
from raxel.geometry import intersect_rays_plane, transform
from repro.run.experiment import trial_rng

BOARD_SHARE = 0.4  # of the board of Algorithm 1, which leaves the image


def whole_board(camera, T_camera_grid):
    """BoardView of a board small enough to be seen whole."""
    points = BOARD_SHARE * board_points()
    flat = np.column_stack([points, np.zeros(len(points))])
    pixels = camera.project(transform(T_camera_grid, flat)).pixels
    return BoardView(pixels, points, BOARD_COLUMNS, BOARD_ROWS)


def method_seconds():
    """Method -> seconds: the boards of one fisheye, calibrated now."""
    rng = trial_rng("ext_methods_seconds", {}, 0)
    camera, size = fisheye(SIZE_PX, SIZE_PX), (SIZE_PX, SIZE_PX)
    views = [whole_board(camera, T) for T in draw_poses(rng)]
    grids = draw_two_grids(rng, 1.0)
    rays = camera.rays(pixel_grid(*size))
    hits = intersect_rays_plane(rays.origins, rays.directions, grids)
    return {
        "zhang": timed(lambda: calibrate_zhang(views, *size)),
        "opencv_fisheye": timed(lambda: calibrate_opencv_fisheye(views, *size)),
        "general": timed(lambda: calibrate_generic(views, *size, rng=rng)),
        "motion": timed(lambda: rays_from_known_motion(hits.points, grids)),
    }
