"""What the claims of 5.3.4 say of one seed, and what is measured there.

Each takes the `CircleRuns` of a bench and gives whether it is true (seeds,), what was
measured (seeds,), its unit, and words. A seed that was rejected before the last stage
has no value.
"""

from itertools import combinations

import numpy as np

from chapters.ch05_flexible_mirror.s3_4_distortion.results.runs import STAGES
from chapters.ch05_flexible_mirror.s3_4_distortion.trials.target import RADIUS_MM

MOST_RADIUS = 1.5  # %
MOST_ALIKE = 0.3
MOST_LEFT = 0.2
FEWEST_SHARED = 20  # places that two profiles have in common


def words_of(values):
    """Median of the seeds that have a value, as words: "nothing" without any."""
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
        np.all(off <= MOST_RADIUS, axis=0),
        off.max(axis=0),
        "%",
        f"largest error of the four stages; by stage {_by_stage(off)} %; rays are "
        f"{_by_stage(runs.at('angle_deg'))} degrees off",
    )


def conic_departs(runs):
    """In the picture the circle is farther from a conic at each further stage."""
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
    """Pearson's, of the places (N,) that both have; nan for too few."""
    both = np.isfinite(first) & np.isfinite(second)
    if np.count_nonzero(both) < FEWEST_SHARED:
        return np.nan
    return float(np.corrcoef(first[both], second[both])[0, 1])


def no_common_error(runs):
    """Residuals around the circle are not alike at different stages."""
    found = alike(runs)
    return (
        found < MOST_ALIKE,
        found,
        "",
        "mean correlation of the residuals around the circle, all pairs of stages",
    )


def face_left(runs, camera="calibrated"):
    """What is left (seeds,) of a face's distortion, over that of the picture."""
    return runs.face("corrected_px", camera) / runs.face("raw_px", camera)


def face_corrected(runs):
    """A fifth at most of the distortion of a face is left."""
    found = face_left(runs)
    return (
        found <= MOST_LEFT,
        found,
        "",
        f"left over raw; with the true mirror {words_of(face_left(runs, 'true'))}",
    )
