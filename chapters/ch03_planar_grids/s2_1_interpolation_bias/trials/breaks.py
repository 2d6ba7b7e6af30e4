"""Interpolation and decoding at the ridge of two mirrors."""

import numpy as np

from chapters.ch03_planar_grids.s2_1_interpolation_bias.trials import facets
from chapters.ch03_planar_grids.s2_1_interpolation_bias.trials.active import (
    decoding_errors,
)
from chapters.ch03_planar_grids.s2_1_interpolation_bias.trials.scenes import (
    SETTINGS,
    rms,
)
from raxel.cameras.core.base import pixel_grid
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

HEIGHT_PX = {"quick": 60, "full": 360}


def ridge_trial(condition, rng):
    """Interpolation and decoding near the ridge of two mirrors, RMS in mm."""
    camera = facets.two_facets(condition["facet_deg"], condition["height_px"])
    T_camera_monitor = facets.monitor_pose(rng)
    corners = facets.chessboard_corners(camera, T_camera_monitor)
    errors, seen = decoding_errors(camera, facets.GRID, T_camera_monitor, rng)
    pixels, seen = (pixel_grid(camera.width, camera.height), seen.reshape(-1, 2))
    errors = {k: e.reshape(-1, 2).astype(float) for k, e in errors.items()}
    near = facets.ridge_distance(pixels) <= facets.square_px(corners)
    near &= np.isfinite(seen[:, 0])
    trusted = near & np.all([np.isfinite(e[:, 0]) for e in errors.values()], axis=0)
    pixels, seen = pixels[trusted], seen[trusted]
    own = camera.facet_of(pixels)
    errors = {k: e[trusted] for k, e in errors.items()} | {
        "unknown": facets.interpolated(pixels, corners) - seen,
        "known": facets.interpolated(pixels, corners, own) - seen,
    }
    column, of_column = np.unique(pixels[:, 0], return_inverse=True)
    found = {
        "jump_mm": facets.jump_mm(camera, T_camera_monitor),
        "trusted": float(trusted.sum() / near.sum()),
        "from_ridge_px": column - facets.RIDGE_PX,
    }
    for name, error in errors.items():
        size = np.linalg.norm(error, axis=1)
        found[name] = {
            "rms_mm": rms(error),
            "gross": float(np.mean(size > facets.GROSS_MM)),
            "by_column_mm": np.array(
                [rms(error[of_column == k]) for k in range(len(column))]
            ),
        }
    return found


@experiment("exp_c3_interp_discontinuous", artefact="sec_3_2_1")
def ridge(effort):
    """The camera of two facets."""
    stated = {"facet_deg": facets.FACET_DEG, "height_px": HEIGHT_PX[effort]}
    trials = {"quick": 1, "full": 8}[effort]
    return Plan(ridge_trial, [stated], trials, SETTINGS)
