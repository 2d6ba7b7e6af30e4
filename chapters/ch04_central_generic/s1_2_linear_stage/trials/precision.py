"""Single and double precision in the SVD of a homography of 20 000 pairs."""

import numpy as np

from chapters.ch04_central_generic.s1_2_linear_stage.trials.minimal import equations
from chapters.shared.wide_angle import SETTINGS, draw_scene, radial_lens
from raxel.geometry import apply_homography
from raxel.geometry.homography import normalising
from repro.run.experiment import experiment
from repro.run.outcomes import Plan, crossed

PAIRS = 20_000
NOISE_PX = 0.5
TRIALS = {"quick": 3, "full": 50}


def homography_in(precision, source, target, normalised):
    """H (3, 3) by the SVD of all equations, in one precision throughout."""
    T_s = T_t = np.eye(3)
    if normalised:
        T_s, T_t = normalising(source), normalising(target)
    rows = equations(source, target, T_s, T_t).astype(precision)
    right = np.linalg.svd(rows, full_matrices=False)[2]
    H = right[8].reshape(3, 3).astype(float)
    return np.linalg.solve(T_t, H @ T_s)


def precision_trial(condition, rng):
    """RMS residuals (mm) of single and double precision, and true errors."""
    seen = draw_scene(radial_lens(), condition["noise_px"], rng, grids=2, rays=PAIRS)
    base, own = seen.noisy
    out = {}
    for name, precision in (("single", np.float32), ("double", np.float64)):
        H = homography_in(precision, own, base, condition["normalised"])
        gaps = apply_homography(H, own) - base
        true = apply_homography(H, seen.points[1]) - seen.points[0]
        for what, gap in (("residual", gaps), ("error", true)):
            out[f"{name}_{what}_mm"] = float(np.sqrt(np.mean(np.sum(gap**2, axis=1))))
    return out


@experiment("exp_c4_svd_precision", artefact="ext_svd_precision", shards={"full": 2})
def precisions(effort):
    """20 000 pairs, exact and with noise, normalised and as they come."""
    conditions = crossed(noise_px=(NOISE_PX, 0.0), normalised=(True, False))
    settings = SETTINGS | {"rays_per_trial": PAIRS}
    return Plan(precision_trial, conditions, TRIALS[effort], settings)
