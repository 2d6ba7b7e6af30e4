"""A mirror that is calibrated, and a cylinder that moves before it.

Three cameras see the same pictures of stage 3: the true one, that of the published
method, stage by stage, and that of all stages at once with a prior on bending
(5.3.3). What is off by the true one is the geometry's, the rest the
calibration's. At the stages before, the scale alone is looked at, beside what the rays
can tell of it.
"""

import numpy as np

from chapters.ch05_flexible_mirror.s3_5_motion.trials.calibrated import (
    LAST,
    all_stages,
    calibrated,
)
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
from chapters.shared.mirror_bundle import AIMED
from chapters.shared.mirror_rigs import STAGES_MM, mirror_rig
from chapters.shared.mirror_runs import PUBLISHED, lattice
from chapters.shared.mirror_scores import ray_angles
from raxel.errors import CalibrationError
from raxel.multiview.motion_information import motion_information

# How stage 3 is known, the second as in the thesis.
EVERY_WAY = ("true", "published", "bundle")
# Later places that each camera sets beside the first one alone: 25, 50 and 100 mm away.
SET_BESIDE = {"true": (1, 2, 4), "published": (1, 2, 4), "bundle": (4,)}
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


def motion_trial(condition, rng, errors, benches, ways=EVERY_WAY):
    """Some cameras on each of some benches, drawn alike; of the published one alone,
    pairs of pictures with open lengths at stage 3."""
    rig, seed = mirror_rig(condition["geometry"]), int(rng.integers(2**32))
    of_rig = errors[condition["geometry"]]
    return {
        name: one_bench(rig, bench, of_rig._replace(factor=bench.factor), seed, ways)
        for name, bench in benches.items()
    }


def one_bench(rig, bench, errors, seed, ways):
    """Calibrations of a bench, and what each makes of the cylinder."""
    cameras = rig.stages(aberration_um=bench.aberration_um, seed=seed)
    found, refusal = calibrated(rig, cameras, errors, seed, PUBLISHED)
    out = {"refused": refusal} if refusal else {}
    seers, alone = {"published": found.last}, ways == ("published",)
    for stage in (LAST,) if alone else range(LAST + 1):
        rng = np.random.default_rng([seed, stage])
        scene = moved_cylinder(cameras[stage], rng)
        pixels = scene.pixels + NOISE_PX * rng.standard_normal(scene.pixels.shape)
        if not alone:
            out[f"stage{stage}"] = told(cameras[stage], scene)
            if stage < min(LAST, len(found.cameras)):
                out[f"stage{stage}"] |= steps_found(found.cameras[stage], pixels, rng)
    if "true" in ways:
        seers["true"] = cameras[LAST]
        out["marks"] = {"true": scene.points, "path": scene.T[:, :3, 3]}
    if "bundle" in ways:
        seers["bundle"], refusal = bundled(rig, cameras, errors, seed)
        out |= {"not_bundled": refusal} if refusal else {}
    rays = lattice(cameras[LAST], COMPARED_PX)
    for name, camera in seers.items():
        if camera is not None:
            drawn = np.random.default_rng([seed, LAST + 1])
            beside = () if alone else SET_BESIDE[name]
            out[name] = motion_and_shape(camera, scene, pixels, drawn, beside)
            off = ray_angles(camera, cameras[LAST], rays)
            out[name]["ray_deg"] = float(np.nanmean(off))
    return out


def bundled(rig, cameras, errors, seed):
    """(camera of stage 3 of all stages at once or None, why not or "")."""
    found, refusal = calibrated(rig, cameras, errors, seed, AIMED)
    return (None, refusal) if refusal else all_stages(rig, found, errors)


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
