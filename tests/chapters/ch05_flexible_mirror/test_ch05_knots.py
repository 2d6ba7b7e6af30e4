"""Claims about the number of knots: they can fail, and count what they state."""

import numpy as np
import pytest

from chapters.ch05_flexible_mirror.s2_method import experiment
from chapters.ch05_flexible_mirror.s2_method.claims import judge_knot_tradeoff
from chapters.ch05_flexible_mirror.s2_method.report import KNOTS, largest_step
from chapters.ch05_flexible_mirror.s3_3_repeatability.claims import (
    judge_high_order,
    rise_by_relief,
)
from chapters.ch05_flexible_mirror.s3_3_repeatability.experiment import FEW, MANY
from chapters.shared.mirror.runs import shape_name
from tests.made_results import of_columns

SEEDS = 20


def knotted(borne=(10.0, 5.0, 2.5, 1.0), errors=(0.1, 0.05, 0.02, 0.01), lost=0):
    """Results in which each number of knots bears steps up to `borne`, mm, in all seeds
    but `lost`, with these errors without noise, mm."""
    values = {}
    for shape, most, error in zip(experiment.SHAPES, borne, errors, strict=True):
        angles = np.where(np.array(experiment.STEPS_MM) <= most, 0.1, np.nan)
        trials = np.tile(angles, (SEEDS, 1))
        trials[:lost] = 2.0
        values[f"{shape_name(shape)}.angles_deg"] = trials
        values[f"{shape_name(shape)}.noise_free_mm"] = np.full(SEEDS, error)
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
def test_knot_tradeoff_claim_holds_and_fails(other, verdict):
    assert judge_knot_tradeoff(knotted(**other)).verdict == verdict


def test_largest_step_needs_nine_of_ten_runs():
    found = knotted(lost=2)[KNOTS]
    assert [largest_step(found, shape) for shape in experiment.SHAPES] == [
        10,
        5,
        2.5,
        1,
    ]
    assert largest_step(knotted(lost=3)[KNOTS], experiment.SHAPES[0]) == 0


def relieved(rise=3.0, left=1.4, spread=0.02, lost=0):
    """Residuals with relief: `rise` times the smooth mirror's with few functions, and
    `left` times with many, where the smooth one's own is halved."""
    rng = np.random.default_rng(2)
    factors = {"relief": (rise, left), "smooth": (1.0, 0.5)}
    values = {}
    for mirror, of_shapes in factors.items():
        for shape, factor in zip((FEW, MANY), of_shapes, strict=True):
            for name in ("back_mm", "residual_mm", "angle_deg"):
                trials = 0.2 * factor * (1 + spread * rng.standard_normal(SEEDS))
                if shape == MANY:
                    trials[:lost] = np.nan
                values[f"{mirror}.{shape_name(shape)}.{name}"] = trials
    return {"exp_c5_high_order": of_columns(({"geometry": "A"}, values))}


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
def test_high_order_claim_holds_fails_and_is_undecided(other, verdict):
    assert judge_high_order(relieved(**other)).verdict == verdict


def test_removed_share_is_relative_to_the_rise():
    made = relieved(rise=3.0, left=1.5, spread=1e-6)["exp_c5_high_order"]
    rise, removed = rise_by_relief(made.select(geometry="A"))
    # The rise is 2, and 1.0 of it is left: 1.5 less the smooth mirror's 0.5.
    assert removed.value == pytest.approx(50, rel=1e-3)
    assert rise.value == pytest.approx(3, rel=1e-3)
