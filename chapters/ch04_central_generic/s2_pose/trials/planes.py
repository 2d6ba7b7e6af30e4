"""Synthetic planes at a tilt to the one that (4.24) chooses."""

import numpy as np

from chapters.ch04_central_generic.s2_pose.trials.estimators import errors_of
from chapters.ch04_central_generic.s2_pose.trials.simulated import (
    moved,
    normalised,
    rays_and_points,
)
from chapters.shared.wide_angle import CENTRE_MM, SETTINGS, draw_scene, radial_lens
from raxel.calibration.pose.grid_pose import (
    GRAZING,
    linear_grid_pose,
    synthetic_plane_normal,
)
from raxel.geometry import rotation_from_vector
from repro.run.experiment import experiments
from repro.run.outcomes import Plan

TILTS_DEG = (0, 15, 30, 45, 60)
NOISE_PX = 0.5
TRIALS = {"quick": 5, "full": 100}


def tilted(normal, rng):
    """Normals (tilts, 3), turned from one about an axis at random."""
    axis = normalised(np.cross(normal, rng.standard_normal(3)))
    return rotation_from_vector(np.radians(TILTS_DEG)[:, None] * axis) @ normal


def plane_trial(condition, rng):
    """Errors of the linear pose on planes of every tilt, one scene.

    `common`: with the rays that all planes see; `own`: with those that each
    one sees.
    """
    scene = draw_scene(radial_lens(), condition["noise"], rng, grids=2)
    directions, points = rays_and_points(scene, "measured on the base grid")
    true = moved(scene.T_base_grid[1], -CENTRE_MM)
    normals = tilted(synthetic_plane_normal(directions), rng)
    seen = (directions @ normals.T > GRAZING).all(axis=1)
    out = {"share_common": np.mean(seen)}
    for kind, used in (("common", seen), ("own", np.ones_like(seen))):
        for tilt, normal in zip(TILTS_DEG, normals, strict=True):
            found = linear_grid_pose(directions[used], points[used], normal=normal)
            out.setdefault(kind, {})[str(tilt)] = errors_of(
                found.T_camera_grid, true
            ) | {"left_out": found.behind / len(directions)}
    return out


@experiments({"exp_c4_plane_orientation": "fig_4_3", "exp_c4_plane_free": "fig_4_3"})
def plane_orientation(effort, identifier):
    """Pose errors on planes tilted against the one of (4.24), and without noise."""
    noise = 0.0 if identifier == "exp_c4_plane_free" else NOISE_PX
    settings = SETTINGS | {"tilts_deg": TILTS_DEG}
    return Plan(plane_trial, [{"noise": noise}], TRIALS[effort], settings)
