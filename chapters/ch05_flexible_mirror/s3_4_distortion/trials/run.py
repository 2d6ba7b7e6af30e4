"""A circle on a board, its distortion taken out at four stages (Table 5.6).

The mirror is calibrated as in 5.3.3. At each stage the target is held at 400 mm; its
pose comes from the corners, by the camera that is asked, and the circle's points are
where rays meet the plane in that pose.
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
from chapters.shared.mirror_bundle import bundled
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
from raxel.cameras.core.centrality import closest_point
from raxel.errors import CalibrationError, InputError
from raxel.geometry import transform
from raxel.geometry.planes import intersect_rays_plane, on_plane
from raxel.multiview.fits.circles import fit_circle
from raxel.multiview.fits.conics import algebraic_conic, conic_distances, fit_conic
from raxel.multiview.plane_points import circle_outline, points_on_plane, random_plane

# Of a picture's width, between the pixels whose rays are compared: 168 px of 3072,
# which are about as many rays as the thesis's 168 (Table 5.3).
COMPARED = 168 / 3072
# A random plane's tilt against the rays, at most.
RANDOM_TILT = np.radians(25)


class CircleScope(NamedTuple):
    """What is run: how many deflections, whether the face, and whether the true mirror
    and all stages at once beside the published way."""

    steps: int = len(STAGES_MM) - 1
    face: bool = True
    true: bool = True
    bundle: bool = True


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


def correction_trial(condition, rng, errors, line_px, benches, scope):
    """Every measure of a seed, for each of some benches, drawn alike for all.

    errors: MirrorErrors, line_px: (n,) px, by geometry; scope: CircleScope. Benches
    that are the same are run once.
    """
    geometry, seed = condition["geometry"], int(rng.integers(2**32))
    rig = mirror_rig(geometry)
    found = {
        bench: corrected(
            rig,
            bench,
            errors[geometry]._replace(factor=bench.factor),
            line_px[geometry],
            seed,
            scope,
        )
        for bench in dict.fromkeys(benches.values())
    }
    return {name: found[bench] for name, bench in benches.items()}


def corrected(rig, bench, errors, line_px, seed, scope):
    """Circle and face on one bench; `refused` says where it ended, if early."""
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
    found, pictures, updates, k = [first.camera], [], [], 0
    published = out["published"] = {}
    try:
        published |= by_stage(rig, found, cameras, sights)
        for k, T in enumerate(boards(rig, stages, seed), start=1):
            pair = [seen_board(rig, c, T, errors, rng) for c in cameras[k - 1 : k + 1]]
            stage = deflected(
                found[-1], cameras[k], pair, rig.board.points(), first.clamp, PUBLISHED
            )
            published[f"stage{k}"] = scored(rig, stage.camera, cameras[k], sights[k])
            pictures.append(pair)
            updates.append(stage)
            found.append(stage.camera)
    except InputError as refusal:
        return out | {"refused": f"stage {k}: {refusal}"}
    if scope.bundle:
        try:
            bundle = bundled(rig, first.camera, first.clamp, pictures, updates, errors)
            out["bundle"] = by_stage(rig, bundle.cameras, cameras, sights)
        except InputError as refusal:
            out["bundle_refused"] = str(refusal)
    return out


def by_stage(rig, cameras, true, sights):
    """{stage: what is scored of it}, of as many stages as there are cameras."""
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
    T_random = plane_at_random(rig, camera, T, exact, rng)
    return RingSight(T, corners, exact + off[:, None] * normals, exact, T_random)


def plane_at_random(rig, camera, T_camera_board, pixels, rng):
    """T_camera_plane (4, 4) of a plane about as far away as the board is."""
    rays = camera.rays(pixels)
    centre = on_plane(np.array([ring_on(rig.board).centre]))
    # The rays come from about one point behind the mirror.
    distance = np.linalg.norm(
        transform(T_camera_board, centre)[0] - closest_point(rays)
    )
    return random_plane(rng, rays, distance, RANDOM_TILT)


class CircleOnBoard(NamedTuple):
    """Where a camera has the circle, on the board in the pose that it finds.

    T_camera_board: (4, 4), found; points: (PLACES, 2) mm, NaN where there is no ray;
    used: (PLACES,); fit: the best circle of the points used.
    """

    T_camera_board: np.ndarray
    points: np.ndarray
    used: np.ndarray
    fit: object


def on_board(rig, camera, sight):
    """The CircleOnBoard of what was seen at a stage."""
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
    """The circle as a camera has it, and how far that camera is off the true one."""
    found, points = on_board(rig, camera, sight), rig.board.points()
    used, circle = found.used, found.fit
    placed = points_on_plane(camera, sight.line, sight.T_camera_board).points
    of_pose = fit_circle(placed[used])
    profile = np.full(PLACES, np.nan)
    profile[used] = circle.residuals
    moved, turned = pose_errors(found.T_camera_board, sight.T_camera_board, points)
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
    compared = lattice(true, round(COMPARED * true.width))
    return scores | {
        "ring_deg": float(np.nanmean(ray_angles(camera, true, sight.line))),
        "angle_deg": float(np.nanmean(ray_angles(camera, true, compared))),
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
