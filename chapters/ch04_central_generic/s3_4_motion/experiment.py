"""Trials of this page, their conditions and constants."""

from __future__ import annotations

from functools import partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from chapters.shared.central import (
    DecodingErrors,
    drawn_lattices,
    lattice_rays,
    true_lattice,
)
from chapters.shared.grids import CLICK_SD_PX, CLICKLESS, clockwise, outer, returned
from chapters.shared.rigs import rig_named
from raxel.calibration import (
    calibrate_central,
    centroid_directions,
    grid_pose_ransac,
    linear_as_printed,
    linear_cgsp,
    linear_well_conditioned,
    pose_from_rays,
    relaxed_start,
)
from raxel.errors import CalibrationError, InputError
from raxel.features import refine
from raxel.features.celect import find_celect
from raxel.geometry import (
    on_plane,
    pose,
    rotation_from_vector,
    transform,
    vector_from_rotation,
)
from raxel.lab import Crop, TexturedScene, board_scene, outline_of
from raxel.multiview import relative_pose
from raxel.sets import Chessboard
from repro.run import Plan, crossed, experiment

# Two orthogonal chessboards on a stage in front of the mirror camera of 4.3.1.
#
# The target's frame has its z axis along the fold of the boards, upwards; both boards
# face the quadrant of positive x and y. The stage rotates about a vertical axis in that
# quadrant, and translates perpendicular to the line of sight.


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


def recorded_image(T_camera_target, rng):
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


# Calibrations of the mirror camera with redrawn decoding errors.
#
# Each pixel of a lattice sees up to six grids. The first three determine the centre and
# their poses, by the standard method or by CGSP. The others are posed from the rays
# known so far.


LATTICE_PX = 16
LINEAR_GRIDS = 3
THRESHOLD_MM = 1.0  # of RANSAC, ray-point distance
METHODS = ("as printed", "well conditioned", "CGSP")
SWEPT_METHODS = ("as printed", "CGSP")  # along the sweep of the noise level


class SeenGrids(NamedTuple):
    """Points of the six grids of a run that pixels see.

    T_camera_grid: (6, 4, 4), true; true, points: (6, N, 2) mm, true and decoded points
    of lattice pixels, NaN outside a grid.
    """

    T_camera_grid: np.ndarray
    true: np.ndarray
    points: np.ndarray

    @property
    def seen(self):
        """Return (6, N), whether a pixel sees a grid."""
        return np.isfinite(self.points).all(axis=2)

    def at(self, noise, rng):
        """Return the same with decoding errors of a `DecodingNoise`."""
        return self._replace(points=noise.points(self.points, self.true, rng))


def drawn_grids(errors, rng):
    """Return the SeenGrids of random poses in front of the camera, DecodingErrors."""
    rig = rig_named(RIG)
    size_mm = np.array(rig.target.monitor_mm)
    rays, shape = lattice_rays(rig.camera, LATTICE_PX)
    poses = rig.draw_poses(rng, rig.count)
    true, decoded = (
        points.reshape(len(poses), -1, 2)
        for points in drawn_lattices(
            rays, shape, poses, size_mm, LATTICE_PX, rng, errors
        )
    )
    some = np.isfinite(decoded).all(axis=2).any(axis=0)
    return SeenGrids(poses, true[:, some], decoded[:, some])


def calibrated(method, grids, rng):
    """Return the CentralCalibration by one of METHODS; CalibrationError if it fails."""
    if method == "CGSP":
        first, seen = grids.points[:LINEAR_GRIDS], grids.seen[:LINEAR_GRIDS]
        start = linear_cgsp(first, seen, robust="ransac", rng=rng)
        place = grid_pose_ransac
    else:
        start, place = standard_start(method, grids), pose_from_rays
    found = calibrate_central(
        grids.points, start, place, rng, threshold=THRESHOLD_MM, join=False
    )
    if found.failed:
        raise CalibrationError(next(iter(found.failed.values())))
    return found


def standard_start(method, grids):
    """Return the adjusted linear stage; as printed it needs rays of all grids."""
    points, seen = grids.points[:LINEAR_GRIDS], grids.seen[:LINEAR_GRIDS]
    if method == "well conditioned":
        return relaxed_start(points, linear_well_conditioned(points, seen))
    start = linear_as_printed(*points[:, seen.all(axis=0)])
    return relaxed_start(points, start)


def grids_at_pixels(pixels, T_camera_grid, errors, rng):
    """Return the SeenGrids of any pixels (M, 2), with DecodingErrors."""
    rig = rig_named(RIG)
    size_mm = np.array(rig.target.monitor_mm)
    rays = rig.camera.rays(pixels)
    true, decoded = [], []
    for T in T_camera_grid:
        points, cosine = true_lattice(rays, (len(pixels),), T, size_mm)
        bias = errors.bias_at(np.nan_to_num(points), cosine)
        noise = rng.standard_normal(points.shape)
        true.append(points)
        decoded.append(points + bias + noise * errors.sd_at(cosine))
    return SeenGrids(T_camera_grid, np.stack(true), np.stack(decoded))


def table_rays(grids, found):
    """Return unit rays (M, 3), base frame, of a table at the pixels of SeenGrids.

    Each ray joins the centre and the centroid of the points that its pixel sees on the
    calibrated grids; NaN where it sees none.
    """
    seen = grids.seen
    out = np.full((seen.shape[1], 3), np.nan)
    some = seen.any(axis=0)
    out[some] = centroid_directions(
        grids.points[:, some], seen[:, some], found.centre, found.T_base_grid
    )
    return out


# Corners of both boards in rendered images, and redrawn for further runs.


DETECTORS = ("CELECT", "without clicks")
SWEPT_DETECTOR = "CELECT"  # along the sweep of the noise level


def by_celect(image, board, lattice, rng):
    """Return corners (N, 2) from four clicks on the board, None if rejected.

    lattice: true corners (rows, columns, 2), which the user clicks.
    """
    clicks = outer(clockwise(lattice))
    clicks = clicks + CLICK_SD_PX * rng.standard_normal(clicks.shape)
    try:
        found = find_celect(image, board.columns, board.rows, clicks)
    except InputError:
        return None
    return in_order(found.corners, lattice) if found.found else None


def by_hand(image, board, lattice, rng):
    """Return corners (N, 2) clicked one by one, then refined."""
    clicks = lattice.reshape(-1, 2)
    clicks = clicks + CLICK_SD_PX * rng.standard_normal(clicks.shape)
    return refine(image, clicks, board.columns, board.rows)


def without_clicks(image, board, lattice):
    """Return corners (N, 2) by the detector of whole boards, None if rejected."""
    found = returned(CLICKLESS, image, board.columns, board.rows)
    return None if found is None else in_order(found, lattice)


def in_order(found, lattice):
    """Return corners (N, 2) in the order of the board, which is given by hand.

    A mirror image does not determine the orientation of a board.
    """
    found = np.asarray(found).reshape(lattice.shape)
    ways = [found[::r, ::c] for r in (1, -1) for c in (1, -1)]
    gaps = [np.linalg.norm(way - lattice, axis=2).mean() for way in ways]
    return ways[int(np.argmin(gaps))].reshape(-1, 2)


def detected_boards(poses, rng):
    """Return errors and rejections of the detectors on the target in poses (n, 4, 4).

    errors: {detector: a list for each board of (n, N, 2) px}; boards that a detector
    rejects are clicked by hand. refused: {detector: (n, boards) bool}.
    """
    camera = rig_named(RIG).camera
    errors = {
        name: [np.empty((len(poses), b.columns * b.rows, 2)) for b in BOARDS]
        for name in DETECTORS
    }
    rejected = {name: np.zeros((len(poses), len(BOARDS)), bool) for name in DETECTORS}
    for index, T in enumerate(poses):
        image, first = recorded_image(T, rng)
        seen = zip(BOARDS, true_pixels(camera, T), strict=True)
        for k, (board, true) in enumerate(seen):
            lattice = (true - first).reshape(board.rows, board.columns, 2)
            found = {
                "CELECT": by_celect(image, board, lattice, rng),
                "without clicks": without_clicks(image, board, lattice),
            }
            clicked = by_hand(image, board, lattice, rng)
            for name, corners in found.items():
                rejected[name][index, k] = corners is None
                corners = clicked if corners is None else corners
                errors[name][k][index] = corners - (true - first)
    return errors, rejected


DECODED = {"quick": "onevr-d70-small", "full": "onevr-d70"}
RENDERED = {"quick": 1, "full": 3}
# Quick builds render every n-th image, which represents those up to the next.
EVERY = {"quick": 5, "full": 1}
MEASURED = "table_4_3_errors", "fig_4_10_corners"


def corner_trial(condition, rng, every):
    """Return corner errors and rejections of one run, in images of one motion."""
    setup = drawn_setup(rng)
    poses = target_poses(condition["motion"], setup)[::every]
    errors, rejected = detected_boards(poses, rng)
    return {
        "turn": setup.turn,
        "shift": setup.shift,
        "errors": {
            name: {str(k): e for k, e in enumerate(of_boards)}
            for name, of_boards in errors.items()
        },
        "refused": rejected,
    }


@experiment("fig_4_10_corners", artefact="fig_4_10", inputs=RIG_FILES)
def detected_corners(effort):
    """Plan corners of the target in rendered images, by both detectors."""
    trial = partial(corner_trial, every=EVERY[effort])
    return Plan(trial, crossed(motion=STEPS), RENDERED[effort], SETTINGS)


class MeasuredCorners:
    """Corner errors of the rendered runs, to be redrawn.

    An error has a part common to all runs, which depends on the position, and a
    residual. A redrawn corner has the first, and the residual of any corner of its
    board and image.
    """

    def __init__(self, result, every):
        self.every = every
        self.errors, self.setups = {}, {}
        for motion in STEPS:
            stood = (result.arrays(name, motion=motion) for name in ("turn", "shift"))
            self.setups[motion] = [Setup(*one) for one in zip(*stood, strict=True)]
            for name in DETECTORS:
                self.errors[motion, name] = [
                    np.stack(result.arrays(f"errors.{name}.{k}", motion=motion))
                    for k in range(len(BOARDS))
                ]

    def setup(self, motion, seed, rng):
        """Return the Setup of the target in a rendered run, or a new one (None)."""
        return drawn_setup(rng) if seed is None else self.setups[motion][seed]

    def of_seed(self, motion, name, seed, rng):
        """Return errors (images, corners, 2) px, both boards, of a rendered run,
        or redrawn (None)."""
        if seed is None:
            return self._redrawn(motion, name, rng)
        return np.concatenate(
            [self._all(e[seed], motion) for e in self.errors[motion, name]], axis=1
        )

    def _redrawn(self, motion, name, rng):
        boards = []
        for errors in self.errors[motion, name]:
            shared, own = errors.mean(axis=0), errors[0]
            if len(errors) > 1:
                own = (errors - shared) * np.sqrt(len(errors) / (len(errors) - 1))
                own = own[rng.integers(len(own))]
            else:
                shared = np.zeros_like(shared)
            order = rng.permuted(
                np.broadcast_to(np.arange(own.shape[1]), own.shape[:2]), axis=1
            )
            own = np.take_along_axis(own, order[..., None], axis=1)
            boards.append(self._all(shared + own, motion))
        return np.concatenate(boards, axis=1)

    def _all(self, errors, motion):
        """Return errors of all images, if not rendered those of the last rendered."""
        return errors[np.arange(STEPS[motion] + 1) // self.every]


def measured(results, effort):
    """Return (MeasuredCorners, DecodingErrors) of the rendered images."""
    decoded = DecodingErrors.by_rig(results["table_4_3_errors"])[DECODED[effort]]
    return MeasuredCorners(results["fig_4_10_corners"], EVERY[effort]), decoded


CALIBRATION = {
    "lattice_px": LATTICE_PX,
    "linear_grids": LINEAR_GRIDS,
    "ransac_threshold_mm": THRESHOLD_MM,
}
