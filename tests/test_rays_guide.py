"""The guide to rays without a centre: its trial, facts, table and figure."""

import numpy as np
import pytest

from chapters.guides.rays_without_a_centre import page, results, trials
from chapters.guides.rays_without_a_centre.figures import ext_ray_motion_told
from chapters.guides.rays_without_a_centre.tables import ext_ray_motion
from repro.run.outcomes import Plan
from tests.made_results import written


@pytest.fixture(scope="module")
def ran():
    plan = page.ext_ray_motion_steps("quick")
    assert isinstance(plan, Plan)
    return written(plan, "ext_ray_motion_steps", "quick")


def test_the_more_the_mirror_bends_the_better_the_length_is_told(ran):
    spread, told = (
        [np.median(ran.column(name, deflection_mm=d)) for d in trials.DEFLECTIONS_MM]
        for name in ("spread_mm", "told.length_percent")
    )
    assert np.all(np.diff(spread) > 0)
    assert np.all(np.diff(told) < 0)
    assert told[0] > 70
    assert told[-1] < 12
    every = ran.select()
    turns = [every.column(f"told.{name}_deg") for name in ("turn", "turn_with_length")]
    assert np.all(turns[1] < turns[0])


def test_the_order_matters_and_wrong_pairs_are_left_out(ran):
    every = ran.select()
    assert every.column("product_mm").max() < 1e-10
    assert every.column("mixed_mm").min() > 1e-4
    assert every.column("kept").min() > 0.95
    assert every.column("let_in").max() < 0.1
    # Four standard deviations of what the information foretells.
    off = np.abs(every.column("held.turn_deg"))
    assert np.all(off < 4 * every.column("told.turn_with_length_deg"))
    np.testing.assert_allclose(every.column("held.length_percent"), 0, atol=0.1)


def test_the_page_quotes_tabulates_and_draws_it(ran):
    facts = results.facts(ran)
    assert float(facts["told.least"]) > float(facts["told.most"])
    assert float(facts["turn.linear"]) > float(facts["turn.held"])
    shown = ext_ray_motion({results.STEPS: ran}).columns
    assert shown["Deflection (mm)"] == list(trials.DEFLECTIONS_MM)
    drawing = ext_ray_motion_told({results.STEPS: ran})
    assert {"robust", "held"} < set(results.WAYS)
    assert len(drawing.data["median"]) == 25
