"""Outcome of each of the six steps of Algorithm 1, on projected boards.

A camera looks at chessboards; their corners are projected, not detected,
so there is no noise. The library calibrates from the corners alone, and the
truth is used only to say what each step gave.
"""

import numpy as np

from chapters.ch02_general_camera_model.s4_1_linear_and_pose.trials.algorithm_1 import (
    COLUMNS,
    ROWS,
    SIZE_PX,
    board_points,
)
from raxel.calibration import (
    BoardView,
    bundle_adjust_fixed_centre,
    linear_well_conditioned,
    pixels_on_board,
)
from raxel.calibration.views.samples import sample_boards
from raxel.cameras.core.base import pixel_grid
from raxel.evaluation.distortion import angular_residual
from raxel.geometry import intersect_rays_plane, on_plane, transform

SAMPLES = 20_000


def view_board(camera, T_camera_grid):
    """Return a BoardView of the corners inside the image; NaN for the others."""
    points = board_points()
    seen = camera.project(transform(T_camera_grid, on_plane(points)))
    inside = seen.valid & camera.in_image(seen.pixels)
    pixels = np.where(inside[:, None], seen.pixels, np.nan)
    return BoardView(pixels, points, COLUMNS, ROWS)


def overlap(views):
    """Return for step 1 the shares of pixels on at least one and three boards."""
    boards = np.zeros((SIZE_PX, SIZE_PX), int)
    for view in views:
        pixels, _ = pixels_on_board(view, SIZE_PX, SIZE_PX)
        boards[pixels[:, 1], pixels[:, 0]] += 1
    return {
        "boards": len(views),
        "one": np.mean(boards >= 1),
        "three": np.mean(boards >= 3),
    }


def locating(camera, views, grids):
    """Return for step 2 the pixels located on boards, and their median error in mm."""
    errors = []
    for view, T_camera_grid in zip(views, grids, strict=True):
        pixels, points = pixels_on_board(view, SIZE_PX, SIZE_PX)
        rays = camera.rays(pixels.astype(float))
        hits = intersect_rays_plane(rays.origins, rays.directions, T_camera_grid)
        errors.append(np.linalg.norm(points - hits.points, axis=1))
    errors = np.concatenate(errors)
    return {"pixels": len(errors), "median_mm": np.median(errors)}


def first_three(views, used, truth):
    """Run steps 3 and 4 on the first three boards of the calibration."""
    samples = sample_boards(views, SIZE_PX, SIZE_PX, SAMPLES)
    points, seen = samples.points[used[:3]], samples.seen[used[:3]]
    start = linear_well_conditioned(points, seen)
    adjusted = bundle_adjust_fixed_centre(points, seen, start.centre, start.T_base_grid)
    observed = seen[:, seen.sum(axis=0) >= 2].sum()
    rms = np.sqrt(adjusted.costs[[0, -1]] / observed)
    return {
        "linear": {"pose_mm": largest_shift(start.T_base_grid, truth[:3])},
        "bundle": {
            "start_mm": rms[0],
            "end_mm": rms[1],
            "pose_mm": largest_shift(adjusted.T_base_grid, truth[:3]),
        },
    }


def largest_shift(poses, truth):
    """Return the largest distance (mm) of estimated grid origins from the true ones."""
    return np.linalg.norm((poses - truth)[:, :3, 3], axis=1).max()


def scored_table(camera, table):
    """Return for step 6 the matrices in the table, and the error of its rays."""
    pixels = pixel_grid(SIZE_PX, SIZE_PX)
    true, found = camera.rays(pixels), table.rays(pixels)
    both = true.valid & found.valid
    matrices = table.pluecker().reshape(-1, 4, 4)[both]
    turned = angular_residual(found.directions[both], true.directions[both])
    middle = np.array([[SIZE_PX / 2, SIZE_PX / 2], [SIZE_PX / 2 + 1, SIZE_PX / 2]])
    a, b = camera.rays(middle).directions
    return {
        "matrices": int(np.isfinite(matrices).all(axis=(1, 2)).sum()),
        "share": table.share_with_ray,
        "median_deg": np.degrees(np.median(turned)),
        "largest_deg": np.degrees(turned.max()),
        "pixel_deg": np.degrees(np.linalg.norm(a - b)),
    }
