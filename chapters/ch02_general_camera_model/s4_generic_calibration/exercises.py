"""Expected answers of the exercises of section 2.4."""

from fractions import Fraction

from chapters.ch02_general_camera_model.s4_generic_calibration.experiment import (
    draw_scene,
    formula,
    meet,
)
from repro.run import trial_rng

# Cells of the column V that are not zero.
ENTRIES_OF_V = sum(formula(row, "V") != "0" for row in range(9))


def entries_task():
    """A cell is zero where no triple product of the points has its monomial; count
    the cells of the column that hold a formula."""
    return {
        "expected": lambda: ENTRIES_OF_V,
        "hint": "look at the column of V in Table 2.1",
        "slips": {"Those are the zeros.": lambda: 9 - ENTRIES_OF_V},
    }


def meeting_task(scene):
    """The ray is C + s ((37, -16, 0) - C); grid 2 is not rotated, so s follows
    from its height, and subtracting its origin gives the position on the grid."""
    return {
        "expected": lambda: where_it_meets(scene),
        "hint": "at which height is grid 2, and where is its origin?",
        "slips": {
            "That is in the frame of the base grid.": lambda: [
                place + float(scene[f"t_{axis}_2"])
                for place, axis in zip(where_it_meets(scene), "xy", strict=True)
            ]
        },
    }


def exercise_scene():
    """Return a scene with whole numbers in which grid 2 is not rotated."""
    names = draw_scene(trial_rng("table_2_1_exercise", {}, 0))
    for row in (1, 2, 3):
        for column in (1, 2, 3):
            names[f"R{row}{column}_2"] = Fraction(int(row == column))
    return names


def where_it_meets(names):
    """Return where the ray through (37, -16) of the base grid meets grid 2, (2,)."""
    return [float(part) for part in meet(names, 2, [Fraction(37), Fraction(-16)])]
