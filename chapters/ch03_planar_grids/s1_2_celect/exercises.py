"""Answers to the exercises of section 3.1.2."""

from chapters.ch03_planar_grids.s1_2_celect.report import interior
from raxel.features.celect import CelectSettings


def growth_task():
    """The first radius is 9 / 19 of a square (nine squares between ten corners),
    and 1.2 to the fourth power makes it almost one square."""
    return {
        "expected": largest_growth,
        "hint": "how many squares are between ten corners?",
        "slips": {
            "Ten corners have nine squares between them.": lambda: (
                largest_growth() * 10 / 9
            ),
            "Each growth adds 20 % of the current radius.": lambda: 9 / 19 * 1.8,
        },
    }


def border_task():
    """Without a border all 11 x 8 interior corners count, with a border 9 x 6."""
    return {
        "expected": lambda: interior((12, 9), 0) - interior((12, 9), 1),
        "hint": "count interior corners with and without a border of one square",
        "slips": {"Count corners, not squares.": lambda: 12 * 9 - 10 * 7},
    }


def turn_task():
    """Tracing fails once the edge is within t4 = 15 degrees of side 4: 40 - 15."""
    return {
        "expected": lambda: 40 - CelectSettings().first_angle_deg,
        "hint": "which lines does t4 exclude at the first corner?",
        "slips": {
            "That is t4. The edge starts 40 degrees away.": lambda: (
                CelectSettings().first_angle_deg
            )
        },
    }


def largest_growth():
    """Radius of the largest window, in squares, for ten corners per side."""
    settings = CelectSettings()
    corners = 10
    radius = (corners - 1) / (settings.radius_divisor * corners)
    return radius * (1 + settings.growth) ** settings.max_growths
