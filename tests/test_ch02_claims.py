"""The tests of the claims about Fig. 2.3 decide as the ledger words them."""

import numpy as np
import pytest

from chapters.ch02_general_camera_model.s5_1_synthetic_data import claims
from chapters.ch02_general_camera_model.s5_1_synthetic_data import (
    results as s5_1_results,
)
from chapters.ch02_general_camera_model.s5_2_real_data import claims as s5_2_claims
from chapters.ch02_general_camera_model.s5_2_real_data import results as s5_2_results
from chapters.ch02_general_camera_model.s5_2_real_data import tables as s5_2_tables
from chapters.ch02_general_camera_model.s5_3_distortion_correction import (
    claims as s5_3_claims,
)
from chapters.ch02_general_camera_model.s5_3_distortion_correction import (
    results as s5_3_results,
)
from chapters.shared.three_planes import FOVS_DEG

TRIALS = 50


class Trials:
    """Stands for a Result: values by name and condition, the same in any reading."""

    def __init__(self, values):
        self.values = values

    def column(self, name, **condition):
        return np.asarray(self.values(name, condition), float)


def spread_about(middle, share=0.05, seed=0):
    return middle * (1 + share * np.random.default_rng(seed).standard_normal(TRIALS))


def verdicts(judge, experiment, values):
    return {r.verdict for r in judge({experiment: Trials(values)})}


def along_the_sweep(parametric, generic):
    """Values of two methods, each a function of the field of view."""

    def values(name, condition):
        fov = condition["fov_deg"]
        one = parametric if name.startswith("parametric") else generic
        return one(fov)

    return values


def crossover(parametric, generic):
    values = along_the_sweep(parametric, generic)
    return verdicts(claims.judge_crossover, "fig_2_3_fov", values)


def flat(fov):
    return spread_about(0.5, seed=fov)


def rising(fov):
    return spread_about(0.1 * (fov / 60) ** 4, seed=1000 + fov)


def test_crossover_holds_for_one_crossing():
    assert crossover(rising, flat) == {"reproduced"}


def test_crossover_differs_where_one_method_is_better_everywhere():
    assert crossover(lambda fov: 10 * rising(fov) + 1, flat) == {"differs"}


def test_crossover_differs_for_three_sign_changes():
    def winding(fov):
        return rising(fov) * (100 if fov == 45 else 1)

    assert crossover(winding, flat) == {"differs"}


def test_crossover_is_undecided_where_the_last_level_is_a_tie():
    def tied(fov):
        return flat(fov)[::-1] if fov == 150 else 0.1 * flat(fov)

    assert crossover(tied, flat) == {"undecided"}


def test_failed_trials_count_as_the_worst_in_the_signs():
    def failing(fov):
        found = flat(fov)
        # At three levels in the middle most trials fail; what is left is good.
        if 90 <= fov <= 120:
            found[:40] = np.nan
        return found

    def low_then_high(fov):
        return spread_about(0.1 if fov < 90 else 1.0, seed=fov)

    assert crossover(low_then_high, flat) == {"reproduced"}
    readings = claims.judge_crossover(
        {"fig_2_3_fov": Trials(along_the_sweep(low_then_high, failing))}
    )
    assert {r.regenerated for r in readings} == {
        "parametric better, generic from 135 deg on"
    }


@pytest.mark.parametrize(
    ("middle", "verdict"),
    [(3.0, "reproduced"), (1.0, "differs"), (1.48, "undecided")],
)
def test_peripheral_noise_is_asked_of_infinite_planes_only(middle, verdict):
    def values(name, condition):
        assert name == "point_noise_ratio"
        assert condition == {"domain": "px", "extent": "unbounded", "fov_deg": 150}
        return spread_about(middle)

    readings = claims.judge_peripheral_noise({"fig_2_3_fov": Trials(values)})
    assert [(r.reading, r.verdict) for r in readings] == [({}, verdict)]


def proportional(law):
    def values(name, condition):
        return spread_about(law(condition["noise"]), seed=int(1e3 * condition["noise"]))

    return verdicts(claims.judge_noise_linear_parametric, "fig_2_3_noise", values)


def test_proportion_holds_for_a_line_and_not_for_a_root():
    assert proportional(lambda noise: 1.25 * noise) == {"reproduced"}
    assert proportional(np.sqrt) == {"differs"}


def rising_with_level(parametric, generic):
    """The three sets at levels 0.1, 0.3 and 0.7, errors rising exponentially."""
    levels = {1: 0.1, 2: 0.3, 3: 0.7}

    def values(name, condition):
        level = levels[condition["zoom"]]
        if name == "distortion_level":
            return np.full(TRIALS, level)
        slope = parametric if name.startswith("parametric") else generic
        return spread_about(np.exp(slope * level), 0.01, condition["zoom"])

    return Trials(values)


@pytest.mark.parametrize(
    ("sets", "verdict"), [((5.0, 0.5), "reproduced"), ((5.0, 3.0), "differs")]
)
def test_real_and_simulated_agree_only_where_both_halves_hold(sets, verdict):
    """Generic error flat over covered angles, whatever field of view was asked."""

    def values(name, condition):
        covered = min(condition["fov_deg"] / 2, 50.0)
        if name == "widest_angle_deg":
            return np.full(TRIALS, covered)
        slope = 5.0 if name.startswith("parametric") else 0.5
        level = s5_2_results.distortion_level(covered)
        return spread_about(np.exp(slope * level), 0.01, condition["fov_deg"])

    readings = s5_2_claims.judge_depends_on_distortion(
        {"fig_2_3_fov": Trials(values), "table_2_2_redrawn": rising_with_level(*sets)}
    )
    assert {r.verdict for r in readings} == {verdict}
    assert readings[0].regenerated == pytest.approx(0.5, abs=0.1)
    # Every question about Fig. 2.3 and about Table 2.2: two options each, of the
    # scoring three.
    assert len(readings) == 3 * 2**6


def test_distortion_level_of_the_equidistance_law():
    # r / r_pinhole = f theta / (f tan theta), smallest at the widest angle.
    assert s5_2_results.distortion_level(45) == pytest.approx(1 - np.pi / 4)
    levels = [s5_2_results.distortion_level(fov / 2) for fov in FOVS_DEG]
    assert np.all(np.diff(levels) > 0)


def of_zoom(parametric, generic):
    """Residuals of the three sets, the same in every reading."""

    def values(name, condition):
        which = parametric if name.startswith("parametric") else generic
        return which(condition["zoom"])

    return Trials(values)


@pytest.mark.parametrize(("growth", "verdict"), [(1.05, "reproduced"), (2, "differs")])
def test_generic_residuals_of_the_sets_are_flat_or_not(growth, verdict):
    made = of_zoom(None, lambda zoom: spread_about(growth**zoom, 0.01, zoom))
    readings = s5_2_claims.judge_generic_flat({"table_2_2_redrawn": made})
    assert {r.verdict for r in readings} == {verdict}
    assert len(readings) == 16


def test_a_failed_generic_seed_counts_against_it():
    generic = np.full(TRIALS, 1.0)
    generic[:6] = np.nan
    made = of_zoom(lambda zoom: np.full(TRIALS, 2.0), lambda zoom: generic)
    readings = s5_2_claims.judge_parametric_worse({"table_2_2_redrawn": made})
    assert {r.verdict for r in readings} == {"differs"}
    assert readings[0].regenerated == pytest.approx(0.88)


@pytest.mark.parametrize(("inner", "verdict"), [(-0.4, "reproduced"), (0.4, "differs")])
def test_radial_bias_must_turn_round(inner, verdict):
    def values(name, condition):
        if name.endswith(".p"):
            return np.full(TRIALS, 1e-5)
        outer = name.endswith(("q4.mean_px", "q5.mean_px"))
        return np.full(TRIALS, 0.5 if outer else inner)

    made = {"table_2_2_redrawn": Trials(values)}
    assert {r.verdict for r in s5_2_claims.judge_radial_bias(made)} == {verdict}


@pytest.mark.parametrize(("bias", "verdict"), [(0.2, "reproduced"), (0.3, "differs")])
def test_no_radial_bias_is_a_quarter_of_the_rms_at_most(bias, verdict):
    def values(name, condition):
        return np.full(TRIALS, 1.0 if name.endswith("rms_px") else -bias)

    made = {"table_2_2_redrawn": Trials(values)}
    assert {r.verdict for r in s5_2_claims.judge_no_radial_bias(made)} == {verdict}


@pytest.mark.parametrize(
    ("p", "ratio", "verdict"),
    [(0.001, 0.5, "reproduced"), (0.5, 0.5, "differs"), (0.001, 0.95, "differs")],
)
def test_a_systematic_part_needs_neighbours_and_the_centre(p, ratio, verdict):
    made = {
        "table_2_2_redrawn": Trials(lambda name, condition: np.full(TRIALS, p)),
        "fig_2_5_true_centre": Trials(lambda name, condition: spread_about(ratio)),
    }
    assert {r.verdict for r in s5_2_claims.judge_systematic(made)} == {verdict}


def scatter(better, missing):
    def values(name, condition):
        middle = better if name.startswith("parametric") else 1.0
        found = spread_about(middle, 0.1, len(name))
        found[:missing] = np.nan
        return found

    return {"table_2_2_redrawn": Trials(values)}


@pytest.mark.parametrize(("better", "verdict"), [(3.0, "reproduced"), (0.5, "differs")])
def test_motion_is_won_by_the_smaller_scatter(better, verdict):
    readings = s5_2_claims.judge_motion(scatter(better, missing=0))
    assert {r.verdict for r in readings} == {verdict}


def test_a_failed_seed_of_the_stage_counts_against_the_method_that_failed():
    readings = s5_2_claims.judge_motion(scatter(3.0, missing=2))
    assert {r.verdict for r in readings} == {"reproduced"}
    assert "2 failed with the parametric" in readings[0].reason
    generic_fails = scatter(3.0, missing=0)["table_2_2_redrawn"].values

    def values(name, condition):
        found = generic_fails(name, condition)
        if not name.startswith("parametric"):
            found[:40] = np.nan
        return found

    readings = s5_2_claims.judge_motion({"table_2_2_redrawn": Trials(values)})
    assert {r.verdict for r in readings} == {"differs"}
    assert "40 with the generic" in readings[0].reason


def test_failed_trials_of_the_true_centre_are_told():
    ratios = spread_about(0.5)
    ratios[:3] = np.nan
    made = {
        "table_2_2_redrawn": Trials(lambda name, condition: np.full(TRIALS, 0.001)),
        "fig_2_5_true_centre": Trials(lambda name, condition: ratios),
    }
    assert "3 failed" in s5_2_claims.judge_systematic(made)[0].reason


def of_set_2(columns):
    return Trials(lambda name, condition: columns[name.rpartition(".")[2]])


def test_prose_of_the_real_data_counts_failures_and_corners_left_out():
    assert s5_2_results.typical(np.array([1.0, np.nan, np.nan])) == np.inf
    corners = s5_2_results.true_shape(3)[0]
    made = of_set_2({"left_out": [10.0, np.nan], "boards": [2.0, np.nan]})
    assert s5_2_results.share_left_out(made, 3) == pytest.approx(10 / (2 * corners))


def test_the_range_of_rendered_seeds_is_not_called_an_interval():
    made = Trials(lambda name, condition: spread_about(2.0)[:3])
    made.trials_per_condition = 3
    results = dict.fromkeys(s5_2_tables.SOURCES, made)
    assert "3 seeds, too few for an interval" in s5_2_tables.table_2_2(results).caption


def test_redrawn_seeds_are_not_called_equal_to_rendered_ones():
    redrawn, rendered = (
        Trials(lambda name, condition, n=n: spread_about(2.0)[:n]) for n in (50, 3)
    )
    check = s5_2_tables.agreement(redrawn, rendered)
    assert check.holds
    assert "no difference shown" in check.text
    assert "times those of 3 rendered" in check.text
    other = Trials(lambda name, condition: spread_about(9.0)[:3])
    assert not s5_2_tables.agreement(redrawn, other).holds


@pytest.mark.parametrize(("better", "verdict"), [(3.0, "reproduced"), (0.5, "differs")])
def test_periphery_is_won_by_straighter_lines(better, verdict):
    def values(name, condition):
        found = spread_about(better if ".parametric." in name else 1.0, 0.1, len(name))
        found[0] = np.nan
        return found

    readings = s5_3_claims.judge_periphery({"table_2_2_redrawn": Trials(values)})
    assert {r.verdict for r in readings} == {verdict}
    assert "1 failed with the parametric" in readings[0].reason
    made = Trials(lambda name, condition: [1.0, np.nan, np.nan])
    assert s5_3_results.line_median(made, "generic") == np.inf


def test_projection_laws_are_compared_trial_by_trial():
    """Trials that differ more than the laws do; the corrected view stretches them."""
    shared = spread_about(1.0, share=0.5, seed=7)

    def values(name, condition):
        law, *_, scale, quantity = name.split(".")
        assert quantity == "mean_px"
        stretched = 1.2 if scale == "corrected" else 1.02
        return shared * (stretched if law == "perspective" else 1.0)

    readings = claims.judge_modality_independent({"fig_2_3_laws": Trials(values)})
    assert len(readings) == 3 * 2**4
    verdicts = {"source image": "reproduced", "corrected view": "differs"}
    for reading in readings:
        assert reading.verdict == verdicts[reading.reading["law_pixels"]]
    assert readings[0].reading["law_pixels"] == "source image"


def at_150(stretch, own, grazing):
    """Residuals that grow from 120 to 150 degrees on unbounded planes.

    Those of exact rays by ``stretch`` in the corrected view, the generic ones by
    ``own`` besides; rank correlation with the grazing angle in the source image.
    """

    def values(name, condition):
        method, *_, scale, quantity = name.split(".")
        if quantity == "grazing_spearman":
            return spread_about(grazing if scale == "source" else 0.9)
        wide = condition["fov_deg"] == 150 and condition["extent"] == "unbounded"
        factor = stretch if wide and scale == "corrected" else 1.0
        if method != "exact":
            factor *= own if wide else 1.0
        return spread_about(factor, 0.01, seed=len(name) + condition["fov_deg"])

    return {"fig_2_3_fov": Trials(values)}


def of_primary(readings):
    """The verdict of the first reading: every first option is the primary one."""
    return readings[0].verdict


@pytest.mark.parametrize(
    ("stretch", "own", "verdict"),
    [(1.3, 1.1, "reproduced"), (1.3, 0.95, "differs"), (1.0, 0.9, "differs")],
)
def test_a_rise_at_150_degrees_must_be_more_than_that_of_exact_rays(
    stretch, own, verdict
):
    readings = claims.judge_fov_generic_150(at_150(stretch, own, 0.0))
    assert of_primary(readings) == verdict
    assert "over the ratios of exact rays" in readings[0].reason


@pytest.mark.parametrize(
    ("own", "grazing", "verdict"),
    [(1.2, 0.5, "reproduced"), (1.2, 0.1, "differs"), (0.9, 0.5, "differs")],
)
def test_the_stretch_of_the_view_does_not_pass_for_grazing_rays(own, grazing, verdict):
    readings = claims.judge_infinite_plane_cause(at_150(1.3, own, grazing))
    assert of_primary(readings) == verdict


@pytest.mark.parametrize(
    ("better", "words", "crossing"),
    [
        ((), "nowhere", (150, 150)),
        ((120, 150), "from 120° on", (30, 120)),
        ((30, 120), "at 30° and 120° only", (150, 150)),
        ((30, 120, 150), "everywhere", (30, 30)),
    ],
)
def test_prose_says_where_the_generic_method_is_ahead(better, words, crossing):
    def values(name, condition):
        generic = 1.0 if condition["fov_deg"] in better else 3.0
        return [2.0 if name.startswith("parametric.fresh.corrected") else generic]

    fov = Trials(values)
    fov.conditions = [{"fov_deg": at} for at in (150, 120, 30)]
    of_words = s5_1_results.ahead(fov, "generic_as_printed", "fresh.corrected")
    assert of_words == words
    assert s5_1_results.crossing(fov, "generic_as_printed") == crossing


def test_residuals_are_told_as_multiples_of_those_of_exact_rays():
    def values(name, condition):
        return [2.0, 4.0] if name == "exact.corrected.mean_px" else [3.0, 8.0]

    found = s5_1_results.trials_of(Trials(values), "parametric", "over_exact")
    assert found.tolist() == [1.5, 2.0]


def test_numbers_of_the_prose_count_failed_trials_as_the_worst():
    half = Trials(lambda name, condition: [1.0, 2.0, np.nan, np.nan, 9.0])
    assert s5_1_results.median_of(half, "method", "any") == 9.0
