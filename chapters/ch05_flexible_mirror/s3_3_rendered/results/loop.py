"""The loop and the single step of the rendered runs, beside those of many seeds."""

from functools import partial
from typing import NamedTuple

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_rendered.results.runs import CALLED, STAGES
from chapters.shared.mirror_rigs import STAGES_MM

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


def single_wrong(loop):
    """The single step against the way that was pushed, %, (runs,), without sign."""
    return 100 * np.abs(loop.of("single", "deflection_mm") / (OUT * STEP_MM) - 1)


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
