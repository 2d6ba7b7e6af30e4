"""A further grid's pose by rays that are exact, or measured in several ways.

All but the last take the true centre, and those from three grids their true poses, so
that the rays alone differ. The last is what a user has: centre, poses and rays are all
found from the same three grids.
"""

import numpy as np

from chapters.ch04_central_generic.s2_pose.trials.estimators import scored
from chapters.ch04_central_generic.s2_pose.trials.simulated import moved, normalised
from chapters.shared.wide_angle import (
    CENTRE_MM,
    SIDE,
    SIZE_PX,
    T_BASE_CAMERA,
    draw_scene,
    radial_lens,
)
from raxel.calibration import adjust_consistent, linear_cgsp, smoothed_rays
from raxel.calibration.pose.grid_pose import linear_grid_pose, refine_pose_angular
from raxel.geometry import on_plane, transform
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

NOISE_PX = 0.5
GRIDS = 3  # that rays are measured on; one more is posed
SOURCES = {
    "exact": "exact",
    "base": "measured on the base grid",
    "three": "measured on three grids",
    "smooth": "measured on three grids, smoothed",
    "calibrated": "centre, poses and rays found from three grids",
}
TRIALS = {"quick": 3, "full": 50}


def rays_of(scene):
    """Source -> rays (N, 3) and the centre (3,) that they begin at, base frame."""
    measured = [
        normalised(transform(T, on_plane(points)) - CENTRE_MM)
        for T, points in zip(
            scene.T_base_grid[:GRIDS], scene.noisy[:GRIDS], strict=True
        )
    ]
    three = normalised(np.mean(measured, axis=0))
    R = T_BASE_CAMERA[:3, :3]
    smooth = smoothed_rays(scene.pixels, three @ R, SIZE_PX, SIZE_PX)
    given_centre = {
        "exact": scene.directions,
        "base": measured[0],
        "three": three,
        "smooth": smooth.camera.rays(scene.pixels).directions @ R.T,
    }
    linear = linear_cgsp(scene.noisy[:GRIDS], side=SIDE)
    found = adjust_consistent(
        scene.noisy[:GRIDS], None, linear.centre, linear.T_base_grid
    )
    return {name: (rays, CENTRE_MM) for name, rays in given_centre.items()} | {
        "calibrated": (found.directions, found.centre)
    }


def source_trial(condition, rng):
    """Errors of the pose with the smallest angles, by the rays' source."""
    scene = draw_scene(radial_lens(), NOISE_PX, rng, grids=GRIDS + 1)
    points, true = scene.noisy[GRIDS], scene.T_base_grid[GRIDS]
    out = {}
    for source, (directions, centre) in rays_of(scene).items():
        start = linear_grid_pose(directions, points).T_camera_grid
        found = refine_pose_angular(directions, points, start)
        # Both are errors in the base frame, that of the centre among them.
        posed = moved(found.T_camera_grid, centre - CENTRE_MM)
        out[source] = scored(posed, moved(true, -CENTRE_MM))
    return out


@experiment("ext_pose_rays_run", artefact="ext_pose_rays")
def sources(effort):
    """The same pose by rays from four sources."""
    return Plan(
        source_trial, [{}], TRIALS[effort], {"noise_px": NOISE_PX, "grids": GRIDS}
    )
