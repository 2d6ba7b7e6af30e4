"""What the pages of the film and of the look-up table count, on made-up results."""

import numpy as np
import pytest

from chapters.ch05_flexible_mirror.ext_film import results as film
from chapters.ch05_flexible_mirror.ext_lookup import results as lookup
from chapters.ch05_flexible_mirror.ext_lookup.tables import lookup_table
from chapters.ch05_flexible_mirror.ext_lookup.trials.compared import CASES
from repro.run.outcomes import Plan
from tests.exercise_answers import misjudged
from tests.made_results import ROOT, as_planned, written

SEEDS = 12


def looked_up(**changed):
    """A Result in which the table is 0.02 degrees and 20 um off, the update half."""
    values = {}
    for way, size in (("exact", 1), ("traced", 1), ("few", 4), ("update", 0.5)):
        for case in CASES:
            name = f"{way}.{case}"
            values[f"{name}.angle_deg"] = np.full(SEEDS, 0.02 * size)
            values[f"{name}.deflection_um"] = np.full(SEEDS, -20.0 * size)
            values[f"{name}.flagged"] = np.zeros(SEEDS)
            values[f"{name}.off_px"] = np.full(SEEDS, 0.7)
    return as_planned("ext_mirror_lookup_runs", values | changed)


def test_errors_of_deflections_count_by_their_size():
    quoted = lookup.quoted(looked_up())
    assert quoted["A.traced.between2.deflection_um"].startswith("20")
    assert quoted["B.update.between2.angle_deg"].startswith("0.01")
    assert quoted["A.traced.beyond.flagged"] == 0


def test_a_seed_that_is_refused_is_the_worst_and_counts_as_told():
    angles = np.full(SEEDS, 0.01)
    angles[:7] = np.nan
    refused = ["too far"] * 7 + [None] * 5
    result = looked_up(
        **{"update.beyond.angle_deg": angles, "update.beyond.refused": refused}
    )
    assert lookup.flagged(result, "A", "update", "beyond") == 7
    found = lookup.measured(result, "A", "update", "beyond", "angle_deg")
    assert np.isinf(found).sum() == 7
    rows = lookup_table({lookup.RUNS: result}).columns
    last = next(
        row for row in zip(*rows.values(), strict=True)
        if row[:2] == (lookup.SAID["beyond"], lookup.WAYS["update"])
    )  # fmt: skip
    assert last[2] is None
    assert last[-1] == "14 of 24"


def of_ways():
    """Three seeds of the film, the last refused by the way that hands on."""
    rising = np.array([0.0, 1.0, 0.002])
    seeds = iter([1, 2, 3])

    def trial(condition, rng):
        seed = next(seeds)
        found = {"tracked": {"found_mm": seed * rising}}
        handed_on = {"refused": "too far"} if seed == 3 else {"found_mm": seed * rising}
        return found | {"handed_on": handed_on}

    return written(Plan(trial, [{}], 3))


def test_the_loop_counts_seeds_that_were_refused_as_the_worst():
    assert film.loops_um(of_ways(), "tracked") == pytest.approx([2, 4, 6])
    handed_on = film.loops_um(of_ways(), "handed_on")
    assert handed_on[:2] == pytest.approx([2, 4])
    assert np.isinf(handed_on[2])


def test_a_way_that_is_refused_in_all_seeds_has_no_numbers():
    nothing = as_planned(
        "ext_mirror_film_seeds", {"tracked.refused": ["too far"] * SEEDS}
    )
    quoted = film.of_seeds(nothing, "tracked")
    assert quoted["tracked.refused"] == SEEDS
    assert quoted["tracked.angle.peak"] == quoted["tracked.loop"] == "(no number)"


@pytest.mark.parametrize("page", ["ext_film", "ext_lookup"])
def test_exercises_take_right_answers_and_name_slips(page):
    assert misjudged(ROOT, f"ch05_flexible_mirror/{page}") == []
