"""Ways to interpolate, with and without noise of the corners, and an active grid."""

import numpy as np

from chapters.ch03_planar_grids.s2_1_interpolation_bias.trials.active import (
    decoding_errors,
)
from chapters.ch03_planar_grids.s2_1_interpolation_bias.trials.interpolators import (
    METHODS,
    by_need,
)
from chapters.ch03_planar_grids.s2_1_interpolation_bias.trials.scenes import (
    CORNER_NOISE_PX,
    POINTS,
    SETTINGS,
    SIDE_MM,
    derivatives,
    lens,
    predicted_bias,
    rms,
    scene_named,
)
from raxel.sets import ActiveGrid
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

METHOD_PITCHES_MM = {
    "lens of 3.2.1": (10, 15, 20, 30, 50, 60),
    "fisheye": (10, 20, 30, 60),
    "hyperboloidal mirror": (10, 20, 30, 60),
}


def method_trial(condition, rng):
    """Bias, and what noise of the corners adds, of every method: mm and px.

    In px: the error on the grid, taken to the picture by the first derivative.
    """
    scene = scene_named(condition["camera"])
    points = rng.uniform(0, SIDE_MM, (POINTS, 2))
    pixels, exact = scene.pixels(points), scene.view(condition["pitch_mm"])
    noise = rng.normal(0, CORNER_NOISE_PX, exact.pixels.shape)
    noisy = exact._replace(pixels=exact.pixels + noise)
    J = derivatives(scene, points)[0]

    def in_px(errors):
        return rms(np.einsum("nij,nj->ni", J, errors))

    found = {
        "predicted_mm": rms(predicted_bias(scene, points, condition["pitch_mm"])),
        "px_per_mm": float(np.sqrt(np.abs(np.linalg.det(J))).mean()),
        "by need": {"total_px": in_px(by_need(pixels, noisy) - points)},
    }
    for name, find in METHODS.items():
        bias = find(pixels, exact) - points
        total = find(pixels, noisy) - points
        found[name] = {
            "bias_mm": rms(bias),
            "bias_px": in_px(bias),
            "noise_px": in_px(total - bias),
            "total_px": in_px(total),
        }
    return found


@experiment(
    "ext_interpolation_methods",
    artefact="ext_interpolation_methods",
    inputs=("data/rigs/hyperboloidal.yaml",),
)
def methods(effort):
    """Four ways to interpolate, three cameras, with and without noise."""
    pitches = METHOD_PITCHES_MM
    if effort == "quick":
        pitches = {"lens of 3.2.1": (20, 30)}
    conditions = [
        {"camera": camera, "pitch_mm": pitch}
        for camera, swept in pitches.items()
        for pitch in swept
    ]
    trials = {"quick": 1, "full": 2}[effort]
    settings = SETTINGS | {"corner_noise_px": CORNER_NOISE_PX}
    return Plan(method_trial, conditions, trials, settings)


BESIDE = ActiveGrid((1000, 1000), (SIDE_MM, SIDE_MM))


def active_trial(condition, rng):
    """RMS error in mm of the decoded pixels, with and without the 7 x 7 filter."""
    scene = lens(1, condition["width_px"])
    errors, seen = decoding_errors(scene.camera, BESIDE, scene.T_camera_grid, rng)
    on = np.isfinite(seen[..., 0])
    return {
        name: {"rms_mm": rms(e), "trusted": float(np.isfinite(e[on][:, 0]).mean())}
        for name, e in errors.items()
    }


@experiment("ext_interpolation_active", artefact="ext_interpolation_methods")
def active_beside(effort):
    """An active grid where the grid of Fig. 3.6 stood."""
    width, trials = {"quick": (100, 1), "full": (300, 2)}[effort]
    return Plan(active_trial, [{"width_px": width}], trials, SETTINGS)
