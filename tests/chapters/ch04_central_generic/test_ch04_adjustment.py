"""Sections 4.1.3 and 4.1.4: their trials, and how their claims are judged."""

import numpy as np

from chapters.ch04_central_generic.s1_3_rays import experiment, report
from chapters.ch04_central_generic.s1_4_bundle_adjustment import experiment as schemes
from chapters.ch04_central_generic.s1_4_bundle_adjustment import report as claims
from tests.judged_claims import readings, readings_of, verdict
from tests.made_results import flat, of_seed

UNSTABLE = "exp_c4_centre_ba_unstable"


def test_stacked_rays_intersect_the_plane_with_correct_sign():
    found = of_seed(experiment.stacked_trial, [{}])
    assert found.column("printed").max() < 1e-12
    assert found.column("on_grid_mm").max() < 1e-7
    judge = report.judge_mats_intersection
    values = {"printed": 1e-15, "stacked": 0.0, "on_grid_mm": 0.0}
    name = "exp_c4_mats_intersection"
    assert verdict(judge, name, values) == "reproduced"
    # With the sign lost, coordinates differ by twice themselves.
    assert verdict(judge, name, values | {"printed": 2.0}) == "differs"


def test_closed_form_distance_and_number_of_unknowns():
    found = of_seed(schemes.formula_trial, [{}])
    assert found.column("largest_mm")[0] < 1e-11
    counts = of_seed(schemes.unknowns_trial, [{"grids": n} for n in schemes.GRIDS])
    results = {"exp_c4_ba_param_count": counts}
    (reading,) = readings_of(claims.judge_param_count, results)
    assert reading.verdict == "reproduced"
    values = claims.values_of_adjustment(results)
    assert (values["s4_1_4_ba"].value, values["s4_1_4_ray"].value) == ("6*(n-1)", 2)


def test_consistent_adjustment_is_independent_of_the_start():
    found = flat(schemes.starts_trial({"starts": 4}, np.random.default_rng(0)))
    assert found["consistent.spread_over_starts"] < 1e-2
    assert 0.3 < found["consistent.spread_over_draws"] < 1.5
    assert found["line_fitting.spread_over_draws"] > 2
    assert found["line_fitting.starts_mm"].shape == (4,)


def judged(**values):
    """Verdicts of the claim on a centre that is freed, by reading."""
    plain = {
        f"{scheme}.{name}": value
        for scheme in ("line_fitting", "ray_point")
        for name, value in values.items()
    }
    found = readings(claims.judge_centre_ba_unstable, UNSTABLE, plain)
    return {tuple(r.reading.values()): r.verdict for r in found}


def test_free_centre_claim_uses_costs_and_positions():
    calm = {
        "above_best": np.zeros(20),
        "spread_over_starts": np.ones(20),
        "spread_over_draws": np.ones(20),
    }
    assert set(judged(**calm).values()) == {"differs"}
    assert set(judged(**calm | {"above_best": np.full(20, 0.3)}).values()) == {
        "reproduced"
    }
    spread = judged(**calm | {"spread_over_starts": np.linspace(20, 30, 20)})
    assert {s for (_, s), v in spread.items() if v == "reproduced"} == {"over starts"}
    half = judged(**calm | {"spread_over_starts": np.tile([1.0, 30.0], 10)})
    assert half["ray-point distances", "over starts"] == "undecided"
