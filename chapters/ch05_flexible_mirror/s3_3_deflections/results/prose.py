"""The numbers that the page quotes: medians over the seeds that came so far."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_deflections.results.geometry import (
    by_formula,
    camera_mm,
    depth_for,
)
from chapters.ch05_flexible_mirror.s3_3_deflections.results.predicates import (
    angles_by_place,
    deflection_errors,
    deflections_found,
    linear_ratios,
)
from chapters.ch05_flexible_mirror.s3_3_deflections.results.predicates import (
    middle as words,
)
from chapters.ch05_flexible_mirror.s3_3_deflections.results.runs import (
    DEFLECTED,
    LAST,
    OTHER,
    RENDERED,
    RUNS,
    SHIFT_MM,
    STAGES,
    TIPS,
    Runs,
)
from chapters.ch05_flexible_mirror.s3_3_deflections.results.tips import (
    Tips,
    among_sd,
    tip_sd,
)
from chapters.shared.mirror_bench import LEVEL
from raxel.calibration.mirror.edges import SWINGING_DEG
from repro.judge.statistics import median_and_range
from repro.page.reader import value

MEASURES = {
    "angle": "angle_deg",
    "measured": "measured_deg",
    "back": "back_mm",
    "true": "back_true_mm",
}


def middle(found):
    """Median of the trials that have a value, nan without any."""
    return median_and_range(found).value


def name_values(open_results):
    """Name the numbers of the prose."""
    results = {name: open_results(name) for name in (RUNS, OTHER)}
    bench, of_b = Runs(results), Runs(results, geometry="B")
    quoted = quoted_of(bench) | {
        "lab.refused": refusals(Runs(results, bench="laboratory")),
        "b.refused": refusals(of_b),
        "b.seeds": of_b.seeds,
        # Words, since a few seeds may all be refused there.
        "b.angle.3": words(of_b.of(LAST, "angle_deg")),
        "camera": camera_mm(),
        "formula": by_formula(),
        "depth.low": depth_for(0.54),
        "depth.high": depth_for(0.65),
    }
    quoted |= quoted_of_tips(Tips.on({TIPS: open_results(TIPS)}, LEVEL))
    quoted |= quoted_of_pictures(open_results(RENDERED))
    for name, number in quoted.items():
        value(name, number)


def quoted_of(runs):
    """{name: number} of the runs on the bench."""
    found = {
        f"{short}.{stage}": middle(runs.of(stage, name))
        for short, name in MEASURES.items()
        for stage in (0, 1, LAST)
    }
    ratios, off = linear_ratios(runs), deflection_errors(runs)
    for stage, ratio in zip(DEFLECTED, ratios, strict=True):
        found[f"linear.{stage}"] = middle(ratio)
    clamped, _, free = angles_by_place(runs)[:, LAST]
    shift = np.abs(runs.at("shift_mm", STAGES) - SHIFT_MM)
    return found | {
        "linear.most": float(np.nanmax(ratios)),
        "worst": middle(np.abs(off).max(axis=0)),
        "share.deflections": share(*deflections_found(runs)[:2]),
        "left": middle(runs.of(LAST, "back_mm") / runs.of(LAST, "stale_mm")),
        "clamped": middle(clamped),
        "free": middle(free),
        "shift.most": middle(shift.max(axis=0)),
        "turn.most": middle(runs.at("turn_deg", STAGES).max(axis=0)),
        "refused": refusals(runs),
        "swinging": swings(runs),
        "seeds": runs.seeds,
    }


def share(holds, found):
    """Of the completed runs, those in which a claim is true, %; nan without any."""
    done = ~np.isnan(found)
    return 100 * float(np.mean(holds[done])) if done.any() else np.nan


def quoted_of_tips(tips):
    """{name: number} about where the deflection scatters."""
    tip, mean, square = tips.moments()
    return {
        "tip.load": 1000 * float(tip_sd(tip)),
        "tip.among": 1000 * float(among_sd(mean, square)),
        "tip.beyond": middle(tips.of("beyond_mm")),
        "tip.ratio": tips.ratio().value,
        "tip.surface": tips.ratio(of_surface=True).value,
    }


def quoted_of_pictures(result):
    """{name: number} of the corners that were found in pictures."""
    every = result.select()
    return {
        "pictures.runs": len(result.conditions) * result.trials_per_condition,
        "pictures.corner_px": middle(every.column("corner_px")),
        "pictures.false": int(np.nansum(every.column("false"))),
    }


def refusals(runs):
    """How many seeds ended early."""
    return sum(code is not None for code in runs.refused())


def swings(runs):
    """How many completed seeds have a stage whose spline swings at an end."""
    most = runs.at("swing_deg").max(axis=0)
    return int(np.count_nonzero(most >= SWINGING_DEG))
