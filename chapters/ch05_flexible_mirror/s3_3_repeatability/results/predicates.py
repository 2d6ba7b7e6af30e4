"""Quantities of each run out and back, and the bounds of the claims."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_repeatability.results.runs import (
    BACK,
    EQUIVALENT,
    STEPS,
    THERE,
)
from chapters.ch05_flexible_mirror.s3_3_repeatability.trials.run import LOOP
from chapters.shared.mirror_rigs import STAGES_MM
from repro.judge.statistics import OVER_TRIALS, bootstrap, with_worst

MAX_APART, MAX_OPEN_MM = 6.0, 0.3
MAX_DIFFERENT, MAX_GROWTH = 1.0, 5.0
MAX_WORSE = 1.2
MIN_SD_MM, MIN_REDUCTION = 0.05, 20.0
MAX_SD = 1.0
median = OVER_TRIALS["median"]


def disagreement(runs):
    """Largest difference of equivalent steps, %, (seeds,)."""
    found = []
    for pair in EQUIVALENT:
        both = runs.at("deflection_mm", pair)
        found.append(100 * (both.max(axis=0) / both.min(axis=0) - 1))
    return np.max(found, axis=0)


def loop_error(runs):
    """All steps out less all steps back, mm, (seeds,), without sign."""
    out, back = (runs.at("deflection_mm", steps).sum(axis=0) for steps in (THERE, BACK))
    return np.abs(out - back)


def single_difference(runs):
    """Difference of the single step from the three back, %, (seeds,), without sign."""
    staged = runs.at("deflection_mm", BACK).sum(axis=0)
    return 100 * np.abs(runs.of("single", "deflection_mm") / staged - 1)


def height_errors(runs):
    """Error of the load's height after each step, mm, (steps, seeds), signed.

    The height is the estimate of stage 0 with all steps added.
    """
    signs = np.where(np.isin(STEPS, THERE), 1.0, -1.0)[:, None]
    found = np.cumsum(signs * runs.at("deflection_mm"), axis=0)
    true = np.array([STAGES_MM[LOOP[step]] for step in STEPS])
    return found - true[:, None]


def steps_agree(runs):
    """Test that equivalent steps agree within 6 %."""
    apart = disagreement(runs)
    return (apart <= MAX_APART, apart, "%", "largest difference of equivalent steps")


def loop_closes(runs):
    """Test that the sums out and back agree within 0.3 mm."""
    off = loop_error(runs)
    return (off <= MAX_OPEN_MM, off, "mm", "sum of the steps out less that back")


def error_growth(runs, name="back_mm", seeds=slice(None)):
    """Slope of the back-projection error on the step's number, % of the fitted line's
    value at the first step, Estimate; a draw is one of whole sequences. seeds: (seeds,)
    those that count, a rejected one as the worst."""
    trials = [with_worst(row[seeds]) for row in runs.at(name)]
    x = np.arange(len(trials)) - np.mean(np.arange(len(trials)))

    def slope(*rows):
        y = np.stack([median(row) for row in rows])
        rise = np.tensordot(x, y, 1) / (x @ x)
        return 100 * rise / (y.mean(axis=0) + x[0] * rise)

    return bootstrap(slope, *trials, paired=True)


def loop_ratio(after, before):
    """Ratio of the medians of two measures of the same runs, Estimate."""
    return bootstrap(
        lambda a, b: median(a) / median(b),
        with_worst(after),
        with_worst(before),
        paired=True,
    )


def in_places(result, bench, pitch):
    """Deflections (seeds, places) mm of one pitch, nan where rejected."""
    return np.array(result.arrays(f"{bench}.{pitch}"))


def between_places(*found):
    """SD of deflections between places, mm, (seeds,) for each array (seeds, places).

    Of the places in which none was rejected; nan where fewer than two are left.
    """
    known = np.all(np.isfinite(found), axis=0)
    enough = known.sum(axis=1) > 1
    spread = np.full((len(found), len(known)), np.nan)
    for row, mm in zip(spread, found, strict=True):
        row[enough] = np.nanstd(np.where(known, mm, np.nan)[enough], axis=1, ddof=1)
    return spread


def pooled_sd(result, bench, pitch="coarse"):
    """SD between places over all runs, mm, Estimate; runs are resampled."""
    (spread,) = between_places(in_places(result, bench, pitch))
    return bootstrap(_rms, spread[np.isfinite(spread)])


def reduction(result, bench):
    """Reduction of the SD between places by half the pitch, %, Estimate."""
    coarse, dense = between_places(
        *(in_places(result, bench, pitch) for pitch in ("coarse", "dense"))
    )
    known = np.isfinite(coarse)
    return bootstrap(
        lambda a, b: 100 * (1 - _rms(b) / _rms(a)),
        coarse[known],
        dense[known],
        paired=True,
    )


def _rms(spread):
    return np.sqrt(np.mean(spread**2, axis=-1))


def scatter_of_starts(result, bench, step, step_mm):
    """SD (seeds,) of the results of perturbed starts, % of the deflection; nan where a
    start or the whole stage was rejected."""
    return 100 * result.column(f"{bench}.{step}.sd_mm") / step_mm
