"""How a CELECT run is scored, and what the sweeps of 3.3.1 say of their limits."""

from types import SimpleNamespace

import numpy as np
import pytest

from chapters.ch03_planar_grids.s3_1_robustness.claims import (
    judge_detect_below_basin,
    judge_small_square_fail,
    rate,
    reliable_up_to,
)
from chapters.ch03_planar_grids.s3_1_robustness.experiment import (
    SMOOTHINGS,
    by_smoothing,
    gaps,
    largest_in_order,
    merging_trial,
)
from chapters.ch03_planar_grids.s3_1_robustness.report import (
    PRIMARY,
    SWEEPS,
    Under,
    bracketed,
    degrading_blur,
    full_range_levels,
    limit,
)
from chapters.shared.grids.detectors import scored
from tests.judged_claims import readings_of
from tests.made_results import OfLaw, of_columns

LATTICE = np.stack(np.meshgrid(np.arange(4) * 20.0, np.arange(3) * 20.0), axis=2)


def run(corners=None, contours=(), failures=()):
    return SimpleNamespace(
        found=corners is not None, corners=corners, contours=contours, failures=failures
    )


def test_run_succeeds_if_every_corner_is_within_8_px():
    corners = LATTICE.copy()
    corners[1, 1] += [0, 7.9]
    assert scored(run(corners), LATTICE)["success"]
    assert scored(run(corners), LATTICE)["max_px"] == pytest.approx(7.9)
    corners[1, 1] += [0, 0.2]
    lost = scored(run(corners), LATTICE)
    assert not lost["success"]
    assert "max_px" not in lost


def swept(name, successes, means=None):
    """Results along one nuisance, made up: {level: value of each trial}."""
    return of_columns(
        *(
            (
                {name: level, "levels": "full range"},
                {
                    f"{smoothing}{what}": of[level]
                    for smoothing in ("", "0.7 px.")
                    for what, of in (("success", successes), ("mean_px", means))
                    if of
                },
            )
            for level in successes
        )
    )


def test_limit_is_between_last_complete_and_first_lossy_level():
    sweep = swept("noise_sd", {0: [1, 1], 10: [1, 1], 20: [1, 0], 30: [1, 1]})
    assert limit(sweep, "noise_sd") == (10.0, 20.0)
    assert limit(swept("noise_sd", {0: [1], 10: [1]}), "noise_sd") == (10.0, np.inf)


def test_unreached_limit_is_the_last_level():
    value = bracketed(100.0, np.inf, "grey levels", "first loss")
    assert (value.value, value.interval) == (100.0, (100.0, 100.0))
    assert "not reached" in value.reason
    assert bracketed(-np.inf, 5.0, "deg", "first loss").interval == (0.0, 5.0)


def test_few_trials_leave_a_share_undecided():
    few, many = (swept("yaw_deg", {0: [1] * count}) for count in (25, 50))
    assert rate(few, yaw_deg=0).above(0.9) == "undecided"
    assert rate(many, yaw_deg=0).above(0.9) == "holds"


def test_blur_limit_counts_losses_and_larger_errors():
    whole = {0: [1, 1], 1: [1, 1], 2: [1, 1], 3: [1, 1]}
    errors = {0: [9, 9], 1: [1, 1], 2: [1.2, 1.2], 3: [1.3, 1.3]}
    assert degrading_blur(swept("blur_px", whole, errors)) == (2.0, 3.0)
    lossy = whole | {2: [1, 0]}
    assert degrading_blur(swept("blur_px", lossy, errors)) == (1.0, 2.0)


def test_primary_smoothing_is_the_first_and_has_no_prefix():
    result = of_columns(({}, {"success": 1.0, "0.7 px.success": 0.0}))
    assert next(iter(SMOOTHINGS)) == PRIMARY
    assert Under(result, PRIMARY).column("success") == [1.0]
    assert Under(result, "0.7 px").column("success") == [0.0]
    assert by_smoothing(lambda settings: {"px": settings.smoothing_limits_px}) == {
        "px": (0.5, 1.5),
        "0.7 px": {"px": (0.7, 0.7)},
    }


def test_yaw_limit_requires_all_smaller_yaws():
    sweep = swept("yaw_deg", {0: [1] * 9, 40: [1] * 9, 44: [0] * 9, 48: [1] * 9})
    assert reliable_up_to(sweep, "yaw_deg", 0.9) == 40
    assert reliable_up_to(swept("yaw_deg", {0: [0]}), "yaw_deg", 0.9) == 0


def grid(**moved):
    """A CELECT result with the true corners, some of them moved."""
    corners = LATTICE.copy()
    for place, step in moved.items():
        corners[tuple(map(int, place[1:]))] += step
    return run(corners)


def test_complete_ordered_grid_has_its_largest_error():
    assert largest_in_order(grid(c11=[0, 9.5]), LATTICE) == pytest.approx(9.5)
    assert not scored(grid(c11=[0, 9.5]), LATTICE)["success"]
    assert largest_in_order(grid(c11=[0, 10.5]), LATTICE) is None
    assert largest_in_order(run(), LATTICE) is None


def ten_levels(name):
    """Ten levels, the last three of which have a failed trial and a good one."""
    return OfLaw(
        [{name: level, "levels": "full range"} for level in range(10)],
        lambda value, condition: [2.0, np.nan if condition[name] >= 7 else 3.0],
        2,
    )


def test_failed_trials_count_as_worst_or_are_excluded():
    results = {f"fig_3_11_{sweep}": ten_levels(name) for sweep, name in SWEEPS.items()}
    readings = {
        r.reading["failed_trials_of_a_level"]: (r.verdict, r.regenerated)
        for r in readings_of(judge_detect_below_basin, results)
    }
    assert readings == {
        "count as the worst": ("differs", 0.7),
        "left out": ("reproduced", 1.0),
    }


def test_level_shared_by_sweeps_counts_once():
    def sweep(levels):
        conditions = [{"x": x, "levels": option} for x, option in levels]
        return of_columns(*((condition, {}) for condition in conditions))

    full, half = "full range", "half range"
    sweeps = {"a": sweep([(0, full), (1, full), (1, half)]), "b": sweep([(1, full)])}
    found = [(condition["x"]) for _, condition in full_range_levels(sweeps)]
    assert found == [0, 1]


@pytest.mark.parametrize(
    ("right", "verdict"),
    [
        ({5: [1], 10: [1], 20: [0], 40: [0]}, "reproduced"),
        ({5: [0], 10: [1], 20: [0], 40: [1]}, "differs"),
        ({5: [1], 10: [1], 20: [1], 40: [1]}, "differs"),
    ],
)
def test_success_has_to_rise_with_square_size(right, verdict):
    results = {"fig_3_11_square": swept("squares_across", right)}
    found = readings_of(judge_small_square_fail, results)
    assert {r.verdict for r in found} == {verdict}


def test_gaps_are_between_candidates_of_neighbouring_corners():
    truth = np.array([[0.0, 0.0], [30.0, 0.0], [60.0, 0.0]])
    split = np.array([[-5.0, 0], [5, 0], [25, 0], [35, 0]])
    assert gaps(split, truth)[0] == 20
    assert np.isnan(gaps(split, truth)[1])


def test_rotated_board_loses_corners_split_by_blur():
    """29 px apart, with 19 px for t8: only their split neighbours can be merged."""
    found = merging_trial({"yaw_deg": 40}, None)
    weak = found["0.7 px"]
    assert found["step_px"] > 1.4 * found["t8_px"]
    assert found["gap_px"] < found["t8_px"] < weak["gap_px"]
    assert (found["corners"], weak["corners"]) == (8, 9)
    owner = np.linalg.norm(found["candidates"] - found["truth"][-1], axis=1)
    assert owner[owner < 8].min() > 5
