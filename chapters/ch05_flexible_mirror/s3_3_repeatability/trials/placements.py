"""What the place of the board does to a deflection, at two pitches.

The mirror, its primary calibration and the error of every corner stay; the board is
held elsewhere, time after time. The board of half the pitch has the other's corners
among its own, with the same errors.
"""

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_repeatability.trials.run import travelled
from chapters.shared.mirror_rigs import STAGES_MM
from chapters.shared.mirror_runs import PUBLISHED, deflected, primary
from raxel.errors import CalibrationError
from raxel.geometry import transform
from raxel.geometry.planes import on_plane
from raxel.sets import Chessboard

PLACES = 5
# Stages before and after: the first step of Table 5.5.
BEFORE, AFTER = 0, 1


def in_all_places(rig, bench, errors, seed):
    """{pitch: deflections (PLACES,) mm}, NaN where rejected, and their number."""
    rng = np.random.default_rng(seed)
    ends = STAGES_MM[BEFORE], STAGES_MM[AFTER]
    cameras = [
        rig.camera(mm, aberration_um=bench.aberration_um, seed=seed) for mm in ends
    ]
    first = primary(rig, cameras[0], PUBLISHED, errors, rng)
    boards = boards_of_pitches(rig.board)
    every = len(boards["dense"][0])
    off = [errors.corners(np.zeros((every, 2)), rng) for _ in cameras]
    poses = [rig.board_pose(rng, deflections=ends) for _ in range(PLACES)]

    def deflection(T, points, kept):
        pictures = [
            visible_points(camera, T, points) + shift[kept]
            for camera, shift in zip(cameras, off, strict=True)
        ]
        try:
            stage = deflected(
                first.camera, cameras[1], pictures, points, first.clamp, PUBLISHED
            )
        except CalibrationError:
            return np.nan
        return travelled(rig, first.camera, stage, *cameras)["deflection_mm"]

    found = {
        pitch: np.array([deflection(T, *board) for T in poses])
        for pitch, board in boards.items()
    }
    refused = {
        f"refused_{pitch}": int(np.isnan(mm).sum()) for pitch, mm in found.items()
    }
    return found | refused


def boards_of_pitches(board):
    """{pitch: (points (N, 2) mm, which (N,) of the dense board's they are)}."""
    columns, rows = 2 * board.columns - 1, 2 * board.rows - 1
    points = Chessboard(columns, rows, board.pitch_mm / 2).points()
    coarse = np.arange(columns * rows).reshape(rows, columns)[::2, ::2].ravel()
    return {"coarse": (points[coarse], coarse), "dense": (points, slice(None))}


def visible_points(camera, T_camera_board, points):
    """Pixels (N, 2) of points (N, 2) mm of a board, exact; NaN where not seen."""
    pixels, valid = camera.project(transform(T_camera_board, on_plane(points)))
    return np.where((valid & camera.in_image(pixels))[:, None], pixels, np.nan)
