"""Twice the targets, and whether rendered runs meet them."""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_rendered.results.loop import (
    LOOP,
    loop_from_pictures,
    loop_open,
    single_wrong,
)
from chapters.ch05_flexible_mirror.s3_3_rendered.results.runs import (
    RENDERED,
    STAGES,
    runs_of,
)
from repro.judge.statistics import with_worst

UNEVEN = "ext_mirror_rendered_uneven"
RUN_WITH_PICTURES = (RENDERED, UNEVEN, LOOP)


class Aim(NamedTuple):
    """bound: twice the target; experiment: whose runs are held against it; of: its
    values (runs,) of these runs, not finite where a run gave none; drawn: what
    `ext_mirror_trust_runs` calls them, of mirrors uneven by `aberration_um`."""

    words: str
    bound: float
    unit: str
    experiment: str
    of: Callable
    drawn: tuple
    aberration_um: float = 0.0


def largest(trials, names):
    """The largest (runs,) of some values as aimed at."""
    return np.max([trials.column(f"aimed.{name}") for name in names], axis=0)


def of_loop(trials, measure):
    """A measure (runs,) of the loop as aimed at."""
    return measure(loop_from_pictures(trials, "aimed"))


def _stages(words, bound, unit, names):
    drawn = tuple(f"prior.{name}" for name in names)
    return Aim(words, bound, unit, RENDERED, partial(largest, names=names), drawn)


def _primary(words, bound, unit, name):
    of = partial(largest, names=(f"stage0.{name}",))
    return Aim(words, bound, unit, RENDERED, of, (name,))


def _uneven(stage, bound):
    words, name = f"Mean ray angle, stage {stage}, uneven by 10 µm", "angle_deg"
    of = partial(largest, names=(f"stage{stage}.{name}",))
    drawn = (f"prior.stage{stage}.{name}",)
    return Aim(words, bound, "degrees", UNEVEN, of, drawn, 10.0)


def _loop(words, bound, unit, measure, drawn):
    return Aim(words, bound, unit, LOOP, partial(of_loop, measure=measure), (drawn,))


def _every(name):
    return tuple(f"stage{k}.{name}" for k in STAGES)


AIMS = (
    *(
        _stages(f"Deflection, stage {k}", bound, "%", (f"stage{k}.deflection_percent",))
        for k, bound in zip(STAGES, (1.0, 2.0, 3.0), strict=True)
    ),
    *(
        _stages(
            f"Mean ray angle, stage {k}", bound, "degrees", (f"stage{k}.angle_deg",)
        )
        for k, bound in zip(STAGES, (0.08, 0.16, 0.28), strict=True)
    ),
    _stages(
        "Mean ray angle, stage 3, after the bundle",
        0.18,
        "degrees",
        ("bundle.stage3.angle_deg",),
    ),
    *(_uneven(k, bound) for k, bound in zip(STAGES, (0.3, 0.5, 0.7), strict=True)),
    _stages("Residual, worst stage", 0.4, "mm", _every("residual_mm")),
    _stages("Back-projection, own pose, worst stage", 1.2, "mm", _every("back_own_mm")),
    _stages(
        "Back-projection, true pose, worst stage", 2.2, "mm", _every("back_true_mm")
    ),
    _loop(
        "Height after three steps out and back", 0.06, "mm", loop_open, "prior.loop_mm"
    ),
    _loop(
        "Deflection, 15 mm at a stroke", 3.0, "%", single_wrong, "prior.single_percent"
    ),
    _primary("Grid separation", 0.1, "mm", "separation_mm"),
    _primary("Grid rotation", 0.04, "degrees", "separation_deg"),
)


def measured(results, aim, geometry, bench):
    """Values (runs,) of an Aim, infinite where a run gave none; None where the plan has
    no such run."""
    trials = runs_of(results[aim.experiment], geometry, bench)
    return None if trials is None else with_worst(aim.of(trials))


def drawn(result, aim, geometry):
    """The same of the seeds of `ext_mirror_trust_runs`."""
    trials = result.select(geometry=geometry, aberration_um=aim.aberration_um)
    found = [with_worst(trials.column(name)) for name in aim.drawn]
    return np.max(found, axis=0)


def held(results, geometry, bench):
    """(how many aims the median of the runs meets, how many were asked)."""
    every = [measured(results, aim, geometry, bench) for aim in AIMS]
    asked = [(v, aim) for v, aim in zip(every, AIMS, strict=True) if v is not None]
    return sum(bool(np.median(v) < aim.bound) for v, aim in asked), len(asked)
