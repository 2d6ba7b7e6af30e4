"""Claims on plots of means are judged on medians, and in one more reading on means."""

import numpy as np
import pytest

from chapters.ch02_general_camera_model.s5_1_synthetic_data import report as sweeps
from chapters.ch03_planar_grids.s3_1_robustness.claims import judge_blur_limit
from chapters.ch04_central_generic.s1_5_simulated import report as simulated
from chapters.ch04_central_generic.s2_pose import claims as poses
from repro.judge.readings import open_questions
from repro.judge.statistics import ratio_of, wins
from tests.judged_claims import readings_of
from tests.made_results import ROOT, OfLaw

TRIALS = 50
NAME = "statistic_of_trials"
# Most trials fall a little, a few grow much: the median falls and the mean grows.
MEDIAN_FALLS = np.where(np.arange(TRIALS) % 10, 0.8, 20.0)
MEDIAN_GROWS = np.where(np.arange(TRIALS) % 10, 1.08, 0.01)


def spread(seed=0):
    return np.exp(0.05 * np.random.default_rng(seed).standard_normal(TRIALS))


def verdicts(judge, results):
    """Verdicts of the primary reading, and of the one on means."""
    found = {"median": [], "mean": []}
    for reading in readings_of(judge, results):
        found[reading.reading[NAME]].append(reading.verdict)
    (of_means,) = found["mean"]
    return found["median"][0], of_means


def of_fig_4_2(adjusted):
    """Fig. 4.2, where all errors are about 1 and the adjusted ones these multiples."""

    def law(name, condition):
        return spread() * (adjusted if ".ba." in name else 1.0)

    return {"fig_4_2_redrawn": OfLaw("fig_4_2_redrawn", law, TRIALS)}


@pytest.mark.parametrize(
    ("adjusted", "expected"),
    [
        (MEDIAN_FALLS, ("differs", "reproduced")),
        (MEDIAN_GROWS, ("reproduced", "differs")),
        (np.full(TRIALS, 1.2), ("reproduced", "reproduced")),
        (np.full(TRIALS, 0.8), ("differs", "differs")),
    ],
)
def test_rotations_follow_statistic(adjusted, expected):
    judge = simulated.judge_rotation_worse
    assert verdicts(judge, of_fig_4_2(adjusted)) == expected


def test_fig_4_2_comparisons_follow_statistic():
    apart, falls = of_fig_4_2(MEDIAN_FALLS), np.full(TRIALS, 0.4)
    assert verdicts(simulated.judge_points_better, apart) == ("reproduced", "differs")
    assert verdicts(simulated.judge_little_gain, apart)[1] == "differs"
    both = ("reproduced", "reproduced")
    assert verdicts(simulated.judge_points_better, of_fig_4_2(falls)) == both
    # In the mean CGSP is ahead, but it is behind in nearly all trials.
    judge = simulated.judge_beats_adjusted
    assert verdicts(judge, apart) == ("differs", "undecided")


def test_fig_4_4_poses_follow_statistic():
    def law(name, condition):
        return spread() * (MEDIAN_FALLS if name.startswith("cgsp_ransac") else 1.0)

    results = {"fig_4_4_noise": OfLaw("fig_4_4_noise", law, TRIALS)}
    assert verdicts(poses.judge_cgsp_better, results) == ("reproduced", "differs")

    def even(name, condition):
        outlier = np.where(np.arange(TRIALS) % 5, 1.0, 9.0)
        return outlier if name.startswith("cgsp_ransac") else np.ones(TRIALS)

    results = {"fig_4_4_noise": OfLaw("fig_4_4_noise", even, TRIALS)}
    assert verdicts(poses.judge_ransac_neutral, results) == ("reproduced", "differs")


# A few trials that went far wrong: nothing for the median, most of the mean.
FAR_OFF = np.where(np.arange(TRIALS) % 10, 1.0, 20.0)


@pytest.mark.parametrize(
    ("judge", "experiment", "name", "level"),
    [
        (sweeps.judge_noise_linear_generic, "fig_2_3_noise", "noise", 2.0),
        (sweeps.judge_noise_linear_parametric, "fig_2_3_noise", "noise", 2.0),
        (sweeps.judge_fov_generic_flat, "fig_2_3_fov", "fov_deg", 90),
        (sweeps.judge_modality_independent, "fig_2_3_laws", "law", "stereographic"),
    ],
)
def test_fig_2_3_claims_follow_statistic(judge, experiment, name, level):
    def law(column, condition):
        sizes = {"fig_2_3_noise": condition.get("noise"), "fig_2_3_laws": 1.0}
        size = sizes.get(experiment, 1.0)
        if column.startswith("parametric") and experiment == "fig_2_3_fov":
            size = 30.0
        hit = condition.get(name) == level or column.startswith(f"{level}.")
        exact = "exact" in column
        return size * spread() * (FAR_OFF if hit and not exact else 1.0)

    of_median, of_mean = verdicts(judge, {experiment: OfLaw(experiment, law, TRIALS)})
    assert of_median == "reproduced"
    assert of_mean in ("differs", "undecided")


def test_fig_2_3_rise_and_cause_follow_statistic():
    def law(column, condition):
        wide = condition["fov_deg"] == 150
        if column.endswith("grazing_spearman"):
            return np.full(TRIALS, 0.5)
        if column.startswith("exact") or not wide:
            return spread()
        fewer = np.where(np.arange(TRIALS) % 10, 1.0, 0.01)
        if condition["extent"] == "finite":
            return spread(1) * FAR_OFF
        return 1.5 * spread(2) * (fewer if "sd_px" in column else 1.0)

    results = {"fig_2_3_fov": OfLaw("fig_2_3_fov", law, TRIALS)}
    assert verdicts(sweeps.judge_infinite_plane_cause, results)[0] == "reproduced"
    assert verdicts(sweeps.judge_infinite_plane_cause, results)[1] != "reproduced"
    assert verdicts(sweeps.judge_fov_generic_150, results)[0] == "reproduced"


def test_fig_3_11_blur_follows_statistic():
    def law(name, condition):
        if not name.endswith("mean_px"):
            return np.ones(TRIALS)
        worse = np.where(np.arange(TRIALS) % 10, 1.0, 20.0)
        return spread() * (worse if condition["blur_px"] == 4 else 1.0)

    results = {"fig_3_11_blur": OfLaw("fig_3_11_blur", law, TRIALS)}
    assert verdicts(judge_blur_limit, results) == ("differs", "reproduced")


def test_mean_counts_failure_as_worst_value():
    a, b = np.array([1.0, 2.0, np.nan]), np.array([4.0, 1.0, 1.0])
    assert ratio_of("mean", a, b).value == pytest.approx((1 + 2 + 4) / (4 + 1 + 1))
    assert ratio_of("median", a, b).value == 2.0
    assert ratio_of("mean", [np.inf, 1.0], [1.0, 1.0]).value == 1.0


def test_wins_of_means_compare_means():
    a = spread() * MEDIAN_FALLS
    (of_medians,), (of_means,) = (wins([(a, spread(1))], s) for s in ("median", "mean"))
    assert of_medians.decision == "holds"
    assert of_means.decision == "fails"
    assert of_medians.p == of_means.p


def test_mean_is_combined_with_primary_options_only():
    entry = open_questions(ROOT)[NAME]
    for judge in (
        simulated.judge_beats_adjusted,
        poses.judge_cgsp_better,
        sweeps.judge_modality_independent,
        sweeps.judge_crossover,
    ):
        (mark,) = (m for m in judge.repro_marks if m["kind"] == "claim")
        assert set(mark["readings"]) - {NAME} <= set(entry["not_crossed_with"])
