"""A calibrated mirror, and a cylinder that moves in front of it.

Two cameras use the same images of stage 3: the true one, and that of the published
method, stage by stage. Errors of the true one come from the geometry, the rest from the
calibration. At earlier stages only the scale is estimated, and what the rays determine
of it.
"""

import numpy as np

from chapters.ch05_flexible_mirror.s3_5_motion.trials.calibrated import LAST, calibrated
from chapters.ch05_flexible_mirror.s3_5_motion.trials.motion import (
    BASELINES,
    motion_and_shape,
    pairwise,
    seen_by,
)
from chapters.ch05_flexible_mirror.s3_5_motion.trials.scene import (
    AWAY_MM,
    MARKS,
    NOISE_PX,
    RADIUS_MM,
    STEP_MM,
    moved_cylinder,
)
from chapters.shared.mirror_rigs import STAGES_MM, mirror_rig
from chapters.shared.mirror_runs import lattice
from chapters.shared.mirror_scores import ray_angles
from raxel.errors import CalibrationError
from raxel.multiview.motion_information import motion_information

SETTINGS = {
    "stages_mm": list(STAGES_MM),
    "marks": MARKS,
    "mark_px": NOISE_PX,
    "radius_mm": RADIUS_MM,
    "step_mm": STEP_MM,
    "cylinder_mm": AWAY_MM,
}
# px between the pixels whose rays are compared with the true ones.
COMPARED_PX = 96


def motion_trial(condition, rng, errors, benches, alone=False):
    """Run both cameras at each of some error levels, with the same draws.

    alone: only the published one, with open lengths at stage 3.
    """
    rig, seed = mirror_rig(condition["geometry"]), int(rng.integers(2**32))
    of_rig = errors[condition["geometry"]]
    return {
        name: one_bench(rig, bench, of_rig.on(bench), seed, alone)
        for name, bench in benches.items()
    }


def one_bench(rig, bench, errors, seed, alone):
    """Calibrate at one level, and estimate the cylinder's motion with each camera."""
    cameras = rig.stages(aberration_um=bench.aberration_um, seed=seed)
    found, refusal = calibrated(rig, cameras, errors, seed)
    out = {"refused": refusal} if refusal else {}
    seers = {"published": found[LAST]} if len(found) > LAST else {}
    for stage in (LAST,) if alone else range(LAST + 1):
        rng = np.random.default_rng([seed, stage])
        scene = moved_cylinder(cameras[stage], rng)
        pixels = scene.pixels + NOISE_PX * rng.standard_normal(scene.pixels.shape)
        if not alone:
            out[f"stage{stage}"] = length_bounds(cameras[stage], scene)
            if stage < min(LAST, len(found)):
                out[f"stage{stage}"] |= steps_found(found[stage], pixels, rng)
    if not alone:
        seers["true"] = cameras[LAST]
        out["marks"] = {"path": scene.T[:, :3, 3]}
    rays = lattice(cameras[LAST], COMPARED_PX)
    for name, camera in seers.items():
        drawn = np.random.default_rng([seed, LAST + 1])
        out[name] = motion_and_shape(camera, scene, pixels, drawn, alone)
        off = ray_angles(camera, cameras[LAST], rays)
        out[name]["ray_deg"] = float(np.nanmean(off))
    return out


def length_bounds(camera, scene):
    """Smallest standard deviation of the length of one step and of more, percent.

    From the Fisher information of exact rays with this noise, for any unbiased method.
    Rays through one point determine no length.
    """
    seen = seen_by(camera, scene.pixels)
    out = {}
    for k in BASELINES:
        bound = motion_information(scene.T[k], seen.rays[0], seen.rays[k])
        if bound.spread:
            out[f"told{k}"] = {"length_percent": 100 * bound.scale_sd}
    return out | {"spread_mm": bound.spread}


def steps_found(camera, pixels, rng):
    """Mean length of the steps from pairs of images."""
    try:
        seen = seen_by(camera, pixels)
        lengths = [np.linalg.norm(seen.shift(T)) for T in pairwise(seen.rays, rng)]
    except CalibrationError:
        return {}
    return {"mean_mm": float(np.mean(lengths))}
