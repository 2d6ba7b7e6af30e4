"""A flexible mirror calibrated in the simulated rigs: primary and dynamic stages.

No image is rendered here: corners and decoded points are where the true camera has
them, with the errors that rendered images have (`errors`). A calibration gets what it
would get from images: pixels, boards, the clamp's line, the mirror's edges.
The truth is used to score it.
"""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np

from chapters.shared.mirror.images import platter_camera
from chapters.shared.mirror.scores import angles_between
from raxel.calibration import (
    BoardView,
    FlatMirrorImage,
    MirrorSettings,
    calibrate_zhang,
    clamp_line,
    fixed_line,
    grid_poses_in_platter,
    linear_stage,
    primary_from_points,
    rays_from_known_motion,
    update_mirror,
)
from raxel.cameras import pixel_grid
from raxel.errors import CalibrationError
from raxel.geometry import (
    intersect_rays_plane,
    on_plane,
    pose,
    rotation_from_vector,
    transform,
)

# px between the pixels of the primary stage: about as many as the thesis's 1056 see
# the mirror (5.3.3).
STEP_PX = 64
# px between the pixels that are taken of the monitor in the platter.
PLATTER_STEP_PX = 24
# px between the pixels whose rays are compared: about the thesis's 168 (Table 5.3).
COMPARED_PX = 168
# Boards that the camera sees directly: how many, how far away (mm) and how tilted.
BOARDS, BOARD_MM, BOARD_TILT = 12, (650.0, 900.0), np.radians(30)
CLAMP_PICKS, CLAMP_SD_PX = 9, 0.5
# Points along each edge of the mirror that a person traces in an image.
TRACED = 9


class MirrorMethod(NamedTuple):
    """How the mirror is modelled. quantity: see SplineMirrorCamera; slope: whether the
    clamp holds the slope too, and not the position alone; prior_sd: see
    MirrorSettings."""

    quantity: str
    slope: bool
    prior_sd: float | None = None
    shape: tuple = (7, 3)

    @property
    def settings(self):
        """The MirrorSettings of a stage. No end counts as swinging: the thesis has no
        such rejection, and its interpretation with one is read off the same runs."""
        return MirrorSettings(
            shape=self.shape, prior_sd=self.prior_sd, swinging_deg=np.inf
        )


# As the thesis has it: distances along viewing rays, the clamp's position.
PUBLISHED = MirrorMethod("distance", slope=False)


def shape_name(shape):
    """Such as "7x3": numbers of basis functions along u and v, as trials name them."""
    return f"{shape[0]}x{shape[1]}"


class Primary(NamedTuple):
    """calibration: PrimaryCalibration; clamp: what is held in all stages; places:
    (2, 4, 4), where the monitor was; poses: PlatterPoses of it, as found."""

    calibration: object
    clamp: object
    places: np.ndarray
    poses: object

    @property
    def camera(self):
        """The calibrated camera of stage 0."""
        return self.calibration.camera


def calibrated_viewer(rig, errors, rng):
    """The perspective camera by Zhang's method, from boards that it sees directly."""
    views = []
    points = rig.board.points()
    middle = [*points.mean(axis=0), 0.0]
    while len(views) < BOARDS:
        turn = rng.uniform(-BOARD_TILT, BOARD_TILT, 3) * [1, 1, 0.3]
        R = rotation_from_vector(turn)
        depth = rng.uniform(*BOARD_MM)
        aside = rng.uniform(-0.04, 0.04, 2) * depth
        T = pose(R, np.array([*aside, depth]) - R @ middle)
        pixels, valid = rig.viewer.project(transform(T, on_plane(points)))
        inside = valid & rig.viewer.in_image(pixels)
        pixels = np.where(inside[:, None], errors.corners(pixels, rng), np.nan)
        if inside.mean() > 0.6:
            views.append(BoardView(pixels, points, rig.board.columns, rig.board.rows))
    return calibrate_zhang(views, rig.viewer.width, rig.viewer.height).camera


def primary(rig, camera, method, errors, rng):
    """The Primary of a MirrorRig whose true camera is at stage 0."""
    viewer = calibrated_viewer(rig, errors, rng)
    true = rig.monitor_poses(rng)
    poses = poses_in_platter(rig, viewer, true, errors, rng)
    picks = rig.clamp_pixels(camera, CLAMP_PICKS, rng, CLAMP_SD_PX)
    line = clamp_line(viewer, picks)
    found = primary_from_points(
        viewer,
        *decoded(rig, camera, true, errors, rng),
        poses,
        shape=method.shape,
        angle=line.angle,
        quantity=method.quantity,
        span=line.points(CLAMP_PICKS),
    )
    held = fixed_line(found.camera, line)
    clamp = held if method.slope else held._replace(slopes=None)
    return Primary(found, clamp, true, poses)


def decoded(rig, camera, T_camera_monitor, errors, rng, step_px=STEP_PX):
    """Pixels (N, 2) of a lattice that see a monitor in all places (n, 4, 4), and the
    points (n, N, 2), mm, that were decoded there."""
    pixels = lattice(camera, step_px)
    points = [true_points(rig, camera, pixels, T) for T in T_camera_monitor]
    both = np.isfinite(points).all(axis=(0, 2))
    pixels = pixels[both]
    return pixels, np.stack([errors.in_mirror(p[both], rng) for p in points])


class MeasuredRays(NamedTuple):
    """pixels (N, 2), directions (N, 3) of their rays, motion of the monitor."""

    pixels: np.ndarray
    directions: np.ndarray
    motion: object

    def travel(self):
        """How far the monitor was found to go, and to turn."""
        return {
            "shift_mm": self.motion.distance,
            "turn_deg": float(np.degrees(self.motion.angle)),
        }

    def against(self, camera):
        """Angles from a calibrated camera's rays to these; and the travel."""
        off = angles_between(camera.rays(self.pixels).directions, self.directions)
        return {
            "measured_deg": float(np.nanmean(off)),
            "measured_sd_deg": float(np.nanstd(off, ddof=1)),
            **self.travel(),
        }


def measured_rays(rig, true, viewer, errors, rng, primary=None):
    """The MeasuredRays of an active grid in two positions before a true camera, as the
    thesis measures them for Table 5.3.

    primary: the Primary whose grids are read between the pixels that it was fitted to;
    None for grids that are placed, and whose poses are found, anew.
    """
    if primary is None:
        places = rig.monitor_poses(rng)
        poses = poses_in_platter(rig, viewer, places, errors, rng)
    else:
        places, poses = primary.places, primary.poses
    pixels, points = decoded(rig, true, places, errors, rng, COMPARED_PX)
    rays = rays_from_known_motion(points, poses.T_camera_grid)
    motion = poses.motion(0, 1, np.nanmean(points[0], axis=0))
    return MeasuredRays(pixels, rays.directions, motion)


def true_points(rig, camera, pixels, T_camera_monitor):
    """Points (N, 2) mm of the monitor's lit face that pixels see, NaN outside it."""
    rays = camera.rays(pixels)
    met = intersect_rays_plane(rays.origins, rays.directions, T_camera_monitor).points
    corner, size = rig.monitor.extent
    with np.errstate(invalid="ignore"):
        lit = np.all((met >= corner) & (met <= corner + size), axis=1)
    return np.where(lit[:, None], met, np.nan)


def poses_in_platter(rig, viewer, T_camera_monitor, errors, rng):
    """PlatterPoses of the monitor in all its places, an image of the platter each."""
    platter = rig.platter(rng)
    board = platter.board.points()
    mounted = errors.mounted(platter, rng, len(T_camera_monitor))
    on_plate = transform(platter.T_camera_board, on_plane(board))
    true = rig.viewer.project(on_plate).pixels
    images = []
    for position, T in enumerate(T_camera_monitor):
        mirror = platter_camera(rig, mounted[position])
        lit = lattice(mirror, PLATTER_STEP_PX)
        points = true_points(rig, mirror, lit, T)
        known = np.isfinite(points).all(axis=1)
        sd_px = errors.platter_sd_mm * px_per_mm(lit[known], points[known])
        points = errors.in_platter(points[known], rng)
        corners = errors.plate_corners(true, rng)
        size = platter.board.columns, platter.board.rows
        sure = np.full(len(board), errors.plate_sd_px)
        grid = np.full(len(points), sd_px)
        images.append(
            FlatMirrorImage(
                BoardView(corners, board, *size, sd=sure),
                BoardView(lit[known], points, len(points), 1, sd=grid),
                0,
                position,
            )
        )
    return grid_poses_in_platter(viewer, images, platter.thickness_mm)


def px_per_mm(pixels, points):
    """Pixels for a mm of the monitor, of all that is seen: from the two areas."""
    spread = [np.linalg.det(np.cov(where.T)) ** 0.25 for where in (pixels, points)]
    return spread[0] / spread[1]


def seen_board(rig, camera, T_camera_board, errors, rng):
    """Pixels (182, 2) of the board's corners in a true camera, NaN where not seen."""
    pixels, there = rig.corners(camera, T_camera_board)
    found = np.full(pixels.shape, np.nan)
    found[there] = errors.corners(pixels[there], rng)
    return found


def deflected(before, camera, images, points, held, method):
    """MirrorUpdate of one deflection.

    before: the calibrated camera; camera: the true one after it, of which the mirror's
    edges are traced; the pixels (N, 2) are of the board before and after.
    """
    return update_mirror(
        before, *images, points, held, method.settings, outline=outline(camera)
    )


def linearly_deflected(before, camera, images, points, held, method):
    """The mirror after one deflection as the linear stage leaves it, arguments as for
    `deflected`."""
    return linear_stage(
        before, *images, points, held, method.settings, outline=outline(camera)
    )


def outline(camera):
    """Pixels (4 TRACED, 2) along the edges of a true camera's mirror."""
    mirror = camera.mirror
    along, half = np.linspace(0, mirror.end, TRACED), mirror.half_width
    across = np.linspace(-half, half, TRACED)
    x = np.concatenate([along, along, 0 * along, 0 * along + mirror.end])
    y = np.concatenate([0 * along - half, 0 * along + half, across, across])
    z = mirror.height(x, y)[0]
    points = transform(camera.T_viewer_mirror, np.column_stack([x, y, z]))
    return camera.viewer.project(points).pixels


def lattice(camera, step_px):
    """Pixels (N, 2) of a lattice over the image that see something in the mirror."""
    pixels = pixel_grid(camera.width // step_px, camera.height // step_px)
    pixels = step_px * pixels + step_px // 2
    return pixels[camera.rays(pixels).valid]


# Runs that end before their first stage.


def by_code(run):
    """A run that returns only the code of the error where its primary stage is
    rejected."""
    return partial(_by_code, run)


def _by_code(run, *given):
    try:
        return run(*given)
    except CalibrationError as refusal:
        return {"refused": refusal.code}
