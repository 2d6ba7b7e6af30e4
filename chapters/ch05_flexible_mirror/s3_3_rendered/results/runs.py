"""What the rendered runs gave, beside the runs whose errors are drawn."""

import numpy as np

from chapters.shared.mirror_rigs import STAGES_MM

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
OF_ONE_WAY = ("published", "aimed", "own")
CALLED = {
    "angle_deg": "angle_deg",
    "residual_mm": "residual_mm",
    "back_own_mm": "back_mm",
    "back_true_mm": "back_true_mm",
}


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


def refusals(trials):
    """Way -> how many runs were refused, in all or by that way."""
    whole = trials.texts("refused")
    return {
        way: sum(
            one is not None or every is not None
            for one, every in zip(trials.texts(f"{way}.refused"), whole, strict=True)
        )
        for way in OF_ONE_WAY
    }


def any_refused(trials):
    """How many runs were refused, in all or by one way or more."""
    texts = [
        trials.texts(name)
        for name in ("refused", *(f"{way}.refused" for way in OF_ONE_WAY))
    ]
    return sum(any(run) for run in zip(*texts, strict=True))


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
