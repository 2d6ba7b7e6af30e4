"""Claims of 5.3.4 for single runs.

Each function takes the `CircleRuns` at an error level. It returns whether the claim
holds (seeds,), the measured value (seeds,), its unit, and words. A run that was
rejected before the last stage has no value.
"""

from itertools import combinations

import numpy as np

from chapters.ch05_flexible_mirror.s3_4_distortion.results.runs import STAGES
from chapters.ch05_flexible_mirror.s3_4_distortion.trials.target import RADIUS_MM

MAX_RADIUS_ERROR = 1.5  # %
MAX_CORRELATION = 0.3
MAX_REMAINDER = 0.2
MIN_N_SHARED = 20  # points that two profiles have in common


def words_of(values):
    """Median of the runs that have a value, as words; "nothing" without any."""
    known = values[np.isfinite(values)]
    return f"{np.median(known):.3g}" if len(known) else "nothing"


def _by_stage(values):
    return ", ".join(words_of(of_stage) for of_stage in values)


def radius_errors(runs, way="published"):
    """Errors (stages, seeds) of the circle's radius, %."""
    return 100 * (runs.at("radius_mm", way) / RADIUS_MM - 1)


def radii_agree(runs):
    """The radius is within 1.5 % at every stage."""
    off = np.abs(radius_errors(runs))
    return (
        np.all(off <= MAX_RADIUS_ERROR, axis=0),
        off.max(axis=0),
        "%",
        f"largest error of the four stages; by stage {_by_stage(off)} %; rays are "
        f"{_by_stage(runs.at('angle_deg'))} degrees off",
    )


def conic_departs(runs):
    """The distance from a conic in the image grows from stage to stage."""
    off = runs.at("conic_px", "picture")
    return (
        np.all(np.diff(off, axis=0) > 0, axis=0),
        off[-1] / off[0],
        "x",
        f"stage 3 over stage 0; by stage {_by_stage(off)} px; without the lens's "
        f"distortion {_by_stage(runs.at('conic_no_lens_px', 'picture'))} px",
    )


def alike(runs):
    """Mean correlation (seeds,) of the residuals around the circle of two stages."""
    profiles = [runs.profiles(stage) for stage in STAGES]
    return np.array(
        [
            np.mean(
                [
                    correlation(first[seed], second[seed])
                    for first, second in combinations(profiles, 2)
                ]
            )
            for seed in range(runs.seeds)
        ]
    )


def correlation(first, second):
    """Pearson correlation over the points (N,) that both have; nan for too few."""
    both = np.isfinite(first) & np.isfinite(second)
    if np.count_nonzero(both) < MIN_N_SHARED:
        return np.nan
    return float(np.corrcoef(first[both], second[both])[0, 1])


def no_common_error(runs):
    """Residuals around the circle do not correlate between stages."""
    found = alike(runs)
    return (
        found < MAX_CORRELATION,
        found,
        "",
        "mean correlation of the residuals around the circle, all pairs of stages",
    )


def face_left(runs, camera="calibrated"):
    """Remaining distortion (seeds,) of a face over that of the image."""
    return runs.face("corrected_px", camera) / runs.face("raw_px", camera)


def face_corrected(runs):
    """At most a fifth of the distortion of a face remains."""
    found = face_left(runs)
    return (
        found <= MAX_REMAINDER,
        found,
        "",
        f"left over raw; with the true mirror {words_of(face_left(runs, 'true'))}",
    )
