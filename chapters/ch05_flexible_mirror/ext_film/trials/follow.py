"""The film followed: in rendered pictures, and at corner level over many seeds."""

from itertools import pairwise

import cv2
import numpy as np

from chapters.ch05_flexible_mirror.ext_film.trials.scene import (
    COMPARED_PX,
    ERRORS,
    METHOD,
    drawn_film,
)
from chapters.shared.mirror_pictures import board_picture
from chapters.shared.mirror_runs import lattice, outline, seen_board
from chapters.shared.mirror_scores import load_height, ray_angles
from raxel.calibration.mirror.sightings import normalised
from raxel.calibration.mirror.support import clamped_end
from raxel.calibration.mirror.track import FilmTracker, MirrorTracker
from raxel.calibration.mirror.update import update_mirror
from raxel.calibration.pose.non_central import pose_from_non_central_rays
from raxel.errors import CalibrationError
from raxel.geometry import inverse_pose, transform
from raxel.geometry.planes import on_plane

# Places along and across the sheet at which a found shape is kept to be drawn.
ALONG, ACROSS = 33, 9
# Pictures are kept at half the size.
KEPT = 0.5


def film_trial(condition, rng):
    """Every picture rendered, its corners found from those before, its shape tracked.

    In the first picture corners are looked for where they truly are, as if picked by
    hand; in all others where optical flow takes those of the picture before.
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
    return stacked(film, frames) | {"T_camera_board": film.T_camera_board}


def frame(film, k, tracker, picture, corners, followed):
    """What is kept of picture k: its scores, and what is to be drawn."""
    camera, found = film.cameras[k], tracker.camera_now()
    return {
        **scored(film, camera, found),
        "residual_mm": np.nanmean(followed.residuals),
        "used": np.count_nonzero(followed.used),
        "at_edge": at_edge(film, corners[followed.used]),
        "off_px": off_px(film, camera, corners),
        "picture": smaller(picture),
        "corners": np.where(followed.used[:, None], corners, np.nan),
        **shape(camera, found),
    }


def seeds_trial(condition, rng):
    """The same without pictures, by two ways; `refused` says where one ended early."""
    film = drawn_film(**condition, rng=rng)
    corners = [
        seen_board(film.rig, camera, film.T_camera_board, ERRORS, rng)
        for camera in film.cameras
    ]
    return {"tracked": tracked(film, corners), "handed_on": handed_on(film, corners)}


def tracked(film, corners):
    """Each picture fitted for itself, the board's pose from the first one."""
    try:
        tracker, frames = tracker_of(film, corners[0]), []
        for pixels, camera in zip(corners, film.cameras, strict=True):
            tracker.follow(pixels)
            frames.append(scored(film, camera, tracker.camera_now()))
    except CalibrationError as refusal:
        return {"refused": str(refusal)}
    return stacked(film, frames)


def handed_on(film, corners):
    """Each picture calibrated from the one before, as stages are: the board's pose is
    found anew with the last shape."""
    points, found = film.rig.board.points(), film.first
    frames = [scored(film, film.cameras[0], found)]
    try:
        for pair, camera in zip(pairwise(corners), film.cameras[1:], strict=True):
            stage = update_mirror(
                found, *pair, points, film.clamp, METHOD, outline=outline(camera)
            )
            found = stage.camera
            frames.append(scored(film, camera, found))
    except CalibrationError as refusal:
        return {"refused": str(refusal)}
    return stacked(film, frames)


def tracker_of(film, pixels):
    """A MirrorTracker whose board is posed by the first shape, from the first picture's
    corners (N, 2)."""
    points = film.rig.board.points()
    pose = pose_from_non_central_rays(film.first.rays(pixels), points)
    placed = transform(pose.T_camera_grid, on_plane(points))
    return MirrorTracker(film.first, placed, film.clamp, METHOD)


def scored(film, true, found):
    """Height of the load (mm) and mean ray angle (degrees) of a found camera."""
    pixels = lattice(true, COMPARED_PX)
    return {
        "height_mm": load_height(film.rig, found, true),
        "angle_deg": np.nanmean(ray_angles(found, true, pixels)),
    }


def at_edge(film, pixels):
    """How many of pixels (N, 2) lie in the knot interval next to the free edge."""
    grid, viewer = film.first.grid, film.first.viewer
    interval = grid.intervals(normalised(viewer, pixels))[:, 0]
    clamped = clamped_end(grid, film.clamp)[1]
    free = len(grid.breaks[0]) - 2 if clamped == 0 else 0
    return np.count_nonzero(interval == free)


def off_px(film, camera, pixels):
    """Root mean square of the corners' errors along an axis, px."""
    true, seen = film.rig.corners(camera, film.T_camera_board)
    return np.sqrt(np.nanmean((pixels[seen] - true[seen]) ** 2))


def whole_picture(rig, taken):
    """The camera's whole picture of a MirroredBoard; beside the mirror it is dark."""
    whole = np.zeros((rig.viewer.height, rig.viewer.width), np.uint8)
    (height, width), window = taken.picture.shape, taken.window
    whole[window.v : window.v + height, window.u : window.u + width] = taken.picture
    return whole


def smaller(picture):
    """A picture at half its size."""
    return cv2.resize(picture, None, fx=KEPT, fy=KEPT, interpolation=cv2.INTER_AREA)


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


def stacked(film, frames):
    """{name: array over the film}; deflections are told from the first shape on, which
    stands first_mm too high."""
    found = {name: np.stack([frame[name] for frame in frames]) for name in frames[0]}
    start = load_height(film.rig, film.first, film.cameras[0])
    return found | {
        "true_mm": film.deflections,
        "found_mm": found.pop("height_mm") - start,
        "first_mm": start,
    }
