"""What the rendered runs gave, beside the runs whose errors are drawn."""

from functools import partial
from itertools import product
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


# Out, back and at a stroke: runs from pictures, and those of many seeds.
LOOP = "table_5_5_rendered"
LOOP_DRAWN = {"A": "table_5_5_runs", "B": "table_5_5_other"}
OUT = len(STAGES)
OUTWARD, BACK = tuple(range(1, OUT + 1)), tuple(range(OUT + 1, 2 * OUT + 1))
STEP_MM = STAGES_MM[1] - STAGES_MM[0]
PLACES = {
    "start": "before",
    f"step{OUT}": "after three steps",
    f"step{2 * OUT}": "after six",
    "single": "after the single step",
}
# Those at stage 0, where one board scores all.
AT_REST = ("start", f"step{2 * OUT}", "single")


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


class Loop(NamedTuple):
    """Runs there and back by one way. trials: of a Result; prefix: of the way's values;
    called: names of measures here -> in these trials, where they differ."""

    trials: object
    prefix: str
    called: dict

    def of(self, place, name):
        """A measure (runs,) at a place: "start", "step1" to "step6", or "single"."""
        name = self.called.get(name, name)
        return self.trials.column(f"{self.prefix}.{place}.{name}")

    def at(self, name, steps):
        """A measure (steps, runs) of several steps."""
        return np.array([self.of(f"step{step}", name) for step in steps])


def loop_from_pictures(trials, way):
    """The Loop of the rendered runs of a rig and bench."""
    return Loop(trials, way, {})


def loop_drawn(results, way, geometry, bench):
    """The Loop of many seeds with drawn errors; None but for the published way."""
    if way != "published":
        return None
    return Loop(results[LOOP_DRAWN[geometry]].select(geometry=geometry), bench, CALLED)


def steps_off(loop, steps):
    """Largest error of steps of 5 mm, % of it, (runs,)."""
    found = loop.at("deflection_mm", steps)
    return 100 * np.max(np.abs(found / STEP_MM - 1), axis=0)


def steps_apart(loop):
    """Largest difference of a step out from the one that undoes it, %, (runs,)."""
    both = loop.at("deflection_mm", OUTWARD), loop.at("deflection_mm", BACK[::-1])
    return 100 * np.max(np.maximum(*both) / np.minimum(*both) - 1, axis=0)


def loop_open(loop):
    """Sum of the steps out less that of the steps back, mm, (runs,), without sign."""
    out, back = (
        loop.at("deflection_mm", steps).sum(axis=0) for steps in (OUTWARD, BACK)
    )
    return np.abs(out - back)


def single_off(loop):
    """The single step against the sum of the steps back, %, (runs,), without sign."""
    staged = loop.at("deflection_mm", BACK).sum(axis=0)
    return 100 * np.abs(loop.of("single", "deflection_mm") / staged - 1)


# Words -> what a Loop has of it, (runs,).
LOOP_MEASURES = {
    "Largest error of a step out (%)": lambda loop: steps_off(loop, OUTWARD),
    "Largest error of a step back (%)": lambda loop: steps_off(loop, BACK),
    "Equivalent steps apart (%)": steps_apart,
    "Loop open by (mm)": loop_open,
    "Single step off the sum (%)": single_off,
    **{
        f"{words}, {PLACES[place]} ({unit})": partial(Loop.of, place=place, name=name)
        for words, unit, name, places in (
            ("Ray angle", "degrees", "angle_deg", PLACES),
            ("Own pose", "mm", "back_own_mm", AT_REST),
            ("True pose", "mm", "back_true_mm", AT_REST),
        )
        for place in places
    },
}
LOOP_QUOTED = {
    "apart": steps_apart,
    "open": loop_open,
    "single": single_off,
    "true.start": partial(Loop.of, place="start", name="back_true_mm"),
    "true.end": partial(Loop.of, place="step6", name="back_true_mm"),
}


def loop_refusals(trials, way):
    """How many runs ended before the sixth step, and before the single one."""
    ended = [trials.texts(name) for name in ("refused", f"{way}.refused")]
    loop = sum(any(texts) for texts in zip(*ended, strict=True))
    return loop, loop + sum(map(bool, trials.texts(f"{way}.single_refused")))


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


def name_values(open_results):
    """Name the numbers of the prose."""
    quoted = of_rendered(open_results(RENDERED)) | of_drawn(
        {name: open_results(name) for name in DRAWN}
    )
    quoted |= of_loop({n: open_results(n) for n in (LOOP, *LOOP_DRAWN.values())})
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
