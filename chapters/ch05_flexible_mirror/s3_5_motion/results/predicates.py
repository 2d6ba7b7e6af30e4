"""Claims about the moving cylinder, for single runs and for all.

Fixed before the first run, where the registered test is not specific: a translation is
that of the point closest to all rays, of motions whose mean step is scaled to 25 mm, as
in Table 5.7; the cylinder has the same scale. A marker meets the scaled cylinder if its
centre is within 3 mm; a mark that is not found misses it. Changed later: claims are
judged on completed runs, and rejected ones are reported.
"""

import numpy as np
from scipy.stats import rankdata

from chapters.ch05_flexible_mirror.s3_5_motion.results.runs import (
    CAMERA,
    EACH_STEP,
    LAST,
    STAGES,
)
from chapters.ch05_flexible_mirror.s3_5_motion.trials.scene import RADIUS_MM, STEP_MM
from chapters.shared.mirror_bench import SWEPT
from chapters.shared.mirror_rigs import STAGES_MM
from repro.judge.statistics import all_of, bootstrap, median_interval
from repro.run.outcomes import Reading

MAX_STEP_ERROR, MAX_END_MM = 0.05, 8.0
MAX_SCALED, MAX_UNSCALED = 0.10, 0.20
MAX_N_MISSED = 1
MAX_TREND = -0.8
MAX_SCALE_ERROR = 0.10
# Factor of a length that diverges or vanishes.
MAX_FACTOR = 100.0


def middle(values):
    """Median of the runs that have a value, as words; "nothing" without any."""
    known = values[np.isfinite(values)]
    return f"{np.median(known):.3g}" if len(known) else "nothing"


def follows(runs, camera=CAMERA):
    """Every magnitude is within 5 %, and the final position within 8 mm."""
    true = STEP_MM * np.array(EACH_STEP)
    off = np.abs(runs.steps("length_mm", camera) / true[:, None] - 1)
    end = runs.steps("off_mm", camera)[-1]
    return (
        np.all(off <= MAX_STEP_ERROR, axis=0) & (end <= MAX_END_MM),
        end,
        "mm",
        f"last shift off; magnitudes off by {middle(100 * off.max(axis=0))} % at most; "
        "with each length given "
        f"{middle(runs.steps('off_mm', camera, 'given')[-1])} mm",
    )


def radius_found(runs):
    """The scaled radius is within 10 %, the unscaled one within 20 %."""
    scaled, own = (runs.of(n) / RADIUS_MM - 1 for n in ("scaled_mm", "radius_mm"))
    return (
        (np.abs(scaled) <= MAX_SCALED) & (np.abs(own) <= MAX_UNSCALED),
        100 * np.abs(scaled),
        "%",
        f"scaled radius off; unscaled {middle(100 * np.abs(own))} %; with each length "
        f"given {middle(runs.of('radius_mm', way='given'))} mm of {RADIUS_MM:g} mm",
    )


def missed(runs, seeds):
    """Estimate of the median number of markers that miss the cylinder, of some runs.

    A run without a cylinder counts as the worst.
    """
    return median_interval(runs.of("missed")[seeds])


def mostly_meet(runs, seeds):
    """Whether all markers but one meet the cylinder in the median of some runs."""
    # Whole numbers: between one that may miss and two.
    return missed(runs, seeds).value < MAX_N_MISSED + 0.5


def markers_meet(runs, seeds):
    """Reading: all markers but one meet the cylinder, median over some runs."""
    found = missed(runs, seeds)
    return Reading.of(
        found.below(MAX_N_MISSED + 0.5),
        found,
        "",
        f"median number of markers that miss; distances of {middle(runs.of('fit_mm'))} "
        "mm on the mean",
    )


def log_scales(runs):
    """Logarithms (4, seeds) of mean steps over the true one, at all stages."""
    found = np.array([runs.scales(stage) for stage in STAGES])
    worst = np.where(np.isfinite(found), found, MAX_FACTOR)
    return np.log(np.clip(worst, 1 / MAX_FACTOR, MAX_FACTOR))


def fall(*logs):
    """Spearman's correlation (...) of deflection with the SD of log scales (..., n);
    0 where all scatter alike, as single runs do."""
    sd = np.stack([np.std(one, axis=-1) for one in logs], axis=-1)
    x, y = rankdata(STAGES_MM), rankdata(sd, axis=-1)
    x, y = x - x.mean(), y - y.mean(axis=-1, keepdims=True)
    size = np.linalg.norm(x) * np.linalg.norm(y, axis=-1)
    return (y @ x) / np.where(size > 0, size, 1.0)


def scale_tells(runs, seeds):
    """Reading: scatter of the scale falls with deflection; the scale ends correct.

    The median at the largest deflection is that of the mean steps of some runs.
    """
    logs = log_scales(runs)[:, seeds]
    falls = bootstrap(fall, *logs, paired=True)
    last = median_interval(np.exp(logs[LAST]))
    sds = ", ".join(f"{sd:.2g}" for sd in logs.std(axis=1))
    return Reading.of(
        all_of(
            [
                falls.below(np.nextafter(MAX_TREND, 1)),
                last.within(1 - MAX_SCALE_ERROR, 1 + MAX_SCALE_ERROR),
            ]
        ),
        falls,
        "",
        f"rank correlation of deflection with the SD of log scale, which is {sds} at "
        f"stages 0 to 3; median scale at stage 3 {last.value:.3g} ({last.low:.3g} to "
        f"{last.high:.3g})",
    )


def scaled(runs, bench):
    """Which runs (seeds,) have a scale: at all stages, in a sweep at the last."""
    stages = (LAST,) if bench in SWEPT else STAGES
    return np.isfinite([runs.scales(stage) for stage in stages]).all(axis=0)


def scale_right(runs, seeds):
    """Whether the median scale of some runs at the largest deflection is correct."""
    scale = np.exp(log_scales(runs)[LAST][seeds])
    return bool(abs(np.median(scale) - 1) <= MAX_SCALE_ERROR)
