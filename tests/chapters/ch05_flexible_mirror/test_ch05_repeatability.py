"""Section 5.3.3, there and back: trials keep what they say, and claims can fail."""

import numpy as np
import pytest

from chapters.ch05_flexible_mirror.s3_3_repeatability import claims, experiment, report
from chapters.shared.mirror.levels import BENCHES, LEVEL, SWEPT
from chapters.shared.mirror.rigs import mirror_rig
from tests.exercise_answers import misjudged
from tests.judged_claims import of_rejected, readings_of, verdicts
from tests.made_results import ROOT, of_columns

SEEDS = 60
EVERY = (*BENCHES, *SWEPT)


PLACES = ("start", *(f"step{k}" for k in range(1, 7)), "single")


def made_loops(benches=EVERY, refused=0, at=None, swinging=None, **of):
    """A Result of loops as the thesis tells them; of: {name of a value: factor};
    at: {bench: such factors}; refused: seeds that ended before the fourth step;
    swinging: the place where an end swings in all seeds."""
    rng = np.random.default_rng(0)
    values = {}
    for bench in benches:
        factors = of | (at or {}).get(bench, {})

        def put(name, size, spread=0.01, bench=bench, factors=factors):
            trials = size * factors.get(name, 1.0)
            trials = trials * (1 + spread * rng.standard_normal(SEEDS))
            if name.split(".")[0] in ("step4", "step5", "step6", "single"):
                trials[:refused] = np.nan
            values[f"{bench}.{name}"] = trials

        for step in range(1, 7):
            put(f"step{step}.deflection_mm", 5.0, 0.002)
            put(f"step{step}.linear_mm", 3.1)
        put("single.deflection_mm", 15.0, 0.002)
        for place in PLACES:
            size = {"start": 0.85, "single": 2.74}.get(place, 1.84)
            for name in ("back_mm", "back_true_mm"):
                put(f"{place}.{name}", size)
            put(f"{place}.back_sd_mm", 1.4)
            put(f"{place}.angle_deg", 0.3)
            put(f"{place}.residual_mm", 1.0)
            put(f"{place}.residual_sd_mm", 0.6)
        said = ["step 4: no"] * refused + [None] * (SEEDS - refused)
        values[f"{bench}.refused"] = said
        for place in PLACES[1:]:
            values[f"{bench}.{place}.swing_deg"] = np.full(
                SEEDS, 5.0 if place == swinging else 1.0
            )
    return of_columns(({"geometry": "A"}, values))


def loops(**made):
    return {
        "table_5_5_runs": made_loops(BENCHES, **made),
        "table_5_5_swept": made_loops(SWEPT, **made),
    }


def ended_early(runs):
    """Numbers of runs without the sixth step, and without the single step."""
    return tuple(
        int(np.isnan(runs.at_place(place, "back_mm")).sum())
        for place in ("step6", "single")
    )


SAME, OTHER = ("reproduced", {"reproduced"}), ("differs", {"differs"})
TURNED = ("undecided", {"reproduced"})
GROWING = {f"step{k}.back_mm": 1 + 0.1 * k for k in range(1, 7)}
FALSE = {
    claims.judge_equivalent_steps: {"step6.deflection_mm": 1.1},
    claims.judge_loop: {"step5.deflection_mm": 1.1},
    claims.judge_single_step: {"single.deflection_mm": 1.02},
    claims.judge_single_back_projection: {"single.back_mm": 0.6},
    claims.judge_accumulation: GROWING,
    claims.judge_increase: {"start.back_mm": 3.0},
    claims.judge_concave_steps: {"step6.back_mm": 1.5},
}


@pytest.mark.parametrize("judge", FALSE, ids=lambda judge: judge.__name__)
def test_a_claim_holds_where_it_is_true_and_fails_where_it_is_not(judge):
    assert verdicts(judge, loops()) == SAME
    assert verdicts(judge, loops(**FALSE[judge])) == OTHER


@pytest.mark.parametrize("judge", FALSE, ids=lambda judge: judge.__name__)
def test_what_changes_side_in_the_sweep_is_left_open_in_the_primary_alone(judge):
    # An end at which every seed was rejected is on no side.
    none = {f"{k}.{n}": np.nan for k in PLACES for n in ("deflection_mm", "back_mm")}
    for end in (FALSE[judge], none):
        turned = loops(at={"twice the factor": end})
        assert verdicts(judge, turned) == TURNED
        assert "twice the factor" in readings_of(judge, turned)[0].reason


@pytest.mark.parametrize("judge", FALSE, ids=lambda judge: judge.__name__)
def test_seeds_that_were_rejected_do_not_count_and_are_told(judge):
    """Ten of 60; as misses they turn shares, and no median."""
    lost = loops(refused=10)
    assert ended_early(report.LoopRuns(lost)) == (10, 10)
    by_seed = judge in (claims.judge_equivalent_steps, claims.judge_loop)
    missed = "undecided" if by_seed else "reproduced"
    assert of_rejected(judge, lost) == {("reproduced", "10 of 60", missed)}


def test_a_swinging_end_ends_the_loop_and_the_single_step_after_it():
    for place, lost in (("step2", (60, 60)), ("step5", (60, 0)), ("single", (0, 60))):
        swung = loops(swinging=place)
        assert (
            ended_early(report.LoopRuns(swung, {"swinging_ends": "rejected"})) == lost
        )
    found = verdicts(claims.judge_single_step, swung)
    assert found == ("reproduced", {"reproduced", "undecided"})


def test_the_steps_are_held_against_those_that_undo_them():
    assert report.EQUIVALENT == ((1, 6), (2, 5), (3, 4))
    runs = report.LoopRuns(
        loops(**{"step4.deflection_mm": 0.9, "step3.deflection_mm": 0.9})
    )
    assert np.median(report.disagreement(runs)) < 1
    # Out 14.5, back 14.5: the height is 0.5 mm short at stage 3, and right at the end.
    off = np.median(report.height_errors(runs), axis=1)
    np.testing.assert_allclose(off, [0, 0, -0.5, 0, 0, 0], atol=0.02)


def placed(coarse=0.1, dense=0.05, lost=0, at=None):
    rng = np.random.default_rng(1)
    values = {}
    for bench in EVERY:
        for pitch, sd in (
            (at or {}).get(bench, {"coarse": coarse, "dense": dense}).items()
        ):
            mm = 5 + sd * rng.standard_normal((SEEDS, 5))
            mm[:lost, 0] = np.nan
            values[f"{bench}.{pitch}"] = mm
            values[f"{bench}.refused_{pitch}"] = np.isnan(mm).sum(axis=1)
    return {"exp_c5_dense_grid": of_columns(({"geometry": "A"}, values))}


def test_the_spread_between_places_is_judged_and_what_is_refused_is_told():
    assert verdicts(claims.judge_placement, placed(lost=3)) == SAME
    assert verdicts(claims.judge_dense_grid, placed(lost=3)) == SAME
    assert verdicts(claims.judge_placement, placed(0.03)) == OTHER
    assert verdicts(claims.judge_dense_grid, placed(0.1, 0.1)) == OTHER
    turned = placed(at={"half the aberration": {"coarse": 0.02, "dense": 0.02}})
    for judge in (claims.judge_placement, claims.judge_dense_grid):
        assert verdicts(judge, turned) == TURNED
    reading = readings_of(claims.judge_placement, placed(lost=3))[0]
    assert f"rejected of {5 * SEEDS}: 3" in reading.reason
    result = placed()["exp_c5_dense_grid"]
    assert claims.pooled_sd(result, LEVEL).value == pytest.approx(0.1, rel=0.1)


def started(lost=0, at=EVERY, **sd_mm):
    values = {}
    for bench in EVERY:
        for step, sd in ({"5": 0.01, "15": 0.03} | sd_mm).items():
            trials = np.full(SEEDS, sd)
            trials[: lost if bench in at and step == "15" else 0] = np.nan
            values[f"{bench}.{step}.sd_mm"] = trials
    return {"exp_c5_not_sensitive_init": of_columns(({"geometry": "A"}, values))}


def test_starts_are_judged_by_the_worse_step_of_the_seeds_that_completed_it():
    judge = claims.judge_starts
    assert verdicts(judge, started()) == SAME
    for bad in ({"5": 0.06}, {"15": 0.2}):
        assert verdicts(judge, started(**bad)) == OTHER
    lost = readings_of(judge, started(lost=40))[0]
    assert lost.verdict == "reproduced"
    assert "15 mm 0.2 %; 40 of 60 runs rejected" in lost.reason
    assert verdicts(judge, started(lost=SEEDS)) == ("undecided", {"undecided"})
    assert verdicts(judge, started(lost=SEEDS, at=("twice both",))) == TURNED


def test_the_dense_board_has_the_other_board_s_corners():
    board = mirror_rig("A").board
    boards = experiment.boards_of_pitches(board)
    np.testing.assert_array_equal(boards["coarse"][0], board.points())
    points, which = boards["dense"]
    assert len(points) == 27 * 25
    np.testing.assert_array_equal(points[boards["coarse"][1]], board.points())
    np.testing.assert_array_equal(points[which], points)


def test_starts_reach_from_half_of_the_deflection_less_to_half_more():
    found = experiment.shares(np.random.default_rng(2))
    assert found.shape == (experiment.STARTS, 3)
    assert np.abs(found).max() <= 0.5
    np.testing.assert_allclose(found[[0, -1], 1], [-0.5, 0.5])
    assert np.ptp(found, axis=1).max() > 0.1


def test_the_numbers_are_those_of_the_ledger():
    made = report.numbers_table_5_5(loops()) | report.numbers_fig_5_13(loops())
    assert len(made) == 6 * 5 + 9 + 10
    assert made["t5_5_step4_linear"].value == pytest.approx(3.1, rel=0.02)
    assert made["t5_5_step4_actual"].put_in
    assert made["s5_rep_single_fin"].value == pytest.approx(15, rel=0.01)
    assert made["s5_rep_bp_increase"].value == pytest.approx(0, abs=1)
    assert made["s5_rep_hyst_pct"].value == pytest.approx(
        100 * made["s5_rep_hyst_mm"].value / 15
    )


def test_exercises_are_judged_rightly():
    assert misjudged(ROOT, "ch05_flexible_mirror/s3_3_repeatability") == []


@pytest.mark.parametrize(("last", "verdict"), [(80, "reproduced"), (101, "differs")])
def test_a_larger_deflection_leaves_fewer_common_corners(last, verdict):
    common = [np.array([110, 108, 106, 103, 100, last + k]) for k in (-1, 0, 1)]
    found = of_columns(({"geometry": "A"}, {"back": common, "out": common}))
    reading = claims.judge_lost_features({"exp_c5_feature_loss": found})
    assert reading.verdict == verdict
