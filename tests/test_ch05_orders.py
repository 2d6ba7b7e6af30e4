"""How many knots: claims can fail, and what is measured is what is said."""

import numpy as np
import pytest
from matplotlib import pyplot as plt

from chapters.ch05_flexible_mirror.ext_orders import tables
from chapters.ch05_flexible_mirror.ext_orders.claims.knots import (
    judge_high_order,
    judge_knot_tradeoff,
)
from chapters.ch05_flexible_mirror.ext_orders.figures.orders import orders_figure
from chapters.ch05_flexible_mirror.ext_orders.results.knots import KNOTS, Knots
from chapters.ch05_flexible_mirror.ext_orders.results.orders import (
    ORDERS,
    courses,
    quoted,
)
from chapters.ch05_flexible_mirror.ext_orders.results.relief import RELIEF, ReliefRuns
from chapters.ch05_flexible_mirror.ext_orders.trials import knots, orders, relief
from chapters.ch05_flexible_mirror.ext_orders.trials.shapes import name_of
from raxel.calibration.mirror.whiteness import BOUND
from tests.made_results import of_columns

SEEDS = 20


def knotted(borne=(10.0, 5.0, 2.5, 1.0), errors=(0.1, 0.05, 0.02, 0.01), lost=0):
    """Results in which each number of knots bears steps up to `borne`, mm, in all seeds
    but `lost`, with these errors without noise, mm."""
    values = {}
    for shape, most, error in zip(knots.SHAPES, borne, errors, strict=True):
        angles = np.where(np.array(knots.STEPS_MM) <= most, 0.1, np.nan)
        trials = np.tile(angles, (SEEDS, 1))
        trials[:lost] = 2.0
        values[f"{name_of(shape)}.angles_deg"] = trials
        values[f"{name_of(shape)}.noise_free_mm"] = np.full(SEEDS, error)
    return {KNOTS: of_columns(({"geometry": "A"}, values))}


@pytest.mark.parametrize(
    ("other", "verdict"),
    [
        ({}, "reproduced"),
        ({"lost": 2}, "reproduced"),
        ({"lost": 3}, "differs"),
        ({"borne": (10.0, 10.0, 2.5, 2.5)}, "reproduced"),
        ({"borne": (5.0, 5.0, 5.0, 5.0)}, "differs"),
        ({"borne": (5.0, 10.0, 2.5, 1.0)}, "differs"),
        ({"errors": (0.1, 0.05, 0.06, 0.01)}, "differs"),
        ({"errors": (0.1, 0.05, 0.02, np.nan)}, "differs"),
    ],
)
def test_knots_have_to_cost_steps_and_to_come_nearer(other, verdict):
    assert judge_knot_tradeoff(knotted(**other)).verdict == verdict


def test_a_step_is_borne_where_nine_of_ten_seeds_are_near():
    found = Knots.of(knotted(lost=2))
    assert [found.largest_step(shape) for shape in knots.SHAPES] == [10, 5, 2.5, 1]
    assert Knots.of(knotted(lost=3)).largest_step(knots.SHAPES[0]) == 0
    np.testing.assert_allclose(found.shares(knots.SHAPES[0]).max(), 0.9)
    assert 0 < found.refused_percent() < 100


def relieved(rise=3.0, left=1.4, spread=0.02, lost=0):
    """Residuals with relief: `rise` times the smooth mirror's with few functions, and
    `left` times with many, where the smooth one's own is halved."""
    rng = np.random.default_rng(2)
    factors = {"relief": (rise, 2.0, left), "smooth": (1.0, 0.7, 0.5)}
    values = {}
    for mirror, of_shapes in factors.items():
        for shape, factor in zip(relief.SHAPES, of_shapes, strict=True):
            for name in ("back_mm", "residual_mm", "angle_deg"):
                trials = 0.2 * factor * (1 + spread * rng.standard_normal(SEEDS))
                if shape == relief.SHAPES[-1]:
                    trials[:lost] = np.nan
                values[f"{mirror}.{name_of(shape)}.{name}"] = trials
    return {RELIEF: of_columns(({"geometry": "A"}, values))}


@pytest.mark.parametrize(
    ("other", "verdict"),
    [
        ({}, "reproduced"),
        ({"left": 1.6}, "differs"),
        ({"rise": 0.9}, "differs"),
        ({"left": 1.5, "spread": 0.3}, "undecided"),
        ({"lost": 15}, "undecided"),
    ],
)
def test_more_functions_have_to_take_half_of_what_relief_adds(other, verdict):
    assert judge_high_order(relieved(**other)).verdict == verdict


def test_what_is_taken_away_is_told_of_the_rise():
    found = ReliefRuns.of(relieved(rise=3.0, left=1.5, spread=1e-6))
    # The rise is 2, and 1.0 of it is left: 1.5 less the smooth mirror's 0.5.
    assert found.removed().value == pytest.approx(50, rel=1e-3)
    assert found.rise().value == pytest.approx(3, rel=1e-3)


def ordered(white=2, least_at=2, published=True):
    """Courses of three orders in every case and stage; rays are best at `least_at`."""
    sizes = np.array([[4, 3, 2], [5, 4, 3], [6, 5, 4]], float)
    values = {}
    for stage in orders.STAGES:
        angles = 0.1 + 0.1 * np.abs(np.arange(3) - least_at)
        rows = np.column_stack(
            [sizes, [0.9, 0.2, 0.1], [90.0, 20.0, 0.5], [0.9, 0.1, 0.3], angles]
        )
        values[f"{stage}.rows"] = [rows] * 4
        values[f"{stage}.white"] = [white] * 4
        last = np.array([7, 3, 2, 0.15, 60.0, 0.15, 0.25])
        values[f"{stage}.published"] = [last if published else np.nan * last] * 4
    conditions = [{"case": case, "most": 56} for case in orders.CASES]
    return {ORDERS: of_columns(*((c, values) for c in conditions))}


def test_the_order_that_is_taken_is_the_first_white_one_or_the_last():
    (one, *_) = courses(ordered(white=1), "smooth", "primary")
    assert one.chosen("size") == 20
    assert one.chosen("angle_deg") == pytest.approx(0.2)
    assert one.least("angle_deg") == pytest.approx(0.1)
    assert one.with_least("kept_mm", "angle_deg") == pytest.approx(0.2)
    (last, *_) = courses(ordered(white=-1), "bench", "stage")
    assert last.chosen("size") == 30
    assert quoted(ordered(white=-1))["bench.stage.white"] == 0
    assert quoted(ordered(white=1))["uneven.stage.white"] == 4


def test_table_and_figures_show_what_the_runs_have():
    for made in (ordered(), ordered(published=False)):
        table = tables.orders_table(made)
        assert len(table.columns["White"]) == 6
        assert set(table.columns["White"]) == {"4 of 4"}
        for stage in ("ext_orders_primary", "ext_orders_stage"):
            drawing = orders_figure(made, stage)
            plt.close(drawing.figure)
            assert sum(drawing.data["chosen"]) == 3 * 4 * 4


def test_a_run_stops_counting_where_its_own_rule_would_stop():
    """What the runs call the first white order is what `raised_until_white` takes."""
    errors = {"A": orders.white_errors(np.random.default_rng(1))}
    condition = {"geometry": "A", "case": "smooth", "most": 30}
    found = orders.orders_trial(condition, np.random.default_rng(0), errors)
    rows, white = found["primary"]["rows"], found["primary"]["white"]
    assert np.all(rows[:, 0] * rows[:, 1] <= 30)
    excess = rows[:, orders.NAMES.index("excess")]
    assert white == (np.argmax(excess < BOUND) if np.any(excess < BOUND) else -1)
