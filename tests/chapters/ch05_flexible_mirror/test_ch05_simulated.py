"""Section 5.3.1: the simulated mirror is a mirror, and its claims can fail."""

import functools

import numpy as np
import pytest

from chapters.ch05_flexible_mirror.s3_1_simulated import experiment, report
from raxel.calibration.mirror.reduced import reflected, viewing_rays
from tests.judged_claims import readings_of
from tests.made_results import OfLaw

BASE = {"sweep": "noise"} | experiment.BASE
RIG = experiment.rig_of(BASE["pitch"])


def views(depth=1650.0, tip=16.7, seed=0, **changed):
    condition = BASE | changed
    drawn = experiment.draw(condition, np.random.default_rng(seed))
    return experiment.look(condition, depth, tip, drawn)


@pytest.mark.parametrize("tip", [0.0, 16.7, 53.0, -30.0])
def test_visible_corner_lies_on_its_reflected_ray(tip):
    seen = views(tip=tip)
    known = np.isfinite(seen.after)
    assert known.sum() >= 8
    x = (seen.on[known] - RIG.foot) @ experiment.ALONG
    on, tangents = experiment.bent(RIG, x, tip)
    np.testing.assert_allclose(on, seen.on[known], atol=1e-9)
    V_r = reflected(viewing_rays(experiment.pixels_of(on))[0], tangents)
    to = seen.points[known] - on
    off = V_r[:, 0] * to[:, 1] - V_r[:, 1] * to[:, 0]
    assert np.abs(off).max() < 1e-6
    assert np.all(np.einsum("ij,ij->i", V_r, to) > 0)


def test_noise_free_height_is_exact_and_linear_follows_the_formula():
    seen = views()
    found = experiment.errors(experiment.calibrate(seen, 0.0, "height").curve, seen)
    assert found["across_mm"] < 1e-6
    assert found["tip_ratio"] == pytest.approx(1, abs=1e-7)
    linear = experiment.calibrate(seen, 0.0).linear
    left = 1 - experiment.errors(linear, seen)["tip_ratio"]
    assert left == pytest.approx(report.missing_by_formula(1650.0), abs=0.05)


def test_images_before_and_after_have_independent_noise():
    seen = views(rows=13)
    both = experiment.in_both(seen)
    after = (experiment.after_bending(seen, 2.0) - seen.after)[both] / RIG.pixel
    np.testing.assert_allclose(after, 2 * seen.noise[1][both])
    V_r, points = experiment.located(seen, 2.0)
    before = (np.array(seen.before) + 2.0 * RIG.pixel * seen.noise[0])[both]
    np.testing.assert_allclose(experiment.flat_rays(RIG, before)[1], V_r[both])
    exact = experiment.located(seen, 0.0)[1]
    np.testing.assert_allclose(exact[both], seen.points[both], atol=1e-5)
    assert 0.01 < np.abs(points - exact)[both].max() < 50
    assert abs(np.corrcoef(seen.noise)[0, 1]) < 0.3


def law(name, condition, **of):
    """Columns as the thesis's statements would have them; ``of``: what is otherwise."""
    level, *_, quantity = name.split(".")
    sweep = condition["sweep"]
    at = experiment.DEFAULT | {
        sweep: experiment.SWEEPS[sweep][int(level.split("_")[1])]
    }
    scatter = 1 + 0.02 * np.random.default_rng(1).standard_normal(100)
    linear = report.linear_by_formula(at["depth"], at["bend"])
    made = {
        "slope2": 2.25 * (at["bend"] / 420) ** 2,
        "linear": linear * (1 + 0.01 * at["noise"]),
        "final": 0.05 * at["noise"] * max(1, 3000 / at["depth"]) ** 0.3
        * max(1, at["bend"] / 16.7),
        "tip_ratio": 1 - 300 / (at["depth"] + 300),
    }  # fmt: skip
    made |= {key: rule(at, made[key]) for key, rule in of.items()}
    stage = next((s for s in ("linear", "final") if f".{s}." in name), None)
    key = quantity if quantity in made else stage
    return np.array(made[key] * scatter if key != "slope2" else [made[key]] * 100)


def judged(judge, **of):
    result = OfLaw("fig_5_5_sweeps", functools.partial(law, **of), 100)
    return {r.verdict for r in readings_of(judge, {"fig_5_5_sweeps": result})}


CLAIMS = {
    report.judge_slope_small: {"slope2": lambda at, v: 2 * v},
    report.judge_noise_final_more: {"final": lambda at, v: 1 + v},
    report.judge_noise_final_linear: {"final": lambda at, v: v + 0.1},
    report.judge_final_beats_linear: {"final": lambda at, v: v + at["depth"] / 4e3},
    report.judge_depth_decreases: {"final": lambda at, v: 0.1 * at["depth"]},
    report.judge_depth_saturates: {"final": lambda at, v: v * at["depth"] ** 0.3},
    report.judge_curv_linear_rises: {"linear": lambda at, v: v * 0 + 1},
    report.judge_curv_final_largest: {
        "final": lambda at, v: v / max(at["bend"], 16.7) ** 2
    },
    report.judge_bias_inverse_depth: {
        "tip_ratio": lambda at, v: 1 - at["depth"] ** -0.5
    },
}


@pytest.mark.parametrize("judge", CLAIMS, ids=lambda judge: judge.__name__)
def test_simulation_claim_holds_and_fails(judge):
    assert judged(judge, final=_true_final) == {"reproduced"}
    assert "reproduced" not in judged(judge, **CLAIMS[judge])


def _true_final(at, value):
    """The final error of the thesis, its largest in the curvature sweep."""
    return value * (4.0 if at["bend"] > 50 else 1.0)


def test_depth_threshold_is_where_the_error_settles():
    steady = OfLaw("fig_5_5_sweeps", law, 100)
    steady.settings = experiment.SETTINGS
    found = report.numbers_fig_5_5({"fig_5_5_sweeps": steady})
    # (3000 / 2200)^0.3 is 1.098, (3000 / 1650)^0.3 is 1.196.
    assert found["fig5_5_depth_thr"].value == 2200
    assert found["fig5_5_slope2"].value == pytest.approx(0.0358, abs=1e-4)
    assert found["fig5_5_trials"].value == 100
