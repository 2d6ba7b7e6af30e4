"""Two orthogonal chessboards on a stage in front of the mirror camera of 4.3.1.

The target's frame has its z axis along the fold of the boards, upwards; both boards
face the quadrant of positive x and y. The stage rotates about a vertical axis in that
quadrant, and translates perpendicular to the line of sight.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from chapters.shared.rigs import rig_named
from raxel.errors import CalibrationError
from raxel.geometry import (
    on_plane,
    pose,
    rotation_from_vector,
    transform,
    vector_from_rotation,
)
from raxel.lab import TexturedScene, board_scene
from raxel.lab.sight import Crop
from raxel.lab.target_poses import outline_of
from raxel.multiview.epipolar import relative_pose
from raxel.sets import Chessboard

RIG = "onevr-d70"
RIG_FILES = ("data/rigs/onevr-d70.yaml",)
PITCH_MM, GAP_MM, BORDER_MM = 36.0, 10.0, 8.0
BOARDS = (
    Chessboard(columns=7, rows=4, pitch_mm=PITCH_MM),
    Chessboard(columns=5, rows=4, pitch_mm=PITCH_MM),
)
AXIS_MM = 140.0  # of the stage, from either board
DISTANCE_MM = 260.0  # of the stage's axis from the mirror's focus
CENTRE_MM = np.array([0.0, 0.0, 67.0])  # that focus, in the camera's frame
FACING_DEG = 45.0  # where the camera sees both boards alike
STEP_MM, STEP_DEG = 20.0, 10.0
STEPS = {"translation": 5, "rotation": 11}
SHIFT_SD_MM, TURN_SD_DEG = 2.0, 1.0
MARGIN_PX = 16
SETTINGS = {
    "rig": RIG,
    "boards": [[b.columns, b.rows] for b in BOARDS],
    "pitch_mm": PITCH_MM,
    "axis_from_boards_mm": AXIS_MM,
    "axis_from_mirror_mm": DISTANCE_MM,
    "step_mm": STEP_MM,
    "step_deg": STEP_DEG,
    "steps": STEPS,
}


class Setup(NamedTuple):
    """Position of the target on the stage: turn (3, 3) and shift (3,)."""

    turn: np.ndarray
    shift: np.ndarray


def drawn_setup(rng):
    """Return a random Setup of the target on the stage."""
    turn = np.radians(TURN_SD_DEG) * rng.standard_normal(3)
    return Setup(rotation_from_vector(turn), SHIFT_SD_MM * rng.standard_normal(3))


def target_poses(motion, setup):
    """Return T_camera_target (steps + 1, 4, 4) of a "translation" or "rotation"."""
    along = np.arange(STEPS[motion] + 1) - STEPS[motion] / 2
    turning = motion == "rotation"
    angles = FACING_DEG + (STEP_DEG * along if turning else 0 * along)
    across = 0 * along if turning else STEP_MM * along
    axis = np.array([AXIS_MM, AXIS_MM, 0.0])
    poses = []
    for angle, shift in zip(angles, across, strict=True):
        R = rotation_from_vector([0, 0, np.pi - np.radians(angle)])
        foot = CENTRE_MM + [DISTANCE_MM, shift, 0.0]
        R = R @ setup.turn
        poses.append(pose(R, foot - R @ (axis + setup.shift)))
    return np.stack(poses)


def board_poses():
    """Return T_target_board (2, 4, 4): the boards' frames in the target's."""
    poses = []
    for board, right, towards in (
        (BOARDS[0], [-1.0, 0, 0], [0, 1.0, 0]),
        (BOARDS[1], [0, 1.0, 0], [1.0, 0, 0]),
    ):
        right, towards = np.array(right), np.array(towards)
        down = np.array([0.0, 0, -1.0])
        R = np.column_stack([right, down, -towards])
        out = np.abs(right)
        # The first corner is a square and the border away from the sheet's edge.
        edge = GAP_MM + BORDER_MM + PITCH_MM
        if right.sum() < 0:
            edge += PITCH_MM * (board.columns - 1)
        height = PITCH_MM * (board.rows - 1) / 2
        poses.append(pose(R, edge * out + [0, 0, height]))
    return np.stack(poses)


def corners_of(T_camera_target):
    """Return true corners of both boards, in the camera frame: a list of (N, 3)."""
    return [
        transform(T_camera_target @ T, on_plane(board.points()))
        for board, T in zip(BOARDS, board_poses(), strict=True)
    ]


def true_pixels(camera, T_camera_target):
    """Return the true pixels of both boards' corners: a list of (N, 2) px."""
    return [camera.project(corners).pixels for corners in corners_of(T_camera_target)]


def photograph(T_camera_target, rng):
    """Return (image (h, w) of the part with the target, its first pixel (2,))."""
    rig = rig_named(RIG)
    parts, outlines = [], []
    for board, T in zip(BOARDS, board_poses(), strict=True):
        scene = board_scene(board, T_camera_target @ T, BORDER_MM)
        parts += scene.parts
        sheet = scene.parts[0][0]
        ring = outline_of(sheet.low, sheet.high - sheet.low)
        outlines.append(transform(sheet.T_world_surface, on_plane(ring)))
    window = window_of(rig.camera, np.concatenate(outlines))
    whole = TexturedScene(tuple(parts), scene.background)
    light = rig.laboratory().irradiance(whole, np.eye(4), window=window)
    return rig.sensor.expose(light, rng), np.array([window.u, window.v])


def window_of(camera, points):
    """Return the `Crop` of the image that holds points (N, 3) of the camera frame."""
    seen = camera.project(points).pixels
    full = np.array([camera.width, camera.height])
    low = np.floor(np.nanmin(seen, axis=0)) - MARGIN_PX
    high = np.ceil(np.nanmax(seen, axis=0)) + MARGIN_PX
    low, high = (np.clip(x, 0, full).astype(int) for x in (low, high))
    return Crop(*map(int, (*low, *(high - low), *full)))


def motions(rays):
    """Return T_2_1 (steps, 4, 4) from each image to the next.

    rays: (images, N, 3), NaN for corners without a ray. Raises CalibrationError where
    the rays of a pair do not determine its motion.
    """
    found = []
    for first, second in pairwise(rays):
        both = np.isfinite(first[:, 0]) & np.isfinite(second[:, 0])
        found.append(relative_pose(first[both], second[both]).T_2_1)
    return np.stack(found)


def translation_errors(steps):
    """Return deviations of steps from their mean, mm, each scaled to the stage's step.

    steps: T_2_1 (5, 4, 4). `deviation_mm`: root mean square length of the
    differences from the mean step; `turn_deg`: largest estimated rotation (true: 0).
    """
    shifts = STEP_MM * steps[:, :3, 3]
    off = shifts - shifts.mean(axis=0)
    turns = np.linalg.norm(vector_from_rotation(steps[:, :3, :3]), axis=1)
    return {
        "deviation_mm": np.sqrt(np.mean(np.sum(off**2, axis=1))),
        "turn_deg": np.degrees(turns.max()),
        "shifts": shifts,
    }


def rotation_errors(steps):
    """Return the total angle of all steps, and its error, degrees."""
    whole, turned = np.eye(3), []
    for T in steps:
        whole = T[:3, :3] @ whole
        turned.append(np.degrees(np.linalg.norm(vector_from_rotation(whole))))
    return {
        "total_deg": turned[-1],
        "off_deg": abs(turned[-1] - STEP_DEG * STEPS["rotation"]),
        "turned": np.array(turned),
    }


ERRORS = {"translation": translation_errors, "rotation": rotation_errors}


def scored(motion, rays):
    """Return errors of a "translation" or "rotation", or the code of the failure."""
    try:
        return ERRORS[motion](motions(rays))
    except CalibrationError as error:
        return {"failed": error.code}
