"""Cells and steps of an active grid: the theory, and what it is compared with."""

import numpy as np
import pytest

from chapters.ch03_planar_grids.ext_cells_and_phases import results, trials
from chapters.ch03_planar_grids.ext_cells_and_phases.results import (
    BY_PIXEL,
    SMOOTHED,
    bias_px,
    sigma_px,
)
from raxel.sets.patterns import patterns_of
from repro.run.outcomes import Plan
from tests.made_results import of_columns, written

WIDTH_PX = trials.WIDTH_PX["quick"]


@pytest.fixture(scope="module")
def view():
    return trials.drawn_view(WIDTH_PX, np.random.default_rng(0))


def test_the_best_cell_is_two_pi_blurs_wide_and_noise_does_not_move_it():
    periods = np.linspace(5, 60, 5501)
    for blur in (1.0, 2.5, 6.0):
        for noise in (1.0, 8.0):
            best = periods[np.argmin(sigma_px(periods, blur, noise, 4))]
            assert best == pytest.approx(2 * np.pi * blur, abs=0.01)


@pytest.mark.parametrize("cells", [4, 8])
def test_errors_and_stated_sigma_are_those_of_the_theory(view, cells):
    rng = np.random.default_rng(cells)
    plan = trials.plan_for(cells, 4)
    light = trials.through_lens(view.values(plan), 1.0)
    found = trials.scores(view, plan, trials.photographs(light, 2.0, rng), linear=True)
    period = trials.period_px(cells, WIDTH_PX)
    for way, tolerance in ((BY_PIXEL, 0.03), (SMOOTHED, 0.12)):
        theory = sigma_px(period, 1.0, 2.0, 4, way)
        # 5000 pixels; smoothed ones share their windows, so that few are independent.
        assert found[way]["rms_px"] == pytest.approx(theory, rel=tolerance)
        assert found[way]["sigma_px"] == pytest.approx(theory, rel=0.05)
        assert found[way]["gross"] == 0
        assert found[way]["decoded"] > 0.99


def test_the_response_disturbs_by_the_orders_of_the_appendix():
    """Gamma 2 has a second order of a quarter of the first, and no third."""
    quarter = sum(0.25 ** (2 * k) / (2 * k**2) for k in range(1, 9)) ** 0.5
    assert bias_px(2 * np.pi, 0.0, 2.0, 3) == pytest.approx(quarter, rel=1e-6)
    for steps in (4, 5, 6, 8):
        assert bias_px(40.0, 0.0, 2.0, steps) < 1e-9
    assert bias_px(40.0, 0.0, 2.2, 6) < bias_px(40.0, 0.0, 2.2, 4) / 5
    assert bias_px(40.0, 8.0, 2.2, 4) < bias_px(40.0, 0.0, 2.2, 4) / 100


def test_a_monitor_that_is_not_linear_shifts_phases_as_the_theory_says(view):
    plan = trials.plan_for(4, 3)
    light = trials.light_of(view.values(plan), plan, 1.2)
    rng = np.random.default_rng(0)
    pictures = trials.photographs(trials.through_lens(light, 0.5), 0.0, rng)
    found = trials.scores(view, plan, pictures, linear=True)[BY_PIXEL]
    theory = bias_px(trials.period_px(4, WIDTH_PX), 0.5, 1.2, 3)
    assert found["rms_px"] == pytest.approx(theory, rel=0.05)
    assert found["within"] < 0.3


def test_equal_pictures_are_counted_right():
    for cells, steps in [*trials.BUDGETS[20], *trials.BUDGETS[28], (24, 5)]:
        plan = trials.plan_for(cells, steps)
        assert trials.pictures_of(cells, steps) == len(patterns_of(plan))
    for total, grids in trials.BUDGETS.items():
        assert {trials.pictures_of(*grid) for grid in grids} == {total}


def test_light_is_shared_out_as_said():
    """Noise of an even field: as the root of its steps' share of the light."""
    even = np.full((1, 100, 100), 0.5)
    alike, sines, light = (
        {
            steps: np.std(
                trials.pictures_in_light(
                    even, trials.plan_for(8, steps), which, np.random.default_rng(1)
                )
            )
            for steps in (4, 8)
        }
        for which in trials.LIGHTS
    )
    assert alike[8] == pytest.approx(alike[4])
    assert light[8] / light[4] == pytest.approx(2**0.5, rel=0.05)
    assert sines[8] / sines[4] == pytest.approx(2**0.5, rel=0.05)
    assert sines[4] / alike[4] == pytest.approx(6**-0.5, rel=0.05)


def three_grids():
    """Results of three grids: the finest is best, and cannot be read."""
    values = {
        8: {"rms_px": [0.2, 0.3], "decoded": [1, 1]},
        16: {"rms_px": [0.1, 0.12], "decoded": [0.995, 1]},
        32: {"rms_px": [0.01, 0.01], "decoded": [1, 0.98]},
    }
    case = f"{trials.name_of(trials.LINEAR, 1.0, 3.0)}.{BY_PIXEL}"
    return of_columns(
        *(
            (
                {"cells": cells, "steps": 4},
                {f"{case}.{name}": of for name, of in (found | {"gross": 0}).items()},
            )
            for cells, found in values.items()
        )
    )


def test_a_grid_that_loses_pixels_is_not_advised():
    cells, error = results.best_cells(three_grids(), 1.0, 3.0, BY_PIXEL)
    assert (cells, error) == (16, pytest.approx(0.11))


def test_an_undone_response_leaves_noise_alone_and_the_stated_sigma_holds():
    """The same pictures, seen and corrected: by the theory, and by what is told."""
    condition = {"cells": 8, "steps": [4], "gammas": [2.4], "width_px": 256}
    ran = written(Plan(trials.corrected_trial, [condition], 1))
    period = trials.period_px(8, 256)
    shares = {}
    for steps, reading, of_gamma in results.read_twice(ran):
        found = of_gamma[2.4][SMOOTHED]
        theory = results.smoothed_px(period, 2.4, steps, reading)
        assert found.median("rms_px") == pytest.approx(theory, rel=0.1)
        shares[reading] = found.median("within")
    assert shares["seen"] < 0.4
    assert 0.62 < shares["corrected"] < 0.75
    assert found.median("told_px") == pytest.approx(
        bias_px(period, trials.OUR_BLUR_PX, 2.4, 4), rel=0.05
    )
