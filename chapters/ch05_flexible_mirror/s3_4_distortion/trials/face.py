"""A face in low relief, corrected as a plane (Fig. 5.19).

A relief bust represents the face. The mirror is pushed by 12 mm, in three steps that
are calibrated as in 5.3.3. After a single step of 12 mm no corner at the clamp is
visible both before and after.
"""

from functools import lru_cache

import numpy as np

from chapters.ch05_flexible_mirror.s3_4_distortion.trials.target import boards
from chapters.shared.mirror_rigs import BACK_PROJECTION_MM
from chapters.shared.mirror_runs import PUBLISHED, deflected, seen_board
from raxel.errors import InputError
from raxel.geometry import pose, rotation_from_vector, transform
from raxel.geometry.homography import (
    apply_homography,
    homography_dlt,
    refine_homography,
)
from raxel.lab.bust import Bust
from raxel.multiview.near_perspective import (
    facing_plane,
    shown_in_view,
    view_of_plane,
    view_pixels,
)

STEPS_MM = (0.0, 4.0, 8.0, 12.0)
DEFLECTION_MM = STEPS_MM[-1]
# Relief of 5 % of the depth.
BUST = Bust(width=160.0, relief=0.05 * BACK_PROJECTION_MM)
# Errors of the assumed plane along each axis (standard deviations).
PLANE_MM, PLANE_TURN = 5.0, np.radians(2)
# Random streams of a seed: errors of the push, and poses of bust and plane.
FACE_OF_SEED, BUST_OF_SEED = 9, 10
PER_PX = 0.25  # mm on the plane per px of the corrected image
MIN_N_LANDMARKS = 8  # visible landmarks


def face_scores(rig, cameras, first, errors, seed):
    """Distortion of a face that a plane leaves, by the calibrated and the true camera.

    `refused`: code of the error that ended the run.

    cameras: the true ones of the steps, that of stage 0 first; first: the `Primary`.
    """
    rng, true = np.random.default_rng([seed, FACE_OF_SEED]), cameras[-1]
    T_bust, T_plane = placed_bust(rig, seed)
    try:
        found = pushed_to_face(rig, cameras, first, errors, seed, rng)
        return {
            "calibrated": left_by_plane(found, true, T_bust, T_plane),
            "true": left_by_plane(true, true, T_bust, T_plane),
        }
    except InputError as refusal:
        return {"refused": refusal.code}


def pushed_to_face(rig, cameras, first, errors, seed, rng):
    """SplineMirrorCamera after the push, found step by step from that of stage 0."""
    found, points = first.camera, rig.board.points()
    for k, T in enumerate(boards(rig, STEPS_MM, seed)):
        pair = [seen_board(rig, c, T, errors, rng) for c in cameras[k : k + 2]]
        found = deflected(
            found, cameras[k + 1], pair, points, first.clamp, PUBLISHED
        ).camera
    return found


@lru_cache(maxsize=16)
def placed_bust(rig, seed):
    """(T_camera_bust, T_camera_plane), each (4, 4) and read-only.

    The bust is held like a board, with its middle where a board's is. The plane is half
    way into the relief, with errors of placing by hand.
    """
    rng = np.random.default_rng([seed, BUST_OF_SEED])
    T = rig.board_pose(rng, BACK_PROJECTION_MM, (DEFLECTION_MM,))
    T_bust = T @ pose(np.eye(3), [*np.ptp(rig.board.points(), axis=0) / 2, 0])
    viewpoint = transform(T_bust, np.array([[0.0, 0.0, -1.0]]))[0]
    facing = facing_plane(T_bust, viewpoint, BUST.relief / 2)
    turn = rotation_from_vector(rng.normal(0, PLANE_TURN, 3))
    T_plane = facing @ pose(turn, rng.normal(0, PLANE_MM, 3))
    for placed in (T_bust, T_plane):
        placed.setflags(write=False)
    return T_bust, T_plane


def left_by_plane(camera, true, T_bust, T_plane):
    """Distortion of landmarks in the image and in the view over the plane.

    camera: the one that corrects; true: the one that took the image. Either image is
    mapped to the view's own pinhole image of the face by the least-squares homography.
    raw_px and corrected_px: RMS of the remainder, px of that image.
    """
    _, points = BUST.landmarks()
    points = transform(T_bust, points)
    pixels, seen = true.project(points)
    seen &= true.in_image(pixels)
    size = np.array(BUST.size)
    view = view_of_plane(camera, T_plane, PER_PX, -size / 2, size)
    shown = shown_in_view(
        camera, view, np.where(seen[:, None], pixels, np.nan), T_plane
    )
    seen &= np.isfinite(shown).all(axis=1)
    if np.count_nonzero(seen) < MIN_N_LANDMARKS:
        raise InputError(f"face: {np.count_nonzero(seen)} landmarks are seen")
    ideal = view_pixels(view, points[seen])
    return {
        "raw_px": off_homography(pixels[seen], ideal),
        "corrected_px": off_homography(shown[seen], ideal),
    }


def off_homography(picture, ideal):
    """RMS, px of `ideal`, that the best homography from an image leaves."""
    H = refine_homography(homography_dlt(picture, ideal), picture, ideal)
    off = apply_homography(H, picture) - ideal
    return float(np.sqrt(np.mean(np.sum(off**2, axis=1))))
