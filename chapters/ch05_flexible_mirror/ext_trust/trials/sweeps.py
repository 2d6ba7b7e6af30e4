"""How strong the prior is, and how far features reach: what either does to the rays."""

import numpy as np

from chapters.ch05_flexible_mirror.ext_trust.trials.course import (
    deflection_error,
    mean_angle,
    one_step,
    steps_out,
)
from chapters.ch05_flexible_mirror.ext_trust.trials.scene import (
    METHOD,
    PRIORS,
    STEPS,
    drawn_scene,
)
from chapters.shared.mirror_runs import lattice
from chapters.shared.mirror_scores import ray_angles
from raxel.calibration.mirror.sightings import normalised
from raxel.calibration.mirror.support import clamped_end
from raxel.errors import CalibrationError
from raxel.geometry import inverse_pose, transform

# Standard deviations of the prior that are tried, mm; None for no prior.
PRIORS_MM = {
    "none": None, "1": 1.0, "0.3": 0.3, "0.1": 0.1, "0.03": 0.03, "0.01": 0.01
}  # fmt: skip
# Shares of the last knot interval, from its inner knot, in which corners are kept.
REACHES = (1.0, 0.4, 0.3, 0.2, 0.1, 0.0)
# The free edge: the last tenth of the sheet.
EDGE = 0.9
EDGE_PX = 48


def prior_trial(condition, rng):
    """Rays and deflection at stage 3, for each strength of the prior."""
    scene = drawn_scene(condition["geometry"], condition["aberration_um"], rng)
    return {name: _at_the_end(scene, prior) for name, prior in PRIORS_MM.items()}


def _at_the_end(scene, prior):
    try:
        camera = steps_out(scene, METHOD._replace(prior_sd=prior))[-1].camera
    except CalibrationError as refusal:
        return {"refused": str(refusal)}
    return {
        "angle_deg": mean_angle(scene, STEPS, camera),
        "deflection_percent": deflection_error(scene, STEPS, camera),
    }


def support_trial(condition, rng):
    """Stage 1 with fewer and fewer corners next to the free edge."""
    scene = drawn_scene(condition["geometry"], 0.0, rng)
    before, (first, after) = scene.first.camera, scene.pictures[0]
    method = METHOD._replace(prior_sd=PRIORS["prior"])
    whole = one_step(scene, method, before, (first, after), 1)
    place = places_in_last(whole.camera, scene.first.clamp, after)
    found = {}
    for number, reach in enumerate(REACHES):
        kept = np.where((place <= reach)[:, None], after, np.nan)
        for name, prior in PRIORS.items():
            own = METHOD._replace(prior_sd=prior)
            found[f"reach{number}.{name}"] = _next_to_the_edge(scene, own, first, kept)
    return found


def places_in_last(camera, clamp, pixels):
    """Where pixels (N, 2) lie along u: 0 at the inner knot of the interval next to the
    free edge, 1 at the edge, below 0 farther in; NaN stays."""
    u = camera.grid.turned(normalised(camera.viewer, pixels))[:, 0]
    breaks = camera.grid.breaks[0]
    last = breaks[-2:] if free_end(camera, clamp) else breaks[1::-1]
    return (u - last[0]) / (last[1] - last[0])


def free_end(camera, clamp):
    """0 or -1: the end of the knots along u that the clamp does not hold."""
    return -1 - clamped_end(camera.grid, clamp)[1]


def _next_to_the_edge(scene, method, first, after):
    true = scene.cameras[1]
    try:
        stage = one_step(scene, method, scene.first.camera, (first, after), 1)
    except CalibrationError as refusal:
        return {"refused": str(refusal)}
    pixels = lattice(true, EDGE_PX)
    at_edge = along_sheet(true, pixels) > EDGE
    off = ray_angles(stage.camera, true, pixels)
    end = free_end(stage.camera, scene.first.clamp)
    return {
        "edge_deg": float(np.nanmean(off[at_edge])),
        "rest_deg": float(np.nanmean(off[~at_edge])),
        "residual_mm": float(np.nanmean(stage.residuals)),
        "predicted_deg": float(
            np.degrees(np.nanmean(stage.ray_sd(pixels[at_edge])) * np.sqrt(2))
        ),
        "features": int(stage.support.along_u[end]),
    }


def along_sheet(true, pixels):
    """Shares (N,) of the sheet's length, from the clamp, at which pixels look."""
    points = transform(inverse_pose(true.T_viewer_mirror), true.rays(pixels).origins)
    return points[:, 0] / true.mirror.end
