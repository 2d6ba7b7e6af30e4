"""Trials of this page, their conditions and constants."""

from typing import NamedTuple

import numpy as np

from chapters.shared.mirror import (
    BACK_PROJECTION_MM,
    BENCHES,
    CORNER_PX,
    FIRST,
    PUBLISHED,
    SECOND,
    STAGES_MM,
    GaussianErrors,
    MirrorErrors,
    MirrorMethod,
    back_projection,
    deflected,
    lattice,
    lengths,
    measured,
    measured_rays,
    mirror_rig,
    poses_in_platter,
    primary,
    ray_angles,
    scene_image,
    seen_board,
)
from raxel.calibration import BoardView, StageView, bundle_stages
from raxel.errors import CalibrationError
from raxel.geometry import pose, transform
from raxel.lab import room

# What decoding errors and an uneven mirror do to what levels are solved from.
#
# Rig A, the method as published. From this the two solved error levels have their
# factors and amplitudes, with the two printed numbers that each may see (settings.yaml,
# mirror_bench). Nothing is judged here.


SEEDS = {"quick": 1, "full": 36}
# Of each level: what is swept, with the other number as it is.
FACTORS = {FIRST: (1.0, 4.0, 8.0, 12.0, 16.0), SECOND: (1.0, 2.0, 3.0, 4.0, 5.0)}
AMPLITUDES_UM = {
    FIRST: (0.0, 10.0, 20.0, 30.0, 45.0, 60.0),
    SECOND: (0.0, 5.0, 10.0, 15.0, 20.0),
}


class WithoutPlatter(MirrorErrors):
    """Errors as the first level was solved with: none of the platter is drawn."""

    def mounted(self, platter, rng, positions):
        """The `Platter` at each of the monitor's positions, as given by its board."""
        return [platter] * positions


def first_trial(condition, rng, errors):
    """miss_mm: mean distance of mirror points from their rays, for each of FACTORS on a
    smooth mirror, and with the factor chosen; residual_mm: mean residual of stage 1 for
    each of AMPLITUDES_UM with the factor chosen, and with both numbers chosen; NaN
    where a stage is rejected."""
    seed, level = int(rng.integers(2**32)), BENCHES[FIRST]
    errors = WithoutPlatter(*errors)

    def miss(factor):
        found = _primary(level._replace(factor=factor, aberration_um=0), errors, seed)
        return float(np.nanmean(found.first.calibration.mirror.misses))

    def residual(amplitude_um):
        found = _primary(level._replace(aberration_um=amplitude_um), errors, seed)
        rig, drawn, these = found.rig, found.drawn, found.errors
        bent = rig.camera(STAGES_MM[1], amplitude_um, seed)
        T = rig.board_pose(drawn, deflections=STAGES_MM[:2])
        images = [seen_board(rig, c, T, these, drawn) for c in (found.flat, bent)]
        points, first = rig.board.points(), found.first
        try:
            stage = deflected(
                first.camera, bent, images, points, first.clamp, PUBLISHED
            )
        except CalibrationError:
            return np.nan
        return float(np.nanmean(stage.residuals))

    return {
        "miss_mm": np.array([miss(factor) for factor in FACTORS[FIRST]]),
        "chosen_miss_mm": miss(level.factor),
        "residual_mm": np.array([residual(um) for um in AMPLITUDES_UM[FIRST]]),
        "chosen_residual_mm": residual(level.aberration_um),
    }


def second_trial(condition, rng, errors):
    """angle_deg: mean angle to the rays that the primary's own grids give, for each of
    FACTORS; back_mm: mean back-projection error at stage 0, for each of AMPLITUDES_UM;
    the other number as chosen, and both with both chosen."""
    seed, level = int(rng.integers(2**32)), BENCHES[SECOND]

    def by(factor):
        return stage_0(level._replace(factor=factor), errors, seed)[0]

    def of(amplitude_um):
        return stage_0(level._replace(aberration_um=amplitude_um), errors, seed)[1]

    angle, back = stage_0(level, errors, seed)
    return {
        "angle_deg": np.array([by(factor) for factor in FACTORS[SECOND]]),
        "chosen_angle_deg": angle,
        "back_mm": np.array([of(um) for um in AMPLITUDES_UM[SECOND]]),
        "chosen_back_mm": back,
    }


def stage_0(level, errors, seed):
    """Mean angle to the rays of the primary's own grids, degrees, and mean
    back-projection error in the pose that is found, mm, at an error level."""
    found = _primary(level, errors, seed)
    rig, first, drawn = found.rig, found.first, found.drawn
    camera, given = first.camera, (found.errors, drawn)
    own = measured_rays(rig, found.flat, camera.viewer, *given, first)
    T = rig.board_pose(drawn, BACK_PROJECTION_MM, STAGES_MM[:1])
    pixels = seen_board(rig, found.flat, T, *given)
    back = lengths(back_projection(camera, pixels, rig.board.points())).mean()
    return own.against(camera)["measured_deg"], float(back)


def solved(values, levels, target):
    """The level at which the median over runs of values (runs, levels) is the target,
    interpolated linearly between levels; None where no level reaches it."""
    medians = np.nanmedian(values, axis=0)
    if not medians[0] <= target <= medians[-1]:
        return None
    return float(np.interp(target, medians, levels))


class _Started(NamedTuple):
    """A MirrorRig, its true camera at stage 0, the Primary found of it, and the errors
    and the generator that go on from there."""

    rig: object
    flat: object
    first: object
    errors: object
    drawn: object


def _primary(level, errors, seed):
    rig, drawn, these = mirror_rig("A"), np.random.default_rng(seed), errors.on(level)
    flat = rig.camera(STAGES_MM[0], level.aberration_um, seed)
    first = primary(rig, flat, PUBLISHED, these, drawn)
    return _Started(rig, flat, first, these, drawn)


# Errors of corners and decoded points in rendered images of rigs A and B.


RENDERED = {"quick": 1, "full": 2}
SMALL = {"quick": True, "full": False}
GEOMETRIES = ("A", "B")


def errors_trial(condition, rng):
    """`measured` of one geometry, and how large these errors are."""
    found = measured(mirror_rig(condition["geometry"], condition["small"]), rng)
    sizes = {
        f"{name}_rms": float(np.sqrt(np.mean(found[key] ** 2)))
        for name, key in (
            ("corner_px", "corner"),
            ("plate_px", "plate"),
            ("mirror_mm", "mirror.error"),
            ("platter_mm", "platter.error"),
        )
    }
    return found | sizes


# Predicted and true ray errors of three deflections, calibrated together.
#
# No image is rendered: corners and decoded points have Gaussian errors.


STEPS = len(STAGES_MM) - 1
# Inverse depth, the clamp's slope too, and a prior. Its SD, mm, has the least ray error
# at stage 3 among 1, 0.3, 0.1, 0.03, 0.01 and none, on eight runs of either geometry,
# smooth and uneven by 10 µm, that no other run has.
AIMED = MirrorMethod("inverse depth", slope=True, prior_sd=0.1)
COMPARED_PX = 96  # px between the pixels whose rays are compared


def trust_trial(condition, rng):
    """Root mean square ray errors over the whole mirror, degrees, by stage: true,
    predicted, and predicted without the misfit term."""
    rig, errors = mirror_rig(condition["geometry"]), GaussianErrors()
    um, seed = condition["aberration_um"], int(rng.integers(2**32))
    cameras = rig.stages(aberration_um=um, seed=seed)
    first = primary(rig, cameras[0], AIMED, errors, rng)
    # Not used: these draws keep those of the boards as they were.
    poses_in_platter(rig, first.camera.viewer, rig.monitor_poses(rng), errors, rng)
    images = []
    for k in range(STEPS):
        T = rig.board_pose(rng, deflections=STAGES_MM[k : k + 2])
        pair = cameras[k : k + 2]
        images.append([seen_board(rig, camera, T, errors, rng) for camera in pair])
    try:
        bundle = bundled(rig, cameras, first, images)
    except CalibrationError as refusal:
        return {"refused": refusal.code}
    return {f"stage{k}": of_rays(bundle, k, cameras[k]) for k in range(1, STEPS + 1)}


def bundled(rig, cameras, first, images):
    """StageBundle of all stages and boards, from updates of each step."""
    board, points, updates = rig.board, rig.board.points(), []
    before, views = first.camera, []
    size, sd = (board.columns, board.rows), np.full(len(points), CORNER_PX)
    for k, pair in enumerate(images):
        update = deflected(before, cameras[k + 1], pair, points, first.clamp, AIMED)
        updates.append(update)
        before = update.camera
        views += [
            StageView(k + after, k, BoardView(pixels, points, *size, sd=sd))
            for after, pixels in enumerate(pair)
        ]
    return bundle_stages(
        [first.camera, *(update.camera for update in updates)],
        views,
        np.stack([update.pose.T_camera_grid for update in updates]),
        clamp=first.clamp,
        prior_sd=AIMED.prior_sd,
    )


def of_rays(bundle, k, true):
    """The errors of stage k. Both components of a direction have the predicted SD."""
    pixels = lattice(true, COMPARED_PX)
    off = np.radians(ray_angles(bundle.cameras[k], true, pixels))
    sd, misfit = bundle.ray_sd(k, pixels), bundle.misfit[k]
    return {
        "true_deg": _rms_degrees(off),
        "predicted_deg": _rms_degrees(np.sqrt(2) * sd),
        "without_deg": _rms_degrees(np.sqrt(2 * (sd**2 - misfit**2))),
    }


def _rms_degrees(angles):
    return float(np.degrees(np.sqrt(np.nanmean(angles**2))))


# What the mirror shows at each stage: a room, how wide a fan, and where corners go.


# Deflections from stage 0 on over which features are followed, mm.
DEFLECTIONS_MM = (1.0, 2.0, 3.5, 5.0, 7.5, 10.0, 12.5, 15.0)
ALONG = 60  # places along the mirror's middle line
EYE_MM = np.array([-600.0, 0.0, 500.0])


def images_trial(condition, rng):
    """The room in the mirror of the small rig at some stages, grey."""
    rig = mirror_rig(condition["geometry"], small=True)
    cameras = rig.stages()
    T = T_world_camera(cameras)
    return {
        f"stage{k}": scene_image(rig, cameras[k], room(), T, rng)
        for k in condition["stages"]
    }


def T_world_camera(cameras):
    """The camera in the room, so that its mirror shows the bookcase at the right."""
    middle = np.mean([_ends(camera) for camera in cameras], axis=(0, 1))
    turn = np.arctan2(middle[2], middle[0])
    c, s = np.cos(turn), np.sin(turn)
    return pose(np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]), EYE_MM)


def fan_trial(condition, rng):
    """Angle of the fan of rays of the mirror's middle line, degrees, at each stage."""
    rig, seed = mirror_rig(condition["geometry"]), int(rng.integers(2**32))
    return {
        name: np.array(
            [
                fan_deg(c)
                for c in rig.stages(aberration_um=bench.aberration_um, seed=seed)
            ]
        )
        for name, bench in BENCHES.items()
    }


def fan_deg(camera):
    """Largest angle between rays of the middle line, from clamp to free edge, deg."""
    d = _line(camera)
    return float(np.degrees(np.arccos(np.clip(d @ d.T, -1, 1))).max())


def displacement_trial(condition, rng):
    """Mean displacement of the board's corners in the image, px, for DEFLECTIONS_MM."""
    rig = mirror_rig(condition["geometry"])
    T = rig.board_pose(rng, deflections=(0.0, *DEFLECTIONS_MM))
    before, seen = rig.corners(rig.camera(0.0), T)
    found = []
    for deflection in DEFLECTIONS_MM:
        after, also = rig.corners(rig.camera(deflection), T)
        both = seen & also
        found.append(np.linalg.norm(after - before, axis=1)[both].mean())
    return {"moved_px": np.array(found)}


def _ends(camera):
    return _line(camera)[[0, -1]]


def _line(camera):
    """Unit directions (n, 3) of the rays along the mirror's middle line."""
    mirror = camera.mirror
    x = mirror.end * np.linspace(1e-4, 1 - 1e-4, ALONG)
    z = mirror.height(x, 0 * x)[0]
    points = transform(camera.T_viewer_mirror, np.column_stack([x, 0 * x, z]))
    directions = camera.rays(camera.viewer.project(points).pixels).directions
    return directions[np.isfinite(directions[:, 0])]
