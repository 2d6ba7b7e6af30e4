"""What the exercises of section 2.4 compare an answer with."""

from __future__ import annotations

from fractions import Fraction

from chapters.ch02_general_camera_model.s4_generic_calibration.trials import (
    draw_scene,
    formula,
    meet,
)
from repro.run.experiment import trial_rng


def entries_of(vector):
    """How many cells of a column of Table 2.1 are not zero."""
    return sum(formula(row, vector) != "0" for row in range(9))


def exercise_scene():
    """A scene with whole numbers in which grid 2 is not turned."""
    names = draw_scene(trial_rng("table_2_1_exercise", {}, 0))
    for row in (1, 2, 3):
        for column in (1, 2, 3):
            names[f"R{row}{column}_2"] = Fraction(int(row == column))
    return names


def where_it_meets(names):
    """Where the ray through (37, -16) of the base grid meets grid 2, (2,)."""
    point = meet(names, 2, [Fraction(37), Fraction(-16)])
    return [float(part) for part in point]
