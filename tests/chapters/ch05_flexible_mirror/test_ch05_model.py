"""Section 5.1: what the equations say, and that the tests of it can fail."""

import numpy as np
import pytest

from chapters.ch05_flexible_mirror.s1_model import experiment, report
from tests.judged_claims import readings, verdict

RNG = np.random.default_rng


def test_spread_pixels_use_every_interval_and_both_halves():
    grid, _ = experiment.draw_mirror(RNG(0))
    p = experiment.spread_pixels(RNG(1), 10, grid)
    assert sorted(grid.intervals(p)[:, 0]) == sorted([0, 1, 2, 3, 4] * 2)
    assert np.sum(p[:, 1] < 0) == 5
    assert grid.inside(p).all()


def test_curve_through_the_true_anchor_is_the_true_mirror():
    found = experiment.shapes_trial({}, None)["anchor_1"]
    assert found["beyond_scale_mm"] < 1e-7


def anchors(offset=1e-6, apart=3.0):
    own = {0: apart, 1: 0.0, 2: apart}
    return {
        f"anchor_{n}.{name}": [value]
        for n in own
        for name, value in (("offset_mm", offset), ("beyond_scale_mm", own[n]))
    }


def fixed(linear=1e-12, refined=1e-12, left=0.0):
    return {"open": [left], "linear_mm": [linear], "refined_mm": [refined],
            "start_mm": [1.0]}  # fmt: skip


def ends(lost=3, reciprocal=0.2):
    return {"all.rank": [20], "without.rank": [20 - lost], "all.reciprocal": [0.2],
            "without.reciprocal": [reciprocal], "size": [21]}  # fmt: skip


def pairs(random=18, least=10, most=20):
    def of(condition):
        n = condition["pairs"]
        rank = min(2 * n, most) if n >= least else min(2 * n, most) - 1
        return {"spread": [rank], "random": [random], "size": [21]}

    return of


def power(name, exponent):
    return lambda condition: {name: [condition["depth"] ** exponent]}


CLAIMS = {
    report.judge_depth_ambiguity: (
        {"open": [1.0, 1.0], "off": [1e-15, 1e-14]},
        [{"open": [1.0, 2.0], "off": [1e-15] * 2}, {"open": [1.0], "off": [1e-3]}],
    ),
    report.judge_shape_ambiguity: (
        anchors(),
        [anchors(offset=1.0), anchors(apart=1e-3)],
    ),
    report.judge_fix_removes: (
        fixed(),
        [fixed(refined=1.0), fixed(linear=1e-3), fixed(left=1.0)],
    ),
    report.judge_min_pairs: (pairs(), [pairs(most=21), pairs(least=11)]),
    report.judge_end_knots: (
        ends(),
        [ends(lost=0), ends(lost=0, reciprocal=0.2 / 900)],
    ),
    report.judge_far: (power("angle_deg", -1.0), [power("angle_deg", -0.8)]),
    report.judge_aberration: (power("moved_mm", 1.0), [power("moved_mm", 1.1)]),
}  # fmt: skip
EXPERIMENTS = {
    judge: mark["needs"][0] for judge in CLAIMS for mark in judge.repro_marks
}


@pytest.mark.parametrize("judge", CLAIMS, ids=lambda judge: judge.__name__)
def test_model_claim_holds_and_fails(judge):
    true, others = CLAIMS[judge]
    assert verdict(judge, EXPERIMENTS[judge], true) == "reproduced"
    for other in others:
        assert verdict(judge, EXPERIMENTS[judge], other) == "differs"


def test_beam_claim_covers_force_deflection_and_slope():
    def made(condition):
        steep = condition["slope2"] > 0.036
        return {"same_deflection": [0.5 if steep else 0.01], "same_force": [0.03]}

    found = readings(report.judge_beam_cubic, "exp_c5_beam_cubic", made)
    assert [one.verdict for one in found] == ["reproduced", "differs"]


def test_edge_claim_fails_at_three_times_the_refined_error():
    made = {
        "pick.picked_mm": 0.02, "pick.refined_mm": 0.01,
        "point.picked_mm": 0.08, "point.refined_mm": 0.02,
    }  # fmt: skip
    found = readings(report.judge_edges, "exp_c5_edge_refine", made)
    assert {r.reading["clamp_value"]: r.verdict for r in found} == {
        "at the pick": "differs",
        "of the fixed point": "reproduced",
    }


def test_centre_claim_fails_for_a_bent_mirror(monkeypatch):
    assert report.judge_centre({}).verdict == "reproduced"
    monkeypatch.setattr(report, "STAGES_MM", (0.0, 1e-6))
    assert report.judge_centre({}).verdict == "differs"
