"""A further grid's pose by rays that are exact, or measured in several ways."""

from __future__ import annotations

import numpy as np

from chapters.ch04_central_generic.s2_pose.trials.estimators import scored
from chapters.ch04_central_generic.s2_pose.trials.simulated import (
    lifted,
    moved,
    normalised,
)
from chapters.shared.wide_angle import (
    CENTRE_MM,
    SIZE_PX,
    T_BASE_CAMERA,
    draw_scene,
    radial_lens,
)
from raxel.calibration import smoothed_rays
from raxel.calibration.grid_pose import (
    linear_grid_pose,
    refine_pose_angular,
)
from raxel.geometry import transform
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

NOISE_PX = 0.5
GRIDS = 3  # that rays are measured on; one more is posed
SOURCES = {
    "exact": "exact",
    "base": "measured on the base grid",
    "three": "measured on three grids",
    "smooth": "measured on three grids, smoothed",
}
TRIALS = {"quick": 3, "full": 50}


def rays_of(scene):
    """Rays (N, 3) of every source, from the true centre and the true poses."""
    measured = [
        normalised(transform(T, lifted(points)) - CENTRE_MM)
        for T, points in zip(
            scene.T_base_grid[:GRIDS], scene.noisy[:GRIDS], strict=True
        )
    ]
    three = normalised(np.mean(measured, axis=0))
    R = T_BASE_CAMERA[:3, :3]
    smooth = smoothed_rays(scene.pixels, three @ R, SIZE_PX, SIZE_PX)
    return {
        "exact": scene.directions,
        "base": measured[0],
        "three": three,
        "smooth": smooth.camera.rays(scene.pixels).directions @ R.T,
    }


def source_trial(condition, rng):
    """Errors of the pose with the smallest angles, by the rays' source."""
    scene = draw_scene(radial_lens(), NOISE_PX, rng, grids=GRIDS + 1)
    points, true = scene.noisy[GRIDS], scene.T_base_grid[GRIDS]
    out = {}
    for source, directions in rays_of(scene).items():
        start = linear_grid_pose(directions, points).T_camera_grid
        found = refine_pose_angular(directions, points, start)
        out[source] = scored(found.T_camera_grid, moved(true, -CENTRE_MM))
    return out


@experiment(
    "ext_pose_rays_run",
    artefact="ext_pose_rays",
    shards={"quick": 1, "full": 1},
)
def sources(effort):
    """The same pose by rays from four sources."""
    settings = {"noise_px": NOISE_PX, "grids": GRIDS}
    return Plan(source_trial, [{}], TRIALS[effort], settings)
