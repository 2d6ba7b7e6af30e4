"""Expected answers of the exercises of Appendix A."""

import numpy as np

from chapters.appendix_a.phase_and_harmonics.experiment import phases
from chapters.shared.grids import (
    formula_error,
    largest,
    power_law_orders,
    sum_of_orders,
)

GAMMA = 1.8
SEVEN = 7
B3, B5, CELL_MM = -0.02, 0.012, 40.0


# Of (3.23) for the profile with the orders 3 and 5.
MAX_ERROR_RAD = largest(
    formula_error(sum_of_orders({1: 1.0, 3: B3, 5: B5}), 4, phases(3600))
)


def amplitude_task():
    """A_2 / A_1 = 0.8 / 3.8 and A_3 / A_2 = -0.2 / 4.8. Their product is -0.0088."""
    return {
        "expected": lambda: power_law_orders(GAMMA, 3)[2],
        "hint": "compute order 2 from order 1, then order 3 from order 2",
        "slips": {
            "That is order 2.": lambda: power_law_orders(GAMMA, 3)[1],
            "That is order 3 as a share of order 2.": lambda: (GAMMA - 2) / (GAMMA + 3),
            "Wrong sign: the gamma is below 2.": lambda: -power_law_orders(GAMMA, 3)[2],
        },
    }


def alias_task():
    """With m = 1, the orders are 7 - 1 and 7 + 1."""
    return {
        "expected": lambda: np.array([SEVEN - 1.0, SEVEN + 1.0]),
        "hint": "the lowest orders have m = 1",
        "slips": {
            "Order 7 adds the same value to all seven images.": lambda: np.array(
                [SEVEN, SEVEN + 1.0]
            ),
            "Those are the second and the third: a lower order disturbs too.": lambda: (
                np.array([SEVEN + 1.0, 2 * SEVEN - 1.0])
            ),
        },
    }


def steps_task():
    """|b3 + b5| / b1 is 0.008 rad. A cell of 40 mm is 2 pi rad, so 0.051 mm."""
    return {
        "expected": lambda: CELL_MM * MAX_ERROR_RAD / (2 * np.pi),
        "hint": "a period of 2 pi rad is one cell",
        "slips": {
            "Amplitudes add with their signs.": lambda: (
                CELL_MM * (abs(B3) + abs(B5)) / (2 * np.pi)
            ),
            "A period is 2 pi rad, not 1 rad.": lambda: CELL_MM * abs(B3 + B5),
            "Order 5 contributes too.": lambda: CELL_MM * abs(B3) / (2 * np.pi),
        },
    }
