"""The numbers that the page's prose quotes."""

from itertools import product

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_rendered.results.aims import (
    RUN_WITH_PICTURES,
    held,
)
from chapters.ch05_flexible_mirror.s3_3_rendered.results.loop import (
    LOOP,
    LOOP_DRAWN,
    LOOP_QUOTED,
    loop_drawn,
    loop_from_pictures,
    loop_refusals,
)
from chapters.ch05_flexible_mirror.s3_3_rendered.results.runs import (
    DRAWN,
    LABORATORY,
    RENDERED,
    any_refused,
    cases,
    drawn_value,
    refusals,
    runs_of,
)
from chapters.shared.mirror_bench import BENCH
from repro.judge.statistics import median_interval
from repro.page.reader import value
from repro.page.wording import rounded

# Of each rig and bench, in the prose.
QUOTED = (
    "published.stage1.angle_deg",
    "published.stage3.angle_deg",
    "published.stage3.residual_mm",
    "published.stage3.back_own_mm",
    "published.stage3.back_true_mm",
    "aimed.stage1.angle_deg",
    "aimed.stage3.angle_deg",
    "aimed.stage3.deflection_percent",
    "aimed.bundle.stage3.angle_deg",
    "aimed.stage0.miss_mm",
    "aimed.stage0.separation_mm",
    "aimed.stage0.separation_deg",
    "own.stage3.angle_deg",
    "own.stage3.reach_percent",
)


def name_values(open_results):
    """Name the numbers of the prose."""
    runs = {name: open_results(name) for name in RUN_WITH_PICTURES}
    many = {name: open_results(name) for name in (*DRAWN, *LOOP_DRAWN.values())}
    quoted = of_rendered(runs[RENDERED]) | of_aims(runs)
    quoted |= of_drawn(many) | of_loop(runs | many)
    for name, number in quoted.items():
        value(name, number)


def of_rendered(result):
    """Name -> what prose quotes of the rendered runs: medians, and ranges where there
    are several."""
    every = result.select()
    found = {
        "runs": len(result.conditions) * result.trials_per_condition,
        "corner_px": in_words(every.column("corner_px")),
        "corners": int(np.nansum(every.column("corners"))),
        "false": int(np.nansum(every.column("false"))),
        "lost": int(np.nansum(every.column("lost"))),
        "refused": sum(any_refused(trials) for *_, trials in cases(result)),
    }
    for geometry in "AB":
        for bench in (BENCH, LABORATORY):
            trials = runs_of(result, geometry, bench)
            lost = refusals(trials)["published"] if trials else "(no number)"
            found[f"{geometry}.{bench}.refused"] = lost
            for name in QUOTED:
                values = trials.column(name) if trials else np.zeros(0)
                found[f"{geometry}.{bench}.{name}"] = in_words(values)
    return found


def of_aims(results):
    """Name -> how many aims runs on A and B meet, and how many there are."""
    found = {}
    for geometry, bench in product("AB", (BENCH, LABORATORY)):
        met, asked = held(results, geometry, bench)
        words = f"{met} of {asked}" if asked else "(no number)"
        found[f"{geometry}.{bench}.met"] = words
    return found


def of_drawn(results):
    """Name -> medians of ray angles with drawn errors, with intervals."""
    return {
        f"drawn.{geometry}.{bench}.{way}.stage{stage}": in_words_of_many(
            drawn_value(results, way, geometry, bench, stage, "angle_deg")
        )
        for geometry in "AB"
        for bench in (BENCH, LABORATORY)
        for way in ("published", "aimed", "aimed.bundle")
        for stage in (1, 3)
    }


def of_loop(results):
    """Name -> what prose quotes of the loop: medians, beside those of many seeds."""
    result, found = results[LOOP], {}
    found["loop.runs"] = len(result.conditions) * result.trials_per_condition
    for way in ("published", "aimed"):
        found[f"loop.refused.{way}"] = loop_refusals(result.select(), way)[1]
        for geometry, bench in product("AB", (BENCH, LABORATORY)):
            trials = runs_of(result, geometry, bench)
            many = loop_drawn(results, way, geometry, bench)
            place = f"loop.{geometry}.{bench}.{way}"
            for name, measure in LOOP_QUOTED.items():
                runs = measure(loop_from_pictures(trials, way)) if trials else None
                found[f"{place}.{name}"] = (
                    "(no number)" if runs is None else in_words(runs)
                )
                drawn_runs = None if many is None else measure(many)
                found[f"drawn.{place}.{name}"] = in_words_of_many(drawn_runs)
    return found


def in_words(values):
    """The median of some runs, and their range where they are several, for a sentence;
    those that were refused before do not count."""
    known = values[np.isfinite(values)]
    if not len(known):
        return "(no number)"
    ends = (float(known.min()), float(known.max())) if len(known) > 1 else None
    return rounded(float(np.median(known)), ends)


def in_words_of_many(values):
    """The median of many seeds with its interval, for a sentence."""
    if values is None:
        return "(no number)"
    found = median_interval(values)
    if not np.isfinite(found.value):
        return "(no number)"
    ends = found.low, found.high
    return rounded(found.value, ends if np.isfinite(ends).all() else None)
