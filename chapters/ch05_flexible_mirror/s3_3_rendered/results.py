"""What the rendered runs gave, beside the runs whose errors are drawn."""

from typing import NamedTuple

import numpy as np

from chapters.shared.mirror_bench import BENCH
from chapters.shared.mirror_rigs import STAGES_MM
from repro.judge.statistics import median_interval, with_worst
from repro.page.reader import value
from repro.page.wording import rounded

RENDERED = "table_5_1_rendered"
# Runs of many seeds, as published and as aimed at.
PUBLISHED = {"A": "table_5_1_runs", "B": "table_5_1_other"}
AIMED = "ext_mirror_trust_runs"
DRAWN = ("table_5_1_runs", "table_5_1_other", "ext_mirror_trust_runs")
STAGES = tuple(range(1, len(STAGES_MM)))
LABORATORY = "laboratory"
# Our ways, and what the runs of many seeds call the same measures as published.
WAYS = {
    "published": "as published",
    "aimed": "as aimed at, stage by stage",
    "aimed.bundle": "as aimed at, all stages at once",
    "own": "as a reader's own set",
}
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
CALLED = {
    "angle_deg": "angle_deg",
    "residual_mm": "residual_mm",
    "back_own_mm": "back_mm",
    "back_true_mm": "back_true_mm",
}


class Aim(NamedTuple):
    """bound: twice the target; names: values of a way, of which the largest counts;
    drawn: what `ext_mirror_trust_runs` calls them."""

    words: str
    bound: float
    unit: str
    names: tuple
    drawn: tuple


def _alike(words, bound, unit, names):
    return Aim(words, bound, unit, names, tuple(f"prior.{name}" for name in names))


def _every(name):
    return tuple(f"stage{k}.{name}" for k in STAGES)


AIMS = (
    *(
        _alike(f"Deflection, stage {k}", bound, "%", (f"stage{k}.deflection_percent",))
        for k, bound in zip(STAGES, (1.0, 2.0, 3.0), strict=True)
    ),
    *(
        _alike(f"Mean ray angle, stage {k}", bound, "degrees", (f"stage{k}.angle_deg",))
        for k, bound in zip(STAGES, (0.08, 0.16, 0.28), strict=True)
    ),
    _alike(
        "Mean ray angle, stage 3, after the bundle",
        0.18,
        "degrees",
        ("bundle.stage3.angle_deg",),
    ),
    _alike("Residual, worst stage", 0.4, "mm", _every("residual_mm")),
    _alike("Back-projection, own pose, worst stage", 1.2, "mm", _every("back_own_mm")),
    _alike(
        "Back-projection, true pose, worst stage", 2.2, "mm", _every("back_true_mm")
    ),
    Aim("Grid separation", 0.1, "mm", ("stage0.separation_mm",), ("separation_mm",)),
    Aim("Grid rotation", 0.04, "degrees", ("stage0.separation_deg",),
        ("separation_deg",)),
)  # fmt: skip


def runs_of(result, geometry, bench):
    """The trials of one rig and bench, or None where the plan has none."""
    if {"geometry": geometry, "bench": bench} not in [
        {k: c[k] for k in ("geometry", "bench")} for c in result.conditions
    ]:
        return None
    return result.select(geometry=geometry, bench=bench)


def cases(result):
    """(geometry, bench, trials) of the plan, in its order."""
    pairs = dict.fromkeys((c["geometry"], c["bench"]) for c in result.conditions)
    return [(*pair, result.select(geometry=pair[0], bench=pair[1])) for pair in pairs]


def measured(trials, aim):
    """Values (runs,) of an Aim, infinite where a run gave none."""
    found = [with_worst(trials.column(f"aimed.{name}")) for name in aim.names]
    return np.max(found, axis=0)


def drawn(result, aim, geometry):
    """The same of the seeds of `ext_mirror_trust_runs`, on smooth mirrors."""
    trials = result.select(geometry=geometry, aberration_um=0.0)
    found = [with_worst(trials.column(name)) for name in aim.drawn]
    return np.max(found, axis=0)


def refusals(trials):
    """Way -> how many runs were refused, in all or by that way."""
    whole = trials.texts("refused")
    return {
        way: sum(
            one is not None or every is not None
            for one, every in zip(trials.texts(f"{way}.refused"), whole, strict=True)
        )
        for way in ("published", "aimed", "own")
    }


def drawn_value(results, way, geometry, bench, stage, name):
    """Values (seeds,) of a measure in the runs of many seeds; None where they have no
    such way or bench."""
    if way == "published":
        result = results[PUBLISHED[geometry]]
        return result.column(f"{bench}.stage{stage}.{CALLED[name]}", geometry=geometry)
    prefix = {"aimed": "prior", "aimed.bundle": "prior.bundle"}.get(way)
    if prefix is None or bench != LABORATORY:
        return None
    trials = results[AIMED].select(geometry=geometry, aberration_um=0.0)
    found = trials.column(f"{prefix}.stage{stage}.{name}")
    return found if np.isfinite(found).any() else None


def name_values(open_results):
    """Name the numbers of the prose."""
    quoted = of_rendered(open_results(RENDERED)) | of_drawn(
        {name: open_results(name) for name in DRAWN}
    )
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
        "refused": sum(max(refusals(trials).values()) for *_, trials in cases(result)),
        "aims": len(AIMS),
    }
    for geometry in "AB":
        for bench in (BENCH, LABORATORY):
            trials = runs_of(result, geometry, bench)
            found[f"{geometry}.{bench}.met"] = met(trials)
            lost = refusals(trials)["published"] if trials else "(no number)"
            found[f"{geometry}.{bench}.refused"] = lost
            for name in QUOTED:
                values = trials.column(name) if trials else np.zeros(0)
                found[f"{geometry}.{bench}.{name}"] = in_words(values)
    return found


def met(trials):
    """How many aims the median of some runs meets; a word where there is no run."""
    if trials is None:
        return "(no number)"
    return sum(bool(np.median(measured(trials, aim)) < aim.bound) for aim in AIMS)


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
