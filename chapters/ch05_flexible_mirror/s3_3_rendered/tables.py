"""Rendered runs beside the runs with drawn errors, and beside the targets."""

from itertools import product

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_rendered.results.aims import (
    AIMS,
    drawn,
    measured,
)
from chapters.ch05_flexible_mirror.s3_3_rendered.results.loop import (
    LOOP,
    LOOP_MEASURES,
    loop_drawn,
    loop_from_pictures,
    loop_refusals,
)
from chapters.ch05_flexible_mirror.s3_3_rendered.results.runs import (
    AIMED,
    LABORATORY,
    RENDERED,
    STAGES,
    WAYS,
    cases,
    drawn_value,
    refusals,
)
from chapters.shared.mirror_bench import BENCH
from repro.judge.statistics import with_worst
from repro.run.columns import columns
from repro.run.experiment import table
from repro.run.outcomes import Measured, Table

MEASURES = {
    "Ray angle (degrees)": "angle_deg",
    "Residual (mm)": "residual_mm",
    "Own pose (mm)": "back_own_mm",
    "True pose (mm)": "back_true_mm",
}


@table(
    "ext_mirror_rendered_targets",
    needs=(
        "table_5_1_rendered",
        "ext_mirror_rendered_uneven",
        "table_5_5_rendered",
        "ext_mirror_trust_runs",
    ),
    evidence="rendered",
)
def targets(results):
    """Twice every target, and what rendered runs and those of many seeds have."""
    there, rows = tuple(product("AB", (LABORATORY, BENCH))), []
    for aim in AIMS:
        found = [measured(results, aim, *place) for place in there]
        rows.append(
            (
                f"{aim.words} ({aim.unit})",
                f"below {aim.bound:g}",
                *(said(found[place], aim.bound) for place in (0, 2)),
                *map(of_runs, found),
                *(
                    Measured.median_or_none(drawn(results[AIMED], aim, geometry))
                    for geometry in "AB"
                ),
            )
        )
    names = [f"{geometry}, {bench}" for geometry, bench in there]
    heads = ("Error", "Twice", "A", "B", *names, "A, drawn", "B, drawn")
    return Table(
        columns(heads, rows),
        "Twice the targets, and runs from pictures as aimed at: inverse depth, "
        "position and slope of the clamp, the prior. *A*, *B*: what the laboratory's "
        "run says of it, one run for each geometry. Where a bench has several, the "
        "median and the range. *Uneven by 10 µm*: a run of its own, with the "
        "laboratory's decoding. The loop and the single step are those of the table "
        "below. *Drawn*: medians with 0.2 px at every corner, of many seeds, with "
        "95 % intervals, which are held against the targets themselves elsewhere. The "
        "bench was no target. A run that was refused has missed all that it did not "
        "reach.",
    )


def said(found, bound):
    """What a laboratory's run says of a bound, in words."""
    if found is None:
        return "not run"
    return "met" if np.median(found) < bound else "not met"


def of_runs(found):
    """The median of runs and their range, one number for a single run, to three
    digits; None where there is none or half of them ended early."""
    if found is None or not np.isfinite(np.median(found)):
        return None
    if len(found) == 1:
        return float(f"{found[0]:.3g}")
    return Measured.of_seeds(found)


@table(
    "ext_mirror_rendered_table",
    needs=(
        "table_5_1_rendered",
        "table_5_1_runs",
        "table_5_1_other",
        "ext_mirror_trust_runs",
    ),
    evidence="rendered",
)
def rendered_table(results):
    """Every way of every bench, stage by stage, beside drawn errors."""
    rows = [
        (geometry, bench, words, stage, len(trials.conditions),
         refusals(trials)[way.split(".")[0]],
         *beside(results, trials, way, geometry, bench, stage))
        for geometry, bench, trials in cases(results[RENDERED])
        for way, words in WAYS.items()
        for stage in STAGES
    ]  # fmt: skip
    heads = [part for name in MEASURES for part in (name, f"drawn: {name}")]
    return Table(
        columns(("Rig", "Bench", "Way", "Stage", "Runs", "Refused", *heads), rows),
        "From pictures, and with drawn errors beside where such runs were made. "
        "Several runs have median and range; drawn ones the median of many seeds with "
        "a 95 % interval. Rays are compared over the whole mirror, as far as a spline "
        "reaches; back-projection is onto exact corners at 400 mm, with the pose that "
        "the camera itself finds and with the true one. All stages at once have no "
        "residual in mm.",
    )


def beside(results, trials, way, geometry, bench, stage):
    """Cells of a row: every measure from pictures and with drawn errors."""
    cells = []
    for name in MEASURES.values():
        many = drawn_value(results, way, geometry, bench, stage, name)
        cells.append(of_runs(known(trials, way, stage, name)))
        cells.append(None if many is None else Measured.median_or_none(many))
    return cells


def known(trials, way, stage, name):
    """Values of those runs that have one; None without any."""
    found = trials.column(f"{way}.stage{stage}.{name}")
    found = found[np.isfinite(found)]
    return found if len(found) else None


@table(
    "ext_mirror_rendered_loop",
    needs=("table_5_5_rendered", "table_5_5_runs", "table_5_5_other"),
    evidence="rendered",
)
def loop_table(results):
    """The loop and the single step from pictures, beside those with drawn errors."""
    there, rows = cases(results[LOOP]), []
    for way in ("published", "aimed"):
        for words, measure in LOOP_MEASURES.items():
            cells = []
            for geometry, bench, trials in there:
                values = measure(loop_from_pictures(trials, way))
                many = loop_drawn(results, way, geometry, bench)
                cells.append(of_runs(with_worst(values)))
                cells.append(many and Measured.median_or_none(measure(many)))
            rows.append((WAYS[way], words, *cells))
        for place, words in enumerate(("Loops refused", "Single steps not found")):
            cells = []
            for *_, trials in there:
                cells += [float(loop_refusals(trials, way)[place]), None]
            rows.append((WAYS[way], f"{words} (runs)", *cells))
    heads = [
        head
        for geometry, bench, _ in there
        for head in (f"{geometry}, {bench}", f"{geometry}, {bench}, drawn")
    ]
    return Table(
        columns(("Way", "Measure", *heads), rows),
        "Three steps of 5 mm out, three back, and one of 15 mm back, from pictures of "
        "a board that stays. Several runs have median and range. *Drawn*: as "
        "published, with drawn errors: medians of many seeds with 95 % intervals, "
        "whose board stood elsewhere at each step out. Steps are held against the 5 mm "
        "that were pushed; own pose and true pose are back-projection at 400 mm, at "
        "stage 0, onto one board before, after six steps and after the single one. "
        "Where half of the runs did not get that far there is no number.",
    )
