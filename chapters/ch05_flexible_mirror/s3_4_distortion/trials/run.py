"""A circle on a board, its distortion taken out at four stages (Table 5.6).

The mirror is calibrated as in 5.3.3. At each stage the target is held at 400 mm; its
pose comes from the corners, by the camera that is asked, and the circle's points are
where rays meet the plane in that pose.
"""

from typing import NamedTuple

import numpy as np

from chapters.ch05_flexible_mirror.s3_4_distortion.trials.face import face_scores
from chapters.ch05_flexible_mirror.s3_4_distortion.trials.target import (
    PLACES,
    RADIUS_MM,
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
from raxel.calibration import BoardView, StageView, bundle_stages
from raxel.calibration.pose.non_central import pose_from_non_central_rays
from raxel.cameras.core.centrality import closest_point
from raxel.errors import CalibrationError, InputError
from raxel.geometry import transform
from raxel.geometry.planes import intersect_rays_plane, on_plane
from raxel.multiview.fits.circles import fit_circle
from raxel.multiview.fits.conics import algebraic_conic, conic_distances, fit_conic
from raxel.multiview.plane_points import circle_outline, random_plane

# px between the pixels whose rays are compared: about the thesis's 168 (Table 5.3).
COMPARED_PX = 168
# The prior on bending of the bundle, mm: chosen by `ext_mirror_prior_runs`.
PRIOR_MM = 0.1
# A random plane's tilt against the rays, at most.
RANDOM_TILT = np.radians(25)
STEPS = len(STAGES_MM) - 1


class RingSight(NamedTuple):
    """What is seen of the target at a stage.

    T_camera_board: (4, 4), true; corners: (182, 2) px with errors, NaN where hidden or
    under the ring; line, exact: (PLACES, 2) px of the circle, with errors and without;
    T_random: (4, 4), a plane drawn before the camera.
    """

    T_camera_board: np.ndarray
    corners: np.ndarray
    line: np.ndarray
    exact: np.ndarray
    T_random: np.ndarray


def correction_trial(condition, rng, errors, line_px, benches):
    """Every measure of a seed, for each of some benches, drawn alike for all.

    errors: MirrorErrors, line_px: (n,) px, by geometry.
    """
    geometry, seed = condition["geometry"], int(rng.integers(2**32))
    rig = mirror_rig(geometry)
    return {
        name: corrected(
            rig,
            bench,
            errors[geometry]._replace(factor=bench.factor),
            line_px[geometry],
            seed,
        )
        for name, bench in benches.items()
    }


def corrected(rig, bench, errors, line_px, seed):
    """Circle and face on one bench; `refused` says where it ended, if early."""
    rng = np.random.default_rng(seed)
    uneven = {"aberration_um": bench.aberration_um, "seed": seed}
    cameras = rig.stages(**uneven)
    first = primary(rig, cameras[0], PUBLISHED, errors, rng)
    sights = [
        sight(rig, camera, k, errors, line_px, [seed, k])
        for k, camera in enumerate(cameras)
    ]
    out = {
        "face": face_scores(rig, uneven, cameras[0], first, errors, [seed, 9]),
        "true": {
            f"stage{k}": scored(rig, camera, camera, sights[k])
            for k, camera in enumerate(cameras)
        },
        "picture": {
            f"stage{k}": of_picture(cameras[k], seen) for k, seen in enumerate(sights)
        },
    }
    published, pictures, updates = {}, [], []
    found, k = [first.camera], 0
    try:
        published["stage0"] = scored(rig, found[0], cameras[0], sights[0])
        for k in range(1, STEPS + 1):
            T = rig.board_pose(rng, deflections=STAGES_MM[k - 1 : k + 1])
            pair = [seen_board(rig, c, T, errors, rng) for c in cameras[k - 1 : k + 1]]
            stage = deflected(
                found[-1], cameras[k], pair, rig.board.points(), first.clamp, PUBLISHED
            )
            published[f"stage{k}"] = scored(rig, stage.camera, cameras[k], sights[k])
            pictures.append(pair)
            updates.append(stage)
            found.append(stage.camera)
    except InputError as refusal:
        return out | {"published": published, "refused": f"stage {k}: {refusal}"}
    out |= {"published": published}
    try:
        bundle = bundled(rig, found, first.clamp, pictures, updates, errors)
        return out | {
            "bundle": {
                f"stage{k}": scored(rig, camera, cameras[k], sights[k])
                for k, camera in enumerate(bundle.cameras)
            }
        }
    except InputError as refusal:
        return out | {"bundle_refused": str(refusal)}


def sight(rig, camera, k, errors, line_px, seed):
    """RingSight of the target in a true camera at stage k."""
    rng = np.random.default_rng(seed)
    ring = ring_on(rig.board)
    # The same draws at all stages.
    T = held(rig, STAGES_MM[k], seed[0])
    corners = seen_board(rig, camera, T, errors, rng)
    corners[~off_ring(rig.board)] = np.nan
    exact, normals, _ = circle_outline(camera, T, ring.centre, RADIUS_MM, PLACES)
    off = line_px[rng.integers(len(line_px), size=PLACES)]
    rays = camera.rays(exact)
    middle = transform(T, on_plane(np.array([ring.centre])))[0]
    # As far as the board is; the rays come from about one point behind the mirror.
    distance = np.linalg.norm(middle - closest_point(rays))
    T_random = random_plane(rng, rays, distance, RANDOM_TILT)
    return RingSight(T, corners, exact + off[:, None] * normals, exact, T_random)


def scored(rig, camera, true, sight):
    """The circle as a camera has it, and how far that camera is off the true one."""
    points, line = rig.board.points(), camera.rays(sight.line)
    found = pose_from_non_central_rays(camera.rays(sight.corners), points)
    own, placed = (
        intersect_rays_plane(line.origins, line.directions, T).points
        for T in (found.T_camera_grid, sight.T_camera_board)
    )
    used = np.isfinite(own).all(axis=1)
    if np.count_nonzero(used) < PLACES / 4:
        raise CalibrationError(
            f"circle: {np.count_nonzero(used)} of {PLACES} places have rays"
        )
    circle, of_pose = fit_circle(own[used]), fit_circle(placed[used])
    profile = np.full(PLACES, np.nan)
    profile[used] = circle.residuals
    moved, turned = pose_errors(found.T_camera_grid, sight.T_camera_board, points)
    size = np.abs(circle.residuals)
    scores = {
        "radius_mm": circle.radius,
        "residual_mm": float(size.mean()),
        "residual_sd_mm": float(size.std(ddof=1)),
        "true_pose_radius_mm": of_pose.radius,
        "centre_mm": float(np.linalg.norm(circle.centre - ring_on(rig.board).centre)),
        "pose_mm": moved,
        "pose_deg": turned,
        "single_mm": single(camera, sight.line[used], sight.T_random),
        "profile": profile,
    }
    if camera is true:
        return scores | {"parallax_mm": single(true, sight.exact, sight.T_random)}
    return scores | {
        "ring_deg": float(np.nanmean(ray_angles(camera, true, sight.line))),
        "angle_deg": float(
            np.nanmean(ray_angles(camera, true, lattice(true, COMPARED_PX)))
        ),
    }


def pose_errors(T, true, points):
    """How far the middle of a target is off, mm, and how far its normal, degrees."""
    middle = [*points.mean(axis=0), 0, 1]
    cosine = np.clip(T[:3, 2] @ true[:3, 2], -1, 1)
    shift = np.linalg.norm((T - true) @ middle)
    return float(shift), float(np.degrees(np.arccos(cosine)))


def single(camera, pixels, T_camera_plane):
    """Mean distance, mm, from the best conic on a plane that nobody measured."""
    pixels = pixels[np.isfinite(pixels).all(axis=1)]
    rays = camera.rays(pixels)
    met = intersect_rays_plane(rays.origins, rays.directions, T_camera_plane).points
    met = met[np.isfinite(met).all(axis=1)]
    return float(np.abs(fit_conic(met).residuals).mean())


def of_picture(true, sight):
    """How far the circle is from a conic in the picture itself.

    The conic of least algebraic error, as 5.3.4 draws it, and distances from it; also
    in a picture from which the lens's distortion was taken out, by the true viewer.
    """
    out = {}
    seen = sight.line[np.isfinite(sight.line).all(axis=1)]
    viewer = true.viewer
    central = viewer.rays(seen).directions
    ideal = central[:, :2] / central[:, 2:] * viewer.K[0, 0]
    for name, pixels in (("conic_px", seen), ("conic_no_lens_px", ideal)):
        off, _ = conic_distances(algebraic_conic(pixels), pixels)
        out[name] = float(np.abs(off).mean())
    return out | {"shown": float(len(seen) / PLACES)}


def bundled(rig, cameras, clamp, pictures, updates, errors):
    """StageBundle of all stages and boards together, with the prior on bending."""
    points, board = rig.board.points(), rig.board
    sd = np.full(len(points), np.sqrt(np.mean(errors.corner**2)))
    shown = [
        StageView(
            k + after,
            k,
            BoardView(
                np.where(update.wrong[:, None], np.nan, pixels),
                points,
                board.columns,
                board.rows,
                sd=sd,
            ),
        )
        for k, (pair, update) in enumerate(zip(pictures, updates, strict=True))
        for after, pixels in enumerate(pair)
    ]
    poses = np.stack([update.pose.T_camera_grid for update in updates])
    return bundle_stages(cameras, shown, poses, clamp=clamp, prior_sd=PRIOR_MM)
