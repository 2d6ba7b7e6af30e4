"""How large CGSP's ray-point errors are when decoding errors are multiplied.

No other method is run here. From this the factor of the bench's noise is solved, with
the one printed number that it may see (settings.yaml, decoding_noise).
"""

import numpy as np

from chapters.ch04_central_generic.s3_2_results.trials.drawn import STEPS, drawn_grids
from chapters.shared.bench_noise import NOISES
from chapters.shared.central_sets import OMNI, RIGS, SMALL, shared_rays
from raxel.calibration import centroid_directions, linear_cgsp, ray_point_distances
from raxel.errors import CalibrationError
from raxel.geometry import on_plane, transform

SEEDS = {"quick": 3, "full": 36}
MULTIPLIED = (1.0, 2.0, 4.0, 8.0)


def cgsp_trial(condition, rng, errors):
    """Mean ray-point error (mm) of CGSP as it comes out.

    mean_mm: for each of MULTIPLIED; chosen_mm: for the factor that was solved.
    """
    rig, noise = condition["rig"], NOISES[condition["noise"]]
    grids = drawn_grids(rig, condition["step"], rng, errors[rig])

    def mean(factor):
        errors_times = noise._replace(factor=factor)
        return mean_error(errors_times.points(grids.decoded, grids.true, rng), rng)

    return {
        "mean_mm": np.array([mean(factor) for factor in MULTIPLIED]),
        "chosen_mm": mean(noise.factor),
    }


def mean_error(points, rng):
    """Mean ray-point error of points (3, N, 2); NaN where CGSP gives nothing."""
    try:
        rays = shared_rays(points, 1, rng)
        found = linear_cgsp(rays.points, side=-1)
    except CalibrationError:
        return np.nan
    seen = np.ones(rays.points.shape[:2], bool)
    directions = centroid_directions(rays.points, seen, found.centre, found.T_base_grid)
    placed = transform(found.T_base_grid, on_plane(rays.points))
    return ray_point_distances(placed, found.centre, directions).mean()


def cgsp_conditions(effort):
    """The mirror camera, with errors as they come and with those of other pixels."""
    rig, step = RIGS[OMNI] + SMALL[effort], STEPS[effort]
    return [{"rig": rig, "step": step, "noise": noise} for noise in ("bench", "white")]


def solved(result, target_mm, noise):
    """The factor at which the median over seeds is target_mm, None where none is.

    Between the factors that were run, medians go as powers of the factor.
    """
    means = np.array(result.arrays("mean_mm", noise=noise))
    medians = np.nanmedian(means, axis=0)
    if not medians[0] <= target_mm <= medians[-1]:
        return None
    logs = np.interp(np.log(target_mm), np.log(medians), np.log(MULTIPLIED))
    return float(np.exp(logs))
