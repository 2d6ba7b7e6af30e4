"""A mirror pushed three times and let back, calibrated step by step and at once."""

from itertools import pairwise

import numpy as np

from chapters.ch05_flexible_mirror.ext_trust.trials.lesson import field_of_view
from chapters.ch05_flexible_mirror.ext_trust.trials.scene import (
    METHOD,
    PRIORS,
    STEPS,
    SureViewer,
    drawn_scene,
)
from chapters.shared.gaussian_errors import CORNER_PX, GaussianErrors
from chapters.shared.mirror_rigs import STAGES_MM
from chapters.shared.mirror_runs import deflected, lattice, outline
from chapters.shared.mirror_scores import (
    back_projection,
    lengths,
    load_height,
    ray_angles,
)
from raxel.calibration import BoardView, StageView, bundle_stages
from raxel.calibration.mirror.clamp import Clamp, clamped
from raxel.calibration.mirror.update import update_mirror
from raxel.cameras import SplineMirrorCamera
from raxel.errors import CalibrationError

# px between the pixels whose rays are compared.
COMPARED_PX = 96


def trust_trial(condition, rng):
    """Every measure of a seed, with the prior and without."""
    scene = drawn_scene(condition["geometry"], condition["aberration_um"], rng)
    separation_mm, separation_deg = scene.separation
    found = {
        name: course(scene, METHOD._replace(prior_sd=prior))
        for name, prior in PRIORS.items()
    }
    return found | {
        "separation_mm": separation_mm,
        "separation_deg": separation_deg,
        "stage0_deg": mean_angle(scene, 0, scene.first.camera),
    }


def course(scene, method):
    """Three steps out, all stages together, three steps back, and all at a stroke, by
    common corners and by all; `refused`, `single_refused` and `single_all_refused` say
    where it ended, if early."""
    out = {}
    try:
        stages = steps_out(scene, method)
        for k, stage in enumerate(stages, 1):
            out[f"stage{k}"] = of_stage(scene, k, stage)
        out["bundle"] = of_bundle(scene, bundled(scene, method, stages))
        out["loop_mm"] = loop_error(scene, method, stages[-1].camera)
    except CalibrationError as refusal:
        out["refused"] = str(refusal)
    for name, all_after in (("single", False), ("single_all", True)):
        try:
            out[f"{name}_percent"] = single_step(scene, method, all_after)
        except CalibrationError as refusal:
            out[f"{name}_refused"] = str(refusal)
    return out


def own_space_trial(condition, rng):
    """Coverage of the rays where the mirror *is* one of the splines.

    What is found is made to keep the clamp and taken for the truth; corners are drawn
    from it, and all is found again, without a prior, which is true of none of them.
    """
    scene = drawn_scene(condition["geometry"], 0.0, rng)
    method = METHOD._replace(prior_sd=PRIORS["prior"])
    found = bundled(scene, method, steps_out(scene, method))
    held = scene.first.clamp
    clamp = Clamp(held.points, held.values, held.slopes)
    true = [found.cameras[0], *(on_clamp(c, clamp) for c in found.cameras[1:])]
    T = found.T_camera_grid
    pictures = [
        [redrawn(scene, true[k + after], T[k], pixels, rng)
         for after, pixels in enumerate(pair)]
        for k, pair in enumerate(scene.pictures)
    ]  # fmt: skip
    try:
        again = bundle_stages(true, stage_views(scene, pictures), T, clamp=clamp)
    except CalibrationError as refusal:
        return {"refused": str(refusal)}
    return {
        f"stage{k}": of_rays(again, k, true[k], lattice(scene.cameras[k], COMPARED_PX))
        for k in range(1, STEPS + 1)
    }


def known_viewer_trial(condition, rng):
    """Coverage of the bundle's rays where the viewer has no error that no prediction
    knows of; with the prior."""
    scene = drawn_scene(condition["geometry"], 0.0, rng, SureViewer())
    method = METHOD._replace(prior_sd=PRIORS["prior"])
    try:
        bundle = bundled(scene, method, steps_out(scene, method))
    except CalibrationError as refusal:
        return {"refused": str(refusal)}
    return {
        f"stage{k}": of_rays(
            bundle, k, scene.cameras[k], lattice(scene.cameras[k], COMPARED_PX)
        )
        for k in range(1, STEPS + 1)
    }


def redrawn(scene, camera, T, pixels, rng):
    """Corners (N, 2) that another camera shows, of those seen at pixels (N, 2)."""
    there, seen = scene.rig.corners(camera, T)
    seen &= np.isfinite(pixels).all(axis=1)
    there = GaussianErrors().corners(there, rng)
    return np.where(seen[:, None], there, np.nan)


def on_clamp(camera, clamp):
    """The nearest SplineMirrorCamera that keeps a Clamp."""
    space = clamped(camera.grid, clamp)
    c = space.coefficients(space.free(camera.coefficients.ravel("F")))
    return SplineMirrorCamera.on_grid(camera.viewer, camera.grid, c, camera.quantity)


def steps_out(scene, method):
    """MirrorUpdates of stages 1 to 3, each from the one before."""
    found, before = [], scene.first.camera
    for k, pictures in enumerate(scene.pictures, 1):
        found.append(one_step(scene, method, before, pictures, k))
        before = found[-1].camera
    return found


def one_step(scene, method, before, pictures, end):
    """MirrorUpdate of one step to a stage."""
    held = scene.first.clamp
    return deflected(before, scene.cameras[end], pictures, scene.points, held, method)


def of_stage(scene, k, stage):
    """How far a stage is off, what shows of it, and what it predicts."""
    camera, true = stage.camera, scene.cameras[k]
    pixels, T = scene.scored[k - 1]
    own, of_true = (
        float(lengths(back_projection(camera, pixels, scene.points, pose)).mean())
        for pose in (None, T)
    )
    rays = lattice(true, COMPARED_PX)
    return {
        "deflection_percent": deflection_error(scene, k, camera),
        "angle_deg": mean_angle(scene, k, camera),
        "residual_mm": float(np.nanmean(stage.residuals)),
        "back_own_mm": own,
        "back_true_mm": of_true,
        "common": int(np.count_nonzero(stage.used)),
        "prior_share": stage.fit.prior_share,
        "field_error_deg": field_of_view(camera, true) - field_of_view(true, true),
        **predicted(camera, true, rays, stage.ray_sd(rays)),
    }


def mean_angle(scene, k, camera):
    """Mean angle, degrees, to the true rays over the whole mirror."""
    true = scene.cameras[k]
    return float(np.nanmean(ray_angles(camera, true, lattice(true, COMPARED_PX))))


def deflection_error(scene, k, camera):
    """Percent of the deflection from stage 0 to stage k by which it was found wrong."""
    start = load_height(scene.rig, scene.first.camera, scene.cameras[0])
    reached = load_height(scene.rig, camera, scene.cameras[k])
    return 100 * abs(reached - start - STAGES_MM[k]) / STAGES_MM[k]


def predicted(found, true, pixels, sd):
    """Predicted beside true errors of rays at pixels (N, 2).

    sd: (N,) radians, of each of the two components of a direction. coverage: mean
    square of what rays are off over what they should be.
    """
    off = np.radians(ray_angles(found, true, pixels))
    return {
        "true_deg": rms_degrees(off),
        "predicted_deg": rms_degrees(np.sqrt(2) * sd),
        "coverage": float(np.nanmean(off**2 / (2 * sd**2))),
    }


def rms_degrees(angles):
    """Root mean square, degrees, of angles (N,), radians; NaN do not count."""
    return float(np.degrees(np.sqrt(np.nanmean(angles**2))))


def bundled(scene, method, stages):
    """StageBundle of all stages and boards together."""
    cameras = [scene.first.camera, *(stage.camera for stage in stages)]
    poses = np.stack([stage.pose.T_camera_grid for stage in stages])
    views = stage_views(scene, scene.pictures)
    return bundle_stages(
        cameras, views, poses, clamp=scene.first.clamp, prior_sd=method.prior_sd
    )


def stage_views(scene, pictures):
    """StageViews of the board of each step, known to the corners' noise."""
    board, sd = scene.rig.board, np.full(len(scene.points), CORNER_PX)
    size = board.columns, board.rows
    return [
        StageView(k + after, k, BoardView(pixels, scene.points, *size, sd=sd))
        for k, pair in enumerate(pictures)
        for after, pixels in enumerate(pair)
    ]


def of_bundle(scene, bundle):
    """How far each stage is off after the bundle, and what that predicts."""
    scores = {"variance": bundle.variance}
    for k in range(1, STEPS + 1):
        true, camera = scene.cameras[k], bundle.cameras[k]
        scores[f"stage{k}"] = {
            "deflection_percent": deflection_error(scene, k, camera),
            "angle_deg": mean_angle(scene, k, camera),
            "misfit_deg": float(np.degrees(bundle.misfit[k])),
            **of_rays(bundle, k, true, lattice(true, COMPARED_PX)),
        }
    return scores


def of_rays(bundle, k, true, pixels):
    """Predicted beside true errors, among the corners of a stage and of all pixels."""
    sd, among = bundle.ray_sd(k, pixels), bundle.among_corners(k, pixels)
    camera = bundle.cameras[k]
    return {
        "among": predicted(camera, true, pixels[among], sd[among]),
        "whole": predicted(camera, true, pixels, sd),
    }


def loop_error(scene, method, camera):
    """mm by which the load's height differs after three steps out and three back."""
    for start, end in pairwise(range(STEPS, -1, -1)):
        pictures = scene.stay[start], scene.stay[end]
        camera = one_step(scene, method, camera, pictures, end).camera
    heights = [
        load_height(scene.rig, of, scene.cameras[0])
        for of in (scene.first.camera, camera)
    ]
    return abs(heights[1] - heights[0])


def single_step(scene, method, all_after):
    """Percent of 15 mm by which one step from stage 0 to stage 3 was found wrong; by
    the corners that both pictures show, or by all of the second one."""
    stage = update_mirror(
        scene.first.camera,
        scene.stay[0],
        scene.stay[-1],
        scene.points,
        scene.first.clamp,
        method.settings._replace(all_after=all_after),
        outline=outline(scene.cameras[-1]),
    )
    return deflection_error(scene, STEPS, stage.camera)
