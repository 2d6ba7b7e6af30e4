"""Images of the target and of the face in the mirror (Figs. 5.14 to 5.19).

They have 768 x 576 px and are rendered by the simulator. Corners and both edges of the
circle are measured in them. The mirror is that of the primary level, calibrated as
published with errors drawn as for the tables.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from chapters.ch05_flexible_mirror.s3_4_distortion.trials.face import (
    BUST,
    STEPS_MM,
    placed_bust,
    pushed_to_face,
)
from chapters.ch05_flexible_mirror.s3_4_distortion.trials.run import (
    RingSight,
    of_picture,
    on_board,
    scored,
)
from chapters.ch05_flexible_mirror.s3_4_distortion.trials.target import (
    PLACES,
    boards,
    held,
    off_ring,
    photographed,
    ring_edges,
    ring_outlines,
)
from chapters.shared.mirror_bench import BENCHES, LEVEL
from chapters.shared.mirror_rigs import STAGES_MM, MirrorRig, mirror_rig
from chapters.shared.mirror_runs import PUBLISHED, deflected, primary, seen_board
from raxel.cameras import FlexibleMirrorCamera, PerspectiveCamera, SplineMirrorCamera
from raxel.errors import InputError
from raxel.features.localise import saddle_point
from raxel.geometry import transform
from raxel.lab.windowed import mirror_window
from raxel.multiview.near_perspective import view_of_plane, view_over_plane, view_pixels
from raxel.multiview.plane_points import plane_picture

# A pixel of the small rig is as wide as four of the camera's.
COARSER = 4
# px about a corner that are fitted.
CORNER_WINDOW = 9


class PictureSizes(NamedTuple):
    """Sizes of the images.

    coarser: width of a px in px of the small rig; across_px: fitted on either side of
    an edge; px_mm: mm per px of corrected images; calibrated: whether the mirror is
    that of the primary level and calibrated, or smooth with the true one correcting.
    """

    coarser: int = 1
    across_px: float = 3.0
    px_mm: float = 0.5
    calibrated: bool = True


class PictureScene(NamedTuple):
    """Rigs and random draws of a run.

    rig, small: the MirrorRig that calibrates and the one that takes images; uneven: of
    `MirrorRig.camera`; seed: integer, of waves and poses; coarser: width of an image's
    px in px of the camera.
    """

    rig: MirrorRig
    small: MirrorRig
    uneven: dict
    seed: int
    coarser: int


def scene_of(rng, sizes):
    """The PictureScene at the primary level."""
    seed = int(rng.integers(2**32))
    height = BENCHES[LEVEL].aberration_um if sizes.calibrated else 0.0
    uneven = {"aberration_um": height, "seed": seed}
    small = with_wider_pixels(mirror_rig("A", small=True), sizes.coarser)
    return PictureScene(mirror_rig("A"), small, uneven, seed, COARSER * sizes.coarser)


def with_wider_pixels(rig, times):
    """A MirrorRig whose camera has fewer pixels, `times` as wide."""
    if times == 1:
        return rig
    camera = rig.rig.camera
    viewer = coarser_viewer(camera.viewer, times)
    camera = FlexibleMirrorCamera(**camera.arguments() | {"viewer": viewer})
    return replace(rig, rig=replace(rig.rig, camera=camera))


def coarser_viewer(viewer, times):
    """A PerspectiveCamera whose pixels are `times` as wide."""
    K = viewer.K / times
    K[:2, 2] = (viewer.K[:2, 2] - (times - 1) / 2) / times
    K[2, 2] = 1
    size = viewer.width // times, viewer.height // times
    return PerspectiveCamera(K, viewer.radial, *size)


def coarser(camera, times):
    """A SplineMirrorCamera for images whose pixels are `times` as wide."""
    return SplineMirrorCamera.on_grid(
        coarser_viewer(camera.viewer, times),
        camera.grid,
        camera.coefficients.ravel("F"),
        camera.quantity,
    )


def ring_pictures_trial(condition, rng, errors, sizes):
    """Render, measure and correct the target at each stage, at the primary level.

    Corrected by the true mirror and as published; `refused`: code of the error that
    ended the run.
    """
    scene = scene_of(rng, sizes)
    cameras = [scene.small.camera(d, **scene.uneven) for d in STAGES_MM]
    seen = [
        rendered_sight(scene, camera, deflection, sizes, rng)
        for camera, deflection in zip(cameras, STAGES_MM, strict=True)
    ]
    out = {
        "picture": {
            f"stage{k}": of_picture(cameras[k], sight) | {"grey": picture}
            for k, (sight, picture) in enumerate(seen)
        },
        "true": {
            f"stage{k}": pictured(scene.rig, camera, camera, seen[k][0])
            for k, camera in enumerate(cameras)
        },
    }
    published, found = [], []
    try:
        for camera in as_published(scene, errors, rng, sizes):
            k = len(published)
            published.append(pictured(scene.rig, camera, cameras[k], seen[k][0]))
            found.append(camera)
    except InputError as refusal:
        out["refused"] = refusal.code
    out["published"] = {f"stage{k}": of_stage for k, of_stage in enumerate(published)}
    # The last stage's image, by the true mirror where no calibration reached it.
    corrects = found[-1] if len(found) == len(cameras) else cameras[-1]
    return {LEVEL: out | {"corrected": laid_out(scene, corrects, *seen[-1], sizes)}}


def rendered_sight(scene, camera, deflection, sizes, rng):
    """(RingSight, image (h, w)) of the target at a stage, measured in the image.

    Its line is the middle of both edges in the image, on the board within 0.03 mm of
    the circle.
    """
    rig, T = scene.small, held(scene.rig, deflection, scene.seed)
    window = mirror_window(camera)
    picture = np.zeros((camera.height, camera.width), np.uint8)
    picture[window.place] = photographed(rig, camera, T, rng, window)
    outlines = ring_outlines(rig, camera, T, PLACES)
    edges = ring_edges(rig, outlines, picture[window.place], window, sizes.across_px)
    # Two unused numbers keep the random draws of later stages.
    rng.random(2)
    corners = corners_in(rig, camera, T, picture)
    return RingSight(T, corners, edges.pixels.mean(axis=0)), picture


def corners_in(rig, true, T_camera_board, picture):
    """Pixels (N, 2) of the corners clear of the ring, NaN where none was found."""
    near, seen = rig.corners(true, T_camera_board)
    rows = np.flatnonzero(seen & off_ring(rig.board))
    found = np.full(near.shape, np.nan)
    got = saddle_point(picture, near[rows], window=CORNER_WINDOW)
    found[rows[got.converged]] = got.corners[got.converged]
    return found


def as_published(scene, errors, rng, sizes):
    """Yield the calibrated cameras of stages 0, 1, ..., for the small images."""
    if not sizes.calibrated:
        return
    rig = scene.rig
    cameras = rig.stages(**scene.uneven)
    first = primary(rig, cameras[0], PUBLISHED, errors, rng)
    found, points = first.camera, rig.board.points()
    yield coarser(found, scene.coarser)
    for k, T in enumerate(boards(rig, STAGES_MM, scene.seed), start=1):
        pair = [seen_board(rig, c, T, errors, rng) for c in cameras[k - 1 : k + 1]]
        found = deflected(
            found, cameras[k], pair, points, first.clamp, PUBLISHED
        ).camera
        yield coarser(found, scene.coarser)


def pictured(rig, camera, true, sight):
    """Scores of the circle in an image, and data of Figs. 5.14 to 5.17."""
    found = on_board(rig, camera, sight)
    return scored(rig, camera, true, sight) | {
        "line_px": sight.line[found.used],
        "points_mm": found.points[found.used],
        "residuals_mm": found.fit.residuals,
        "centre_mm": found.fit.centre,
    }


def laid_out(scene, camera, sight, picture, sizes):
    """An image rectified to the board, in the pose that the camera estimates."""
    board, pitch = scene.rig.board.points(), scene.rig.board.pitch_mm
    T = on_board(scene.rig, camera, sight).T_camera_board
    corner, size = board.min(axis=0) - pitch, np.ptp(board, axis=0) + 2 * pitch
    return plane_picture(camera, picture, T, corner, size, sizes.px_mm)[0]


def face_picture_trial(condition, rng, errors, sizes):
    """The bust in the mirror and the view over a plane, with its landmarks in both.

    Where the mirror is not calibrated the true one corrects.
    """
    scene = scene_of(rng, sizes)
    camera = scene.small.camera(STEPS_MM[-1], **scene.uneven)
    T_bust, T_plane = placed_bust(scene.rig, scene.seed)
    laboratory = replace(scene.small.rig, camera=camera).laboratory()
    picture = laboratory.photograph(BUST.scene(T_bust), np.eye(4), rng)
    found = camera
    if sizes.calibrated:
        try:
            found = coarser(pushed_as_published(scene, errors, rng), scene.coarser)
        except InputError:
            found = camera
    size = np.array(BUST.size)
    view = view_of_plane(found, T_plane, sizes.px_mm, -size / 2, size)
    shown, _ = view_over_plane(found, picture, view, T_plane)
    _, landmarks = BUST.landmarks()
    landmarks = transform(T_bust, landmarks)
    return {
        "picture": picture,
        "corrected": shown,
        "ideal_px": view_pixels(view, landmarks),
        "calibrated": found is not camera,
    }


def pushed_as_published(scene, errors, rng):
    """The calibrated SplineMirrorCamera after the push."""
    rig = scene.rig
    cameras = [rig.camera(deflection, **scene.uneven) for deflection in STEPS_MM]
    first = primary(rig, cameras[0], PUBLISHED, errors, rng)
    return pushed_to_face(rig, cameras, first, errors, scene.seed, rng)
