"""Distortion correction of a circle on a board at four stages (Table 5.6).

The mirror is calibrated as in 5.3.3. At each stage the target is held at 400 mm. The
tested camera estimates its pose from the corners. The circle's points are where rays
meet the plane in that pose.
"""

from typing import NamedTuple

import numpy as np

from chapters.ch05_flexible_mirror.s3_4_distortion.trials.face import (
    STEPS_MM,
    face_scores,
)
from chapters.ch05_flexible_mirror.s3_4_distortion.trials.target import (
    PLACES,
    RADIUS_MM,
    boards,
    held,
    off_ring,
    ring_on,
)
from chapters.shared.mirror_rigs import STAGES_MM, mirror_rig
from chapters.shared.mirror_runs import (
    PUBLISHED,
    deflected,
    lattice,
    primary,
    seen_board,
)
from chapters.shared.mirror_scores import ray_angles
from raxel.calibration.pose.non_central import pose_from_non_central_rays
from raxel.errors import CalibrationError, InputError
from raxel.multiview.fits.circles import fit_circle
from raxel.multiview.fits.conics import algebraic_conic, conic_distances
from raxel.multiview.plane_points import circle_outline, points_on_plane

# Spacing of the pixels whose rays are compared, as a fraction of the image's width:
# 168 px of 3072, about as many rays as the thesis's 168 (Table 5.3).
COMPARED = 168 / 3072


class CircleScope(NamedTuple):
    """Extent of a run: number of deflections, whether the face and the true mirror."""

    steps: int = len(STAGES_MM) - 1
    face: bool = True
    true: bool = True


class RingSight(NamedTuple):
    """Image of the target at a stage.

    T_camera_board: (4, 4), true; corners: (182, 2) px with errors, NaN where hidden or
    under the ring; line: (PLACES, 2) px of the circle, with errors.
    """

    T_camera_board: np.ndarray
    corners: np.ndarray
    line: np.ndarray


def correction_trial(condition, rng, errors, line_px, benches, scope):
    """Every measure of a run at each of some error levels, with the same draws.

    errors: MirrorErrors, line_px: (n,) px, by geometry; scope: CircleScope. Equal
    levels are run once.
    """
    geometry, seed = condition["geometry"], int(rng.integers(2**32))
    rig = mirror_rig(geometry)
    found = {
        bench: corrected(
            rig, bench, errors[geometry].on(bench), line_px[geometry], seed, scope
        )
        for bench in dict.fromkeys(benches.values())
    }
    return {name: found[bench] for name, bench in benches.items()}


def corrected(rig, bench, errors, line_px, seed, scope):
    """Circle and face at one level; `refused`: code of the error that ended it."""
    rng = np.random.default_rng(seed)
    uneven = {"aberration_um": bench.aberration_um, "seed": seed}
    stages = STAGES_MM[: scope.steps + 1]
    cameras = [rig.camera(deflection, **uneven) for deflection in stages]
    first = primary(rig, cameras[0], PUBLISHED, errors, rng)
    sights = [
        sight(rig, camera, k, errors, line_px, seed) for k, camera in enumerate(cameras)
    ]
    out = {
        "picture": {
            f"stage{k}": of_picture(cameras[k], seen) for k, seen in enumerate(sights)
        }
    }
    if scope.face:
        pushes = [cameras[0], *(rig.camera(d, **uneven) for d in STEPS_MM[1:])]
        out["face"] = face_scores(rig, pushes, first, errors, seed)
    if scope.true:
        out["true"] = by_stage(rig, cameras, cameras, sights)
    found, published = first.camera, {}
    out["published"] = published
    try:
        published |= by_stage(rig, [found], cameras, sights)
        for k, T in enumerate(boards(rig, stages, seed), start=1):
            pair = [seen_board(rig, c, T, errors, rng) for c in cameras[k - 1 : k + 1]]
            found = deflected(
                found, cameras[k], pair, rig.board.points(), first.clamp, PUBLISHED
            ).camera
            published[f"stage{k}"] = scored(rig, found, cameras[k], sights[k])
    except InputError as refusal:
        out["refused"] = refusal.code
    return out


def by_stage(rig, cameras, true, sights):
    """{stage: scores}, for as many stages as there are cameras."""
    return {
        f"stage{k}": scored(rig, camera, true[k], sights[k])
        for k, camera in enumerate(cameras)
    }


def sight(rig, camera, k, errors, line_px, seed):
    """RingSight of the target in a true camera at stage k."""
    rng = np.random.default_rng([seed, k])
    ring = ring_on(rig.board)
    T = held(rig, STAGES_MM[k], seed)
    corners = seen_board(rig, camera, T, errors, rng)
    corners[~off_ring(rig.board)] = np.nan
    exact, normals, _ = circle_outline(camera, T, ring.centre, RADIUS_MM, PLACES)
    off = line_px[rng.integers(len(line_px), size=PLACES)]
    return RingSight(T, corners, exact + off[:, None] * normals)


class CircleOnBoard(NamedTuple):
    """The corrected circle on the board, in the estimated pose.

    T_camera_board: (4, 4), estimated; points: (PLACES, 2) mm, NaN without a ray;
    used: (PLACES,); fit: the best circle of the points used.
    """

    T_camera_board: np.ndarray
    points: np.ndarray
    used: np.ndarray
    fit: object


def on_board(rig, camera, sight):
    """The CircleOnBoard of a RingSight."""
    corners = camera.rays(sight.corners)
    T = pose_from_non_central_rays(corners, rig.board.points()).T_camera_grid
    points = points_on_plane(camera, sight.line, T).points
    used = np.isfinite(points).all(axis=1)
    if np.count_nonzero(used) < PLACES / 4:
        raise CalibrationError(
            f"circle: {np.count_nonzero(used)} of {PLACES} places have rays"
        )
    return CircleOnBoard(T, points, used, fit_circle(points[used]))


def scored(rig, camera, true, sight):
    """Scores of the corrected circle, of the pose and of the rays."""
    found, points = on_board(rig, camera, sight), rig.board.points()
    used, circle = found.used, found.fit
    placed = points_on_plane(camera, sight.line, sight.T_camera_board).points
    of_pose = fit_circle(placed[used])
    profile = np.full(PLACES, np.nan)
    profile[used] = circle.residuals
    middle = [*points.mean(axis=0), 0, 1]
    moved = (found.T_camera_board - sight.T_camera_board) @ middle
    size = np.abs(circle.residuals)
    scores = {
        "radius_mm": circle.radius,
        "residual_mm": float(size.mean()),
        "residual_sd_mm": float(size.std(ddof=1)),
        "true_pose_radius_mm": of_pose.radius,
        "pose_mm": float(np.linalg.norm(moved)),
        "profile": profile,
    }
    if camera is true:
        return scores
    compared = lattice(true, round(COMPARED * true.width))
    angles = ray_angles(camera, true, compared)
    return scores | {"angle_deg": float(np.nanmean(angles))}


def of_picture(true, sight):
    """Mean distance of the circle from a conic in the image.

    The conic of least algebraic error, as in 5.3.4, and distances from it; also in an
    image without the lens's distortion, by the true viewer.
    """
    out = {}
    seen = sight.line[np.isfinite(sight.line).all(axis=1)]
    viewer = true.viewer
    central = viewer.rays(seen).directions
    ideal = central[:, :2] / central[:, 2:] * viewer.K[0, 0]
    for name, pixels in (("conic_px", seen), ("conic_no_lens_px", ideal)):
        off, _ = conic_distances(algebraic_conic(pixels), pixels)
        out[name] = float(np.abs(off).mean())
    return out
