"""Pictures of the target and of the face in the mirror (Figs. 5.14 to 5.19).

They are of 768 x 576 px, rendered through the laboratory; corners and both edges of
the circle are found in them. The mirror is the bench's, and calibrated as published,
with errors drawn as for the tables.
"""

from dataclasses import replace

import numpy as np

from chapters.ch05_flexible_mirror.s3_4_distortion.trials.face import (
    BUST,
    DEFLECTION_MM,
    assumed_plane,
    placed_bust,
    pushed_to_face,
)
from chapters.ch05_flexible_mirror.s3_4_distortion.trials.target import (
    PLACES,
    held,
    middle_of_line,
    off_ring,
    photographed,
    ring_edges,
    ring_outlines,
)
from chapters.shared.mirror_bench import BENCH, BENCHES
from chapters.shared.mirror_rigs import STAGES_MM, mirror_rig
from chapters.shared.mirror_runs import PUBLISHED, deflected, primary, seen_board
from raxel.calibration.pose.non_central import pose_from_non_central_rays
from raxel.cameras import PerspectiveCamera, SplineMirrorCamera
from raxel.features.localise import saddle_point
from raxel.geometry import transform
from raxel.lab.sight import Crop
from raxel.multiview.fits.circles import fit_circle
from raxel.multiview.near_perspective import view_of_plane, view_over_plane, view_pixels
from raxel.multiview.plane_points import plane_picture

# A pixel of the small rig is as wide as four of the camera's.
COARSER = 4
# px to either side: of an edge what is fitted, and of a corner.
ACROSS_PX, CORNER_WINDOW = 3.0, 9
# mm for a px of the corrected pictures.
BOARD_PX_MM, FACE_PX_MM = 0.5, 0.5


def ring_pictures_trial(condition, rng, errors):
    """The target at each stage: picture, circle, and what is left after correction."""
    rig, small, uneven = scene_of(rng)
    cameras = rig.stages(**uneven)
    first = primary(rig, cameras[0], PUBLISHED, errors, rng)
    found, pose_seed = first.camera, int(rng.integers(2**32))
    out = {}
    for k, deflection in enumerate(STAGES_MM):
        if k:
            found = pushed(rig, cameras[k - 1 : k + 1], k, found, first, errors, rng)
        true = small.camera(deflection, **uneven)
        T = held(small, deflection, pose_seed)
        out[f"stage{k}"] = ring_picture(small, true, coarser(found), T, rng)
    return out


def scene_of(rng):
    """(MirrorRig, the same with larger pixels, what makes the bench's mirror uneven)"""
    seed = int(rng.integers(2**32))
    uneven = {"aberration_um": BENCHES[BENCH].aberration_um, "seed": seed}
    return mirror_rig("A"), mirror_rig("A", small=True), uneven


def pushed(rig, cameras, k, found, first, errors, rng):
    """SplineMirrorCamera of stage k, from the one before."""
    T = rig.board_pose(rng, deflections=STAGES_MM[k - 1 : k + 1])
    pair = [seen_board(rig, camera, T, errors, rng) for camera in cameras]
    points = rig.board.points()
    return deflected(found, cameras[1], pair, points, first.clamp, PUBLISHED).camera


def coarser(camera):
    """A SplineMirrorCamera for pictures whose pixels are four times as wide."""
    viewer = camera.viewer
    K = viewer.K / COARSER
    K[:2, 2] = (viewer.K[:2, 2] - (COARSER - 1) / 2) / COARSER
    K[2, 2] = 1
    size = viewer.width // COARSER, viewer.height // COARSER
    small = PerspectiveCamera(K, viewer.radial, *size)
    return SplineMirrorCamera.on_grid(
        small, camera.grid, camera.coefficients.ravel("F"), camera.quantity
    )


def ring_picture(rig, true, found, T_camera_board, rng):
    """What Figs. 5.14 to 5.18 show of one stage."""
    window = whole(true)
    picture = photographed(rig, true, T_camera_board, rng, window)
    outlines = ring_outlines(rig, true, T_camera_board, PLACES)
    edges = ring_edges(rig, outlines, picture, window, ACROSS_PX)
    corners = corners_in(rig, true, T_camera_board, picture)
    board = rig.board.points()
    T = pose_from_non_central_rays(found.rays(corners), board).T_camera_grid
    points = middle_of_line(found, edges, T)
    used = np.isfinite(points).all(axis=1)
    circle = fit_circle(points[used])
    corner = board.min(axis=0) - rig.board.pitch_mm
    size = np.ptp(board, axis=0) + 2 * rig.board.pitch_mm
    laid, _ = plane_picture(found, picture, T, corner, size, BOARD_PX_MM)
    return {
        "picture": picture,
        "line_px": edges.pixels.mean(axis=0)[used],
        "points_mm": points[used],
        "residuals_mm": circle.residuals,
        "centre_mm": circle.centre,
        "radius_mm": circle.radius,
        "corrected": laid,
        "corner_mm": corner,
    }


def whole(camera):
    """The `Crop` that is all of a camera's picture."""
    size = camera.width, camera.height
    return Crop(0, 0, *size, *size)


def corners_in(rig, true, T_camera_board, picture):
    """Pixels (N, 2) of the corners that the ring leaves, NaN where none was found."""
    near, seen = rig.corners(true, T_camera_board)
    rows = np.flatnonzero(seen & off_ring(rig.board))
    found = np.full(near.shape, np.nan)
    got = saddle_point(picture, near[rows], window=CORNER_WINDOW)
    found[rows[got.converged]] = got.corners[got.converged]
    return found


def face_picture_trial(condition, rng, errors):
    """The bust in the mirror and the view over a plane, with its landmarks in both."""
    rig, small, uneven = scene_of(rng)
    before = rig.camera(0.0, **uneven)
    first = primary(rig, before, PUBLISHED, errors, rng)
    found = coarser(pushed_to_face(rig, uneven, before, first, errors, rng))
    true = small.camera(DEFLECTION_MM, **uneven)
    T_bust = placed_bust(small, rng)
    T_plane = assumed_plane(T_bust, rng)
    laboratory = taken_by(small, true)
    picture = laboratory.photograph(BUST.scene(T_bust), np.eye(4), rng)
    size = np.array(BUST.size)
    view = view_of_plane(found, T_plane, FACE_PX_MM, -size / 2, size)
    shown, _ = view_over_plane(found, picture, view, T_plane)
    _, landmarks = BUST.landmarks()
    landmarks = transform(T_bust, landmarks)
    return {
        "picture": picture,
        "corrected": shown,
        "ideal_px": view_pixels(view, landmarks),
    }


def taken_by(rig, camera):
    """The `Laboratory` of a MirrorRig with one of its cameras."""
    return replace(rig.rig, camera=camera).laboratory()
