"""Section 5.3.3, three deflections: claims can fail, on runs that were completed."""

import numpy as np
import pytest

from chapters.ch05_flexible_mirror.s3_3_deflections import claims, report
from chapters.shared.mirror.levels import BENCHES, FIRST, LEVEL, SWEPT
from repro.run.outcomes import NOT_COMPARABLE
from tests.judged_claims import assert_verdicts, of_rejected, readings_of
from tests.made_results import of_levels

SEEDS, SEEDS_FOR_95_PERCENT, LOST = 40, 80, 5
# Positions (N, 2) over the whole sheet.
SHEET = np.indices((11, 16)).reshape(2, -1)[::-1].T / [15.0, 10.0]
OUTWARDS = np.maximum(SHEET[:, 0], 1.6 * np.abs(SHEET[:, 1] - 0.5))
TRUE = {"shift_mm": 100.2, "turn_deg": 0.1, "measured_deg": 0.2, "angle_deg": 0.2,
        "anew_measured_deg": 0.2, "swing_deg": 1.0, "deflection_mm": 4.9,
        "linear_mm": 3.0, "back_mm": 0.5, "back_true_mm": 0.7, "stale_mm": 5.0,
        "residual_mm": 0.6, "off_deg": 0.1 + 0.2 * OUTWARDS,
        "sheet": SHEET, "own": np.column_stack([OUTWARDS, 0 * OUTWARDS]),
        "seen_at": SHEET}  # fmt: skip


ARRAYS = {
    "off_deg": report.STAGES,
    "sheet": report.STAGES,
    "own": (3,),
    "seen_at": (3,),
}


KEPT = ("shift_mm", "turn_deg")
NONE = {(k, name): np.nan for k in report.DEFLECTED for name in TRUE}


def of_bench(bench, seeds, other, places=True, lost=0, kept=KEPT):
    """Columns of a level: TRUE at all stages but for {(stage, name): value}; lost:
    seeds that were rejected at stage 3, and have of it what `kept` names."""
    rng = np.random.default_rng(5)
    out = {f"{bench}.refused": ["stage 3"] * lost + [None] * (seeds - lost)}
    for stage in report.STAGES:
        for name, value in TRUE.items():
            value = other.get((stage, name), value)
            if np.ndim(value) and not (places and stage in ARRAYS[name]):
                continue
            near = 1 + 1e-4 * rng.standard_normal(seeds)
            values = [value] * seeds if np.ndim(value) else list(value * near)
            gone = lost if stage == report.LAST and name not in kept else 0
            out[f"{bench}.stage{stage}.{name}"] = [None] * gone + values[gone:]
    return out


def made(other=None, swept=None, seeds=SEEDS, places=True, at=None, **lost):
    """Results of all experiments; other, swept: changed values of all levels and of
    those of the sweep; at: {level: changed values}."""

    def of(count, changed, **gone):
        return lambda level: of_bench(
            level, count, (at or {}).get(level, changed), places, **gone
        )

    other = other or {}
    return of_levels(
        (report.RUNS, BENCHES, of(seeds, other, **lost)),
        (report.LONGER, {LEVEL}, of(seeds, other)),
        (report.SWEPT_RUNS, SWEPT, of(4, swept or other)),
    )


FALSE = {
    claims.judge_deflections: [{(2, "deflection_mm"): 4.4}],
    claims.judge_angles: [{(3, "measured_deg"): 0.31}],
    claims.judge_angles_by_place: [{(1, "off_deg"): 0.3 - 0.2 * OUTWARDS}],
    claims.judge_removed: [{(3, "back_mm"): 1.3}],
    claims.judge_edges: [{(3, "own"): np.column_stack([1.5 - OUTWARDS, 0 * OUTWARDS])}],
    claims.judge_underestimate: [{(2, "linear_mm"): 5.1}, {(2, "linear_mm"): 4.6}],
    claims.judge_constant: [{(3, "back_mm"): 0.56}, {(3, "residual_mm"): 0.67}],
}


BY_PLACE = (claims.judge_angles_by_place, claims.judge_edges)


@pytest.mark.parametrize("judge", FALSE, ids=lambda judge: judge.__name__)
def test_deflection_claim_holds_fails_and_is_undecided(judge):
    seeds = SEEDS_FOR_95_PERCENT if judge is claims.judge_underestimate else SEEDS
    size = {"seeds": seeds, "places": judge in BY_PLACE}
    # An end of the sweep at which it is false leaves the primary verdict open, and so
    # does one at which every run was rejected.
    assert_verdicts(
        judge,
        made(**size),
        (made(other, **size) for other in FALSE[judge]),
        (made({}, end, **size) for end in (*FALSE[judge], NONE)),
    )


def test_verdict_that_differs_between_levels_is_undecided():
    results = made(at={FIRST: {(2, "deflection_mm"): 4.4}}, places=False)
    found = readings_of(claims.judge_deflections, results)
    assert found[0].verdict == "undecided"
    assert (
        "second solved level reproduced, first solved level differs, "
        "low-noise level reproduced"
    ) in found[0].reason
    others = ["reproduced"] * len(found[3:]) + ["differs", "reproduced"]
    assert [one.verdict for one in found[1:]] == others


@pytest.mark.parametrize(
    ("other", "verdict"),
    [
        ({}, "reproduced"),
        ({(2, "shift_mm"): 98.4}, "differs"),
        ({(3, "turn_deg"): 0.41}, "differs"),
    ],
)
def test_monitor_travel_is_not_comparable_at_the_second_level(other, verdict):
    # Rejected seeds have the monitor's travel too.
    found = readings_of(claims.judge_pose_reflection, made(other, lost=LOST))
    assert [r.verdict for r in found] == [NOT_COMPARABLE, verdict, verdict]
    assert f"of {SEEDS} seeds" in found[1].reason


def test_linear_range_is_reported_for_both_rigs_without_verdict():
    results = made({(1, "linear_mm"): 4.5}, places=False)
    results[report.OTHER] = made({(3, "linear_mm"): 2.0}, places=False)[report.RUNS]
    (found,) = readings_of(claims.judge_linear_range, results)
    assert found.verdict == NOT_COMPARABLE
    assert "A 8.16, 38.8, 38.8 % (" in found.regenerated
    assert "B 38.8, 38.8, 59.2 % (" in found.regenerated


def test_primary_grids_are_its_own_or_placed_anew():
    results = made({(0, "measured_deg"): 0.1}, places=False)
    assert {
        one.reading["primary_grids"]: one.verdict
        for one in readings_of(claims.judge_angles, results)
    } == {"the primary's own": "differs", "measured anew": "reproduced"}


def test_swinging_end_ends_the_run_in_one_reading():
    results = made(at={LEVEL: {(2, "swing_deg"): 6.0}}, places=False)
    for option, lost in (
        ("as published", [False, False, False]),
        ("rejected", [False, True, True]),
    ):
        found = report.Runs(results, {"swinging_ends": option})
        assert np.isnan(found.at("deflection_mm")).mean(axis=1).tolist() == lost
    # The linear stage is before what is rejected, and after it there is none.
    for one in readings_of(claims.judge_underestimate, results):
        none = "rejected" in one.reading.values() and one.verdict == "undecided"
        assert none == (one.reason == "a stage without any")
    for one in readings_of(claims.judge_deflections, results):
        assert ("rejected" in one.reading.values()) == (one.verdict == "undecided")


def test_rejected_runs_are_excluded_and_reported():
    results = made(lost=LOST)
    for judge in FALSE.keys() - {claims.judge_underestimate}:
        # Medians bear an eighth of failures.
        missed = "reproduced" if judge is claims.judge_constant else "undecided"
        expected = {("reproduced", "5 of 40", missed), ("reproduced",)}
        # The other geometry has none.
        assert of_rejected(judge, results) == expected
    found = report.Runs(results)
    (means,) = claims.of_arrays(found, 3, ("off_deg",), lambda off: [off.mean()], 1)
    assert np.isnan(means).tolist() == [True] * LOST + [False] * (SEEDS - LOST)
    np.testing.assert_array_equal(found.drawn(3, "sheet"), SHEET)


@pytest.mark.parametrize(
    ("kept", "reason"),
    [(KEPT, "11 of 264 stages have no linear estimate, which as misses give: differs"),
     ((*KEPT, "linear_mm"), "; 0 of 264 stages have no linear estimate")],
)  # fmt: skip
def test_linear_stages_count_before_a_rejection(kept, reason):
    results = made(seeds=88, places=False, lost=11, kept=kept)
    primary = readings_of(claims.judge_underestimate, results)[0]
    assert primary.verdict == "reproduced"
    assert reason in primary.reason


def test_level_without_runs_is_undecided():
    results = made(at={LEVEL: NONE})
    for judge in FALSE.keys() - {claims.judge_underestimate}:
        found = readings_of(judge, results)
        assert found[0].verdict == "undecided"
        assert found[0].reason.startswith("all 40 runs were rejected; the verdict")
        assert [r.verdict for r in found[-2:]] == ["reproduced"] * 2


def test_strips_lie_along_one_clamped_and_three_free_edges():
    sheet = np.array([[0.1, 0.05], [0.5, 0.5], [0.95, 0.5], [0.5, 0.1], [0.5, 0.9]])
    clamped, free = claims.of_strips(sheet)
    assert clamped.tolist() == [True, False, False, False, False]
    assert free.tolist() == [False, False, True, True, True]
    means = claims.strip_means(np.array([1.0, 2.0, 6.0, np.nan, 4.0]), sheet)
    assert means == pytest.approx([1.0, 13 / 4, 5.0])


def test_uniform_errors_have_no_excess_at_edges():
    rng = np.random.default_rng(2)
    p = [
        claims.edge_excess(rng.normal(size=(len(SHEET), 2)), SHEET)[1]
        for _ in range(60)
    ]
    assert np.mean(np.array(p) < 0.01) < 0.1
    assert claims.edge_excess(np.ones((4, 2)), np.full((4, 2), 0.5)) == (1.0, 1.0)


def test_nearer_camera_gives_larger_linear_estimates():
    assert report.camera_mm("B") < report.camera_mm("A")
    assert report.by_formula("B") > report.by_formula("A")
