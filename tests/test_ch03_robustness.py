"""How a CELECT run is scored, and what the sweeps of 3.3.1 say of their limits."""

from types import SimpleNamespace

import numpy as np
import pytest

from chapters.ch03_planar_grids.s3_1_robustness.claims import (
    judge_detect_below_basin,
    judge_fisheye_fail,
    rate,
)
from chapters.ch03_planar_grids.s3_1_robustness.results import (
    SWEEPS,
    blur_that_hurts,
    bracketed,
    first_lost,
    levels_of,
    limit,
)
from chapters.shared.scoring import missing_on, scored

LATTICE = np.stack(np.meshgrid(np.arange(4) * 20.0, np.arange(3) * 20.0), axis=2)


def contour(name, merged):
    return SimpleNamespace(name=name, merged=np.asarray(merged, float).reshape(-1, 2))


def run(corners=None, contours=(), failures=()):
    return SimpleNamespace(
        found=corners is not None,
        corners=corners,
        contours=contours,
        failures=failures,
    )


def test_missing_corners_are_those_without_a_find_within_8_px():
    found = LATTICE[:, 1].copy()
    found[1] += [8.5, 0]
    assert missing_on(contour("column 2", found), LATTICE) == (1, 0)
    assert missing_on(contour("side 1", []), LATTICE) == (4, 4)
    assert missing_on(contour("column 2", []), LATTICE) == (3, 2)


def test_a_run_succeeds_only_if_every_corner_is_within_8_px():
    corners = LATTICE.copy()
    corners[1, 1] += [0, 7.9]
    assert scored(run(corners), LATTICE)["success"]
    assert scored(run(corners), LATTICE)["max_px"] == pytest.approx(7.9)
    corners[1, 1] += [0, 0.2]
    lost = scored(run(corners), LATTICE)
    assert not lost["success"]
    assert "max_px" not in lost


def test_a_run_that_was_given_up_names_its_stage():
    failure = SimpleNamespace(stage="tracing", contour="side 2")
    values = scored(
        run(failures=[failure], contours=[contour("side 1", LATTICE[0, :3])]), LATTICE
    )
    assert (values["stage"], values["contour"]) == ("tracing", "side 2")
    assert (values["missed"], values["missed_on_rim"]) == (1, 1)


class Sweep:
    """Results along one nuisance, made up."""

    def __init__(self, name, successes, means=None):
        self.name, self.successes, self.means = name, successes, means
        self.conditions = [{name: level, "levels": "full range"} for level in successes]

    def column(self, value, **condition):
        which = self.successes if value == "success" else self.means
        return np.atleast_1d(np.asarray(which[condition[self.name]], float))


def test_the_limit_is_bracketed_by_the_last_whole_and_the_first_lossy_level():
    sweep = Sweep("noise_sd", {0: [1, 1], 10: [1, 1], 20: [1, 0], 30: [1, 1]})
    assert levels_of(sweep, "noise_sd").tolist() == [0, 10, 20, 30]
    assert first_lost(sweep, "noise_sd") == 2
    assert limit(sweep, "noise_sd") == (10.0, 20.0)
    assert limit(Sweep("noise_sd", {0: [1], 10: [1]}), "noise_sd") == (10.0, np.inf)


def test_a_limit_that_is_not_reached_is_the_last_level_and_says_so():
    value = bracketed(100.0, np.inf, "grey levels", "first loss")
    assert (value.value, value.interval) == (100.0, (100.0, 100.0))
    assert "not reached" in value.reason
    assert bracketed(-np.inf, 5.0, "deg", "first loss").interval == (0.0, 5.0)


def test_a_few_trials_leave_a_share_open():
    few, many = (Sweep("yaw_deg", {0: [1] * count}) for count in (25, 50))
    assert rate(few, yaw_deg=0).above(0.9) == "undecided"
    assert rate(many, yaw_deg=0).above(0.9) == "holds"


def test_blur_hurts_by_losses_or_by_larger_errors():
    whole = {0: [1, 1], 1: [1, 1], 2: [1, 1], 3: [1, 1]}
    errors = {0: [9, 9], 1: [1, 1], 2: [1.2, 1.2], 3: [1.3, 1.3]}
    assert blur_that_hurts(Sweep("blur_px", whole, errors)) == (2.0, 3.0)
    lossy = whole | {2: [1, 0]}
    assert blur_that_hurts(Sweep("blur_px", lossy, errors)) == (1.0, 2.0)


def test_printed_sd_of_the_clicks_is_the_variance_of_their_law():
    rng = np.random.default_rng(3)
    mean = 0.77
    lengths = np.hypot(*rng.normal(0, mean / np.sqrt(np.pi / 2), (2, 200000)))
    assert lengths.std() == pytest.approx(mean * np.sqrt(4 / np.pi - 1), rel=0.01)
    assert lengths.var() == pytest.approx(0.16, abs=0.005)


class Fovs(Sweep):
    """A sweep of fields of view, whose failed trials name a contour."""

    def column(self, name, **condition):
        if name == "success":
            return super().column(name, **condition)
        return np.array(self.values[name][condition["fov_deg"]])

    def texts(self, name, **condition):
        return self.values[name][condition["fov_deg"]]


def rim_readings(contour, on_rim):
    trials = 40
    fovs = Fovs("fov_deg", {134: [1] * trials, 152: [0] * trials})
    fovs.values = {
        "missed": {152: [4.0] * trials},
        "missed_on_rim": {152: [float(on_rim)] * trials},
        "contour": {152: [contour] * trials},
    }
    readings = judge_fisheye_fail({"fig_3_11_fov": fovs})
    return {r.reading["rim_losses"]: r.verdict for r in readings}


def test_losses_on_sides_say_nothing_of_where_boards_break():
    assert rim_readings("side 2", 4) == {
        "all trials": "reproduced",
        "trials that lost no side": "undecided",
    }
    assert set(rim_readings("column 3", 4).values()) == {"reproduced"}
    assert set(rim_readings("column 3", 1).values()) == {"differs"}


class Levels(Sweep):
    """Ten levels, the last three of which have a failed trial beside a good one."""

    def column(self, value, **condition):
        return np.array([2.0, np.nan if condition[self.name] >= 7 else 3.0])


def test_failed_trials_of_a_level_count_as_the_worst_or_are_left_out():
    results = {
        f"fig_3_11_{sweep}": Levels(name, dict.fromkeys(range(10)))
        for sweep, name in SWEEPS.items()
    }
    readings = {
        r.reading["failed_trials_of_a_level"]: (r.verdict, r.regenerated)
        for r in judge_detect_below_basin(results)
    }
    assert readings == {
        "count as the worst": ("differs", 0.7),
        "left out": ("reproduced", 1.0),
    }
