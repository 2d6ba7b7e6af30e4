"""Section 5.3.3, three deflections: claims can fail, and refused seeds count."""

import numpy as np
import pytest

from chapters.ch05_flexible_mirror.s3_3_deflections import claims
from chapters.ch05_flexible_mirror.s3_3_deflections.results import geometry, prose, runs
from chapters.ch05_flexible_mirror.s3_3_deflections.results.predicates import (
    edge_excess,
)
from chapters.shared.mirror_bench import BENCHES, SWEPT
from raxel.errors import CalibrationError
from tests.exercise_answers import misjudged
from tests.judged_claims import readings_of
from tests.made_results import ROOT, of_columns
from tests.test_mirror_update import to_the_edge

SEEDS, ENOUGH, LOST = 40, 80, 5


def lattice():
    """Places (N, 2) over the whole sheet."""
    along, across = np.meshgrid(np.linspace(0, 1, 16), np.linspace(0, 1, 11))
    return np.column_stack([along.ravel(), across.ravel()])


SHEET = lattice()
OUTWARDS = np.maximum(SHEET[:, 0], 1.6 * np.abs(SHEET[:, 1] - 0.5))
TRUE = {"shift_mm": 100.2, "turn_deg": 0.1, "measured_deg": 0.2, "angle_deg": 0.2,
        "deflection_mm": 4.9, "linear_mm": 3.0, "back_mm": 0.5, "back_true_mm": 0.7,
        "stale_mm": 5.0, "residual_mm": 0.6, "off_deg": 0.1 + 0.2 * OUTWARDS,
        "sheet": SHEET, "own": np.column_stack([OUTWARDS, 0 * OUTWARDS]),
        "seen_at": SHEET}  # fmt: skip


ARRAYS = {"off_deg": runs.STAGES, "sheet": runs.STAGES, "own": (3,), "seen_at": (3,)}


def of_bench(bench, seeds, other, places=True):
    """Columns of a bench: TRUE at all stages but for {(stage, name): value}."""
    rng = np.random.default_rng(5)
    out = {}
    for stage in runs.STAGES:
        for name, value in TRUE.items():
            value = other.get((stage, name), value)
            if np.ndim(value) and not (places and stage in ARRAYS[name]):
                continue
            if np.ndim(value):
                out[f"{bench}.stage{stage}.{name}"] = [value] * seeds
            else:
                near = 1 + 1e-4 * rng.standard_normal(seeds)
                out[f"{bench}.stage{stage}.{name}"] = value * near
    return out


def made(other=None, swept=None, seeds=SEEDS, places=True):
    """The results of both experiments, with what is otherwise at each kind of bench."""
    results = {}
    for name, benches, count, changed in (
        (runs.RUNS, BENCHES, seeds, other or {}),
        (runs.SWEPT_RUNS, SWEPT, 4, swept or other or {}),
    ):
        columns = {}
        for bench in benches:
            columns |= of_bench(bench, count, changed, places)
        results[name] = of_columns(({"geometry": "A"}, columns))
    return results


FALSE = {
    claims.judge_pose_reflection: [{(2, "shift_mm"): 98.4}, {(3, "turn_deg"): 0.41}],
    claims.judge_deflections: [{(2, "deflection_mm"): 4.4}],
    claims.judge_linear_range: [{(1, "linear_mm"): 2.3}, {(3, "linear_mm"): 4.0}],
    claims.judge_angles: [{(3, "measured_deg"): 0.31}],
    claims.judge_angles_by_place: [{(1, "off_deg"): 0.3 - 0.2 * OUTWARDS}],
    claims.judge_removed: [{(3, "back_mm"): 1.3}],
    claims.judge_edges: [{(3, "own"): np.column_stack([1.5 - OUTWARDS, 0 * OUTWARDS])}],
    claims.judge_underestimate: [{(2, "linear_mm"): 5.1}, {(2, "linear_mm"): 4.6}],
    claims.judge_constant: [{(3, "back_mm"): 0.56}, {(3, "residual_mm"): 0.67}],
}


BY_PLACE = (claims.judge_angles_by_place, claims.judge_edges)


@pytest.mark.parametrize("judge", FALSE, ids=lambda judge: judge.__name__)
def test_a_claim_holds_where_it_is_true_and_fails_where_it_is_not(judge):
    # A share of 95 % needs more runs than one of 90 %.
    seeds = ENOUGH if judge is claims.judge_underestimate else SEEDS
    size = {"seeds": seeds, "places": judge in BY_PLACE}
    found = readings_of(judge, made(**size))
    assert [r.verdict for r in found] == ["reproduced"] * 2
    for other in FALSE[judge]:
        found = readings_of(judge, made(other, **size))
        assert [r.verdict for r in found] == ["differs"] * 2
        # An end of the sweep at which it is false leaves the bench's verdict open.
        bench, laboratory = readings_of(judge, made({}, other, **size))
        assert (bench.verdict, laboratory.verdict) == ("undecided", "reproduced")


def test_seeds_whose_refusal_has_the_code_of_a_swinging_end_are_counted():
    with pytest.raises(CalibrationError) as caught:
        to_the_edge(0.3, np.random.default_rng(7))
    columns = of_bench("bench", 3, {})
    columns["bench.refused"] = [caught.value.code, "no-feature-at-end", None]
    found = runs.Runs({runs.RUNS: of_columns(({"geometry": "A"}, columns))})
    assert prose.swings(found) == 1
    assert prose.refusals(found) == 2


def test_seeds_that_were_refused_count_against_a_claim():
    results = made(seeds=SEEDS)
    columns = of_bench("bench", SEEDS, {}) | of_bench("laboratory", SEEDS, {})
    for name, values in columns.items():
        if "bench.stage3" in name:
            columns[name] = np.empty(SEEDS, object)
            columns[name][:] = list(values)
            columns[name][:LOST] = None
    refused = [f"stage 3: {seed}" if seed < LOST else None for seed in range(SEEDS)]
    columns["bench.refused"] = refused
    results[runs.RUNS] = of_columns(({"geometry": "A"}, columns))
    for judge in FALSE:
        bench = readings_of(judge, results)[0].verdict
        # Medians bear an eighth of failures.
        assert (bench == "reproduced") is (judge is claims.judge_constant), judge
    found = runs.Runs(results)
    assert sum(reason is not None for reason in found.refused()) == LOST
    (means,) = found.each(3, ("off_deg", "sheet"), lambda off, sheet: [off.mean()], 1)
    assert np.isnan(means).tolist() == [True] * LOST + [False] * (SEEDS - LOST)
    np.testing.assert_array_equal(found.drawn(3, "sheet"), SHEET)


def test_a_bench_on_which_every_seed_was_refused_is_false_of_each_claim_by_seed():
    results = made(seeds=2)
    columns = of_bench("laboratory", 2, {}) | of_bench("bench", 2, {})
    columns = {n: v for n, v in columns.items() if "bench.stage3" not in n}
    columns |= {"bench.stage3.angle_deg": [None] * 2, "bench.refused": ["stage 3"] * 2}
    columns |= {f"bench.stage3.{name}": [None] * 2 for name in TRUE}
    results[runs.RUNS] = of_columns(({"geometry": "A"}, columns))
    for judge in BY_PLACE:
        bench, laboratory = readings_of(judge, results)
        assert "true in 0 of 2 seeds" in bench.reason
        assert laboratory.verdict == "reproduced"


def test_strips_are_along_one_clamped_and_three_free_edges():
    sheet = np.array([[0.1, 0.05], [0.5, 0.5], [0.95, 0.5], [0.5, 0.1], [0.5, 0.9]])
    clamped, free = runs.of_strips(sheet)
    assert clamped.tolist() == [True, False, False, False, False]
    assert free.tolist() == [False, False, True, True, True]
    means = runs.strip_means(np.array([1.0, 2.0, 6.0, np.nan, 4.0]), sheet)
    assert means == pytest.approx([1.0, 13 / 4, 5.0])


def test_errors_of_one_size_have_no_excess_at_the_edges():
    rng = np.random.default_rng(2)
    p = [edge_excess(rng.normal(size=(len(SHEET), 2)), SHEET)[1] for _ in range(60)]
    assert np.mean(np.array(p) < 0.01) < 0.1
    assert edge_excess(np.ones((4, 2)), np.full((4, 2), 0.5)) == (1.0, 1.0)


def test_the_formula_says_how_far_the_board_has_to_be():
    depth = geometry.depth_for(0.54)
    assert geometry.by_formula(depth_mm=depth) == pytest.approx(0.54)
    assert geometry.camera_mm("B") < geometry.camera_mm("A")


def test_exercises_are_judged_rightly():
    assert misjudged(ROOT, "ch05_flexible_mirror/s3_3_deflections") == []
