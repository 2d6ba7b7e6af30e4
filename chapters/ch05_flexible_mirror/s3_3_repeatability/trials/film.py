"""A film of a mirror that bends and returns, and a calibration that follows it.

The rig is A with a quarter of the pixels in each direction, so that all images can be
rendered. Camera and first shape are calibrated as in 5.3.3, with Gaussian errors. The
board is fixed.
"""

from typing import NamedTuple

import cv2
import numpy as np

from chapters.shared.gaussian_errors import CORNER_PX, DECODED_MM, GaussianErrors
from chapters.shared.mirror_pictures import board_picture
from chapters.shared.mirror_rigs import STAGES_MM, mirror_rig
from chapters.shared.mirror_runs import (
    CLAMP_PICKS,
    CLAMP_SD_PX,
    calibrated_viewer,
    decoded,
    lattice,
    outline,
    poses_in_platter,
    seen_board,
)
from chapters.shared.mirror_scores import load_height, ray_angles
from chapters.shared.run_times import timed
from raxel.calibration.mirror.clamp_line import clamp_line, fixed_line
from raxel.calibration.mirror.primary import primary_from_points
from raxel.calibration.mirror.sightings import normalised
from raxel.calibration.mirror.track import FilmTracker, MirrorTracker
from raxel.calibration.mirror.update import MirrorSettings
from raxel.calibration.pose.non_central import pose_from_non_central_rays
from raxel.geometry import inverse_pose, transform
from raxel.geometry.planes import on_plane

COARSER = 4  # a pixel of the small rig is as wide as four of the camera's
# px between the pixels of the first shape, and between those whose rays are compared.
DECODED_STEP_PX, COMPARED_PX = 16, 24
ERRORS = GaussianErrors(CORNER_PX / COARSER, DECODED_MM)
METHOD = MirrorSettings(noise_px=CORNER_PX / COARSER, prior_sd=0.1)
# Places along and across the sheet at which a found shape is kept to be drawn.
ALONG, ACROSS = 33, 9
KEPT = 0.5  # images are stored at half the size
TIMED_MM = 0.5


class FilmedMirror(NamedTuple):
    """rig: MirrorRig; deflections (n,) mm; cameras: the true ones, an image each;
    T_camera_board (4, 4); first: SplineMirrorCamera of the first shape; clamp:
    FixedLine."""

    rig: object
    deflections: np.ndarray
    cameras: list
    T_camera_board: np.ndarray
    first: object
    clamp: object


def film_trial(condition, rng):
    """Render each image, detect its corners from those before, and track the shape.

    In the first image corners are searched for at their true positions, as if picked by
    hand; in all others where optical flow predicts them.
    """
    film = drawn_film(**condition, rng=rng)
    rig, board = film.rig, film.rig.board
    taken = [
        board_picture(rig, camera, film.T_camera_board, rng) for camera in film.cameras
    ]
    picked, seen = rig.corners(film.cameras[0], film.T_camera_board)
    first = taken[0].corners(np.where(seen[:, None], picked, np.nan))
    pictures = [whole_picture(rig, one) for one in taken]
    tracker = tracker_of(film, first)
    following = FilmTracker(tracker, pictures[0], first, board.columns, board.rows)
    frames = [frame(film, 0, tracker, pictures[0], first, tracker.follow(first))]
    for k in range(1, len(pictures)):
        corners, shape = following.follow(pictures[k])
        frames.append(frame(film, k, tracker, pictures[k], corners.corners, shape))
    found = {name: np.stack([frame[name] for frame in frames]) for name in frames[0]}
    start = load_height(rig, film.first, film.cameras[0])
    return found | {
        "true_mm": film.deflections,
        "found_mm": found.pop("height_mm") - start,
        "T_camera_board": film.T_camera_board,
    }


def drawn_film(steps, peak_mm, rng):
    """The FilmedMirror of a load that goes out to `peak_mm` in so many steps, and back.

    It starts, reverses and stops smoothly, like a crank.
    """
    rig = mirror_rig("A", small=True)
    deflections = peak_mm * np.sin(np.pi / 2 * np.linspace(0, 2, 2 * steps + 1)) ** 2
    cameras = [rig.camera(float(deflection)) for deflection in deflections]
    T = rig.board_pose(rng, deflections=STAGES_MM)
    return FilmedMirror(
        rig, deflections, cameras, T, *first_shape(rig, cameras[0], rng)
    )


def first_shape(rig, camera, rng):
    """(SplineMirrorCamera, FixedLine) of the mirror before the film.

    Its knots span the mirror's outline: flat, it fills more of the image than bent.
    """
    viewer = calibrated_viewer(rig, ERRORS, rng)
    monitor = rig.monitor_poses(rng)
    poses = poses_in_platter(rig, viewer, monitor, ERRORS, rng)
    picks = rig.clamp_pixels(camera, CLAMP_PICKS, rng, CLAMP_SD_PX / COARSER)
    line = clamp_line(viewer, picks)
    found = primary_from_points(
        viewer,
        *decoded(rig, camera, monitor, ERRORS, rng, DECODED_STEP_PX),
        poses,
        shape=METHOD.shape,
        angle=line.angle,
        quantity="inverse depth",
        span=np.vstack([line.points(CLAMP_PICKS), normalised(viewer, outline(camera))]),
    )
    return found.camera, fixed_line(found.camera, line)


def tracker_of(film, pixels):
    """A MirrorTracker whose board's pose comes from the first shape and the first
    image's corners (N, 2)."""
    points = film.rig.board.points()
    pose = pose_from_non_central_rays(film.first.rays(pixels), points)
    placed = transform(pose.T_camera_grid, on_plane(points))
    return MirrorTracker(film.first, placed, film.clamp, METHOD)


def frame(film, k, tracker, picture, corners, followed):
    """Stored values of image k: its errors, and what is drawn."""
    camera, found = film.cameras[k], tracker.camera_now()
    off = ray_angles(found, camera, lattice(camera, COMPARED_PX))
    return {
        "height_mm": load_height(film.rig, found, camera),
        "angle_deg": np.nanmean(off),
        "used": np.count_nonzero(followed.used),
        "picture": cv2.resize(
            picture, None, fx=KEPT, fy=KEPT, interpolation=cv2.INTER_AREA
        ),
        "corners": np.where(followed.used[:, None], corners, np.nan),
        **shape(camera, found),
    }


def whole_picture(rig, taken):
    """The camera's whole image of a MirroredBoard; outside the mirror it is dark."""
    whole = np.zeros((rig.viewer.height, rig.viewer.width), np.uint8)
    (height, width), window = taken.picture.shape, taken.window
    whole[window.v : window.v + height, window.u : window.u + width] = taken.picture
    return whole


def shape(true, found):
    """Points (ACROSS, ALONG, 3) of the found mirror, viewer's frame, on the viewing
    rays of places all over the true one, and the directions of their scene rays; and
    the profile (ALONG, 2), mm along the flat sheet and above it."""
    x, y = np.meshgrid(
        true.mirror.end * np.linspace(0.005, 0.995, ALONG),
        true.mirror.half_width * np.linspace(-0.99, 0.99, ACROSS),
    )
    z = true.mirror.height(x.ravel(), y.ravel())[0]
    sheet = np.column_stack([x.ravel(), y.ravel(), z])
    places = transform(true.T_viewer_mirror, sheet)
    rays = found.rays(true.viewer.project(places).pixels)
    flat = transform(inverse_pose(true.T_viewer_mirror), rays.origins)
    return {
        "mirror": rays.origins.reshape(ACROSS, ALONG, 3),
        "directions": rays.directions.reshape(ACROSS, ALONG, 3),
        "profile": flat.reshape(ACROSS, ALONG, 3)[ACROSS // 2][:, [0, 2]],
    }


def update_seconds():
    """Seconds of one update of the shape from the corners of an image, timed now."""
    rng = np.random.default_rng(0)
    film = drawn_film(1, TIMED_MM, rng)
    first, second = (
        seen_board(film.rig, camera, film.T_camera_board, ERRORS, rng)
        for camera in film.cameras[:2]
    )
    tracker = tracker_of(film, first)
    return timed(lambda: tracker.follow(second))
