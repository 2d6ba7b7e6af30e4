"""Calibrations of section 4.3.2: from pictures, and from errors drawn again.

Each seed is calibrated with the laboratory's decoding errors, and with errors as large
as the bench's.
"""

import numpy as np

from chapters.ch04_central_generic.s3_2_results.trials.drawn import STEPS, drawn_grids
from chapters.shared.active_grid_sets import seen_grids, true_camera
from chapters.shared.bench_noise import BENCH, NOISES, SWEPT_NOISES
from chapters.shared.central_sets import (
    LINEAR_GRIDS,
    RIGS,
    SEEDS,
    SMALL,
    first_points_and_truth,
    shared_rays,
    true_grids,
    true_grids_of_set,
)
from chapters.shared.decoding_errors import lattice_rays, measured_errors
from chapters.shared.methods import LINEAR_STAGES
from chapters.shared.rigs import rig_named
from chapters.shared.three_grids import calibrated, parameters
from repro.run.rendered import rendered_set

TRIALS = {"quick": 3, "full": 50}
DRAWN = 3000  # points of a scatter that are drawn
# The sweep of the factor is run for the primary readings.
SWEPT_METHODS = ("as_printed", "cgsp")


def rendered_trial(condition, rng):
    """A rendered set decoded and calibrated by every method, and its true numbers."""
    folder = rendered_set(condition["rig"], condition["seed"])
    decoded, true_points = first_points_and_truth(folder)
    width = true_camera(folder).width
    out = {}
    for name, noise in NOISES.items():
        points = noise.points(decoded, true_points, rng)
        rays = shared_rays(points, width, rng)
        true = true_grids_of_set(folder, rays.pixels)
        found = calibrated(rays.points, true)
        for method in found.values():
            crossing = method.pop("crossing", None)
            if crossing is not None and name == BENCH:
                method["crossing"] = crossing[:: max(1, len(crossing) // DRAWN)]
        out[name] = found | _of_rays(rays, true)
    return out


def _of_rays(rays, true):
    """How many rays there were, and what is true of them."""
    return {
        "true": parameters(true.centre, true.T_base_grid),
        "true_scatter_mm": true.scatter_mm,
        "rays": rays.found,
        "used": len(rays.pixels),
        "left_out": rays.left_out,
    }


def errors_trial(condition, rng):
    """The DecodingErrors of all rendered sets of a rig, as arrays."""
    folders = [rendered_set(condition["rig"], seed) for seed in condition["seeds"]]
    rays, shape = lattice_rays(true_camera(folders[0]), 1)
    found = measured_errors(
        (grid, (rays.directions @ grid.T_camera_grid[:3, 2]).reshape(shape))
        for folder in folders
        for grid in seen_grids(folder, count=LINEAR_GRIDS)
    )
    return {name: np.asarray(value) for name, value in found._asdict().items()} | {
        "share_of_outliers": found.outlier_share,
        "correlation": float(found.correlation_px.mean()),
        "stated_x": float(found.stated[0]),
        "stated_y": float(found.stated[1]),
        "bias_mm_rms": float(np.sqrt(np.mean(found.bias_mm**2))),
        "sd_mm_rms": float(np.sqrt(np.mean(found.sd_mm**2))),
    }


def errors_conditions(effort):
    """A condition for each rig whose errors are measured."""
    rigs = [rig + SMALL[effort] for rig in RIGS.values()]
    return [{"rig": rig, "seeds": list(SEEDS[effort])} for rig in rigs]


def redrawn_trial(condition, rng, errors):
    """Grids set up anew, decoding errors drawn again; as `rendered_trial`.

    The errors are drawn once, and made larger for the bench.
    """
    rig = condition["rig"]
    grids = drawn_grids(rig, condition["step"], rng, errors[rig])
    out = {}
    for name, noise in (NOISES | SWEPT_NOISES).items():
        methods = SWEPT_METHODS if name in SWEPT_NOISES else LINEAR_STAGES
        rays = shared_rays(noise.points(grids.decoded, grids.true, rng), 1, rng)
        chosen = grids.pixels[rays.pixels[:, 1].astype(int)]
        true = true_grids(rig_named(rig).camera, grids.T_camera_grid, chosen)
        found = calibrated(rays.points, true, methods=tuple(methods))
        for method in found.values():
            method.pop("crossing", None)  # only rendered sets are drawn
        out[name] = found | _of_rays(rays, true)
    return out


def redrawn_conditions(effort):
    """A condition for each camera."""
    return [
        {"camera": camera, "rig": rig + SMALL[effort], "step": STEPS[effort]}
        for camera, rig in RIGS.items()
    ]
