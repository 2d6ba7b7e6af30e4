"""A mirror that is calibrated stage by stage, and a cylinder that moves before it.

Three cameras see the same pictures of stage 3: the true one, that of the published
method, stage by stage, and that of all stages in one bundle. What is off by the true
one is the geometry's, the rest the calibration's. At the stages before, the scale
alone is looked at, beside what the rays can tell of it.
"""

import numpy as np

from chapters.ch05_flexible_mirror.s3_5_motion.trials.motion import (
    BASELINES,
    motion_and_shape,
    pairwise,
    seen_by,
)
from chapters.ch05_flexible_mirror.s3_5_motion.trials.scene import (
    NOISE_PX,
    moved_cylinder,
)
from chapters.shared.mirror_rigs import STAGES_MM, mirror_rig
from chapters.shared.mirror_runs import PUBLISHED, deflected, primary, seen_board
from raxel.calibration.mirror.bundle import StageView, bundle_stages
from raxel.calibration.views.correspondence import BoardView
from raxel.errors import CalibrationError, InputError
from raxel.multiview.motion_information import motion_information

LAST = len(STAGES_MM) - 1


def motion_trial(condition, rng, errors, benches, whole=True):
    """All cameras on each of some benches, drawn alike; whole=False: the published
    method at stage 3 alone."""
    rig, seed = mirror_rig(condition["geometry"]), int(rng.integers(2**32))
    of_rig = errors[condition["geometry"]]
    return {
        name: one_bench(rig, bench, of_rig._replace(factor=bench.factor), seed, whole)
        for name, bench in benches.items()
    }


def one_bench(rig, bench, errors, seed, whole):
    """Calibrations of a bench, and what each makes of the cylinder."""
    cameras = rig.stages(aberration_um=bench.aberration_um, seed=seed)
    found, bundled, out = calibrated(rig, cameras, errors, seed, whole)
    for stage in range(LAST + 1) if whole else (LAST,):
        rng = np.random.default_rng([seed, stage])
        scene = moved_cylinder(cameras[stage], rng)
        pixels = scene.pixels + NOISE_PX * rng.standard_normal(scene.pixels.shape)
        if whole:
            out[f"stage{stage}"] = told(cameras[stage], scene)
        if whole and stage < LAST and stage < len(found):
            out[f"stage{stage}"] |= steps_found(found[stage], pixels, rng)
    seers = {"published": found[LAST] if len(found) > LAST else None}
    if whole:
        seers |= {"true": cameras[LAST], "bundle": bundled}
        out["marks"] = {"true": scene.points, "path": scene.T[:, :3, 3]}
    for name, camera in seers.items():
        if camera is not None:
            drawn = np.random.default_rng([seed, LAST + 1])
            out[name] = motion_and_shape(camera, scene, pixels, drawn)
    return out


def calibrated(rig, true, errors, seed, whole):
    """(cameras of the stages reached, that of stage 3 by the bundle or None, {reason})

    true: the true cameras; whole: whether the bundle is run.
    """
    rng = np.random.default_rng(seed)
    try:
        first = primary(rig, true[0], PUBLISHED, errors, rng)
    except InputError as refusal:
        return [], None, {"refused": f"stage 0: {refusal}"}
    cameras, updates, views = [first.camera], [], []
    points = rig.board.points()
    for k in range(1, LAST + 1):
        T = rig.board_pose(rng, deflections=STAGES_MM[k - 1 : k + 1])
        pictures = [seen_board(rig, c, T, errors, rng) for c in true[k - 1 : k + 1]]
        try:
            stage = deflected(
                cameras[-1], true[k], pictures, points, first.clamp, PUBLISHED
            )
        except InputError as refusal:
            return cameras, None, {"refused": f"stage {k}: {refusal}"}
        cameras.append(stage.camera)
        updates.append(stage)
        views += _stage_views(rig, k, pictures, points, stage.wrong)
    if not whole:
        return cameras, None, {}
    poses = np.stack([update.pose.T_camera_grid for update in updates])
    try:
        bundle = bundle_stages(cameras, views, poses, clamp=first.clamp)
    except InputError as refusal:
        return cameras, None, {"not_bundled": str(refusal)}
    return cameras, bundle.cameras[LAST], {}


def _stage_views(rig, k, pictures, points, wrong):
    """StageViews of the board of stage k before and after, without wrong corners."""
    size = rig.board.columns, rig.board.rows
    return [
        StageView(
            stage,
            k - 1,
            BoardView(np.where(wrong[:, None], np.nan, pixels), points, *size),
        )
        for stage, pixels in zip((k - 1, k), pictures, strict=True)
    ]


def told(camera, scene):
    """What exact rays with this noise can tell of one step and of more, by nobody's
    method: percent of the length, and degrees of the turn. Rays through one point tell
    no length, and have none."""
    seen = seen_by(camera, scene.pixels)
    out = {}
    for k in BASELINES:
        bound = motion_information(scene.T[k], seen.rays[0], seen.rays[k])
        found = {"turn_given_deg": float(np.degrees(bound.with_length[0]))}
        if bound.spread:
            found["length_percent"] = 100 * bound.scale_sd
            found["turn_deg"] = float(np.degrees(bound.rotation_sd))
        out[f"told{k}"] = found
    return out | {"spread_mm": bound.spread}


def steps_found(camera, pixels, rng):
    """Mean length of the steps, as pairs of pictures have them."""
    try:
        seen = seen_by(camera, pixels)
        lengths = [np.linalg.norm(seen.shift(T)) for T in pairwise(seen.rays, rng)]
    except CalibrationError:
        return {}
    return {"mean_mm": float(np.mean(lengths))}
