"""Answers to the exercises of the page on CELECT's failures."""

from raxel.features.celect import CelectSettings

PUBLISHED = CelectSettings()


def square_task():
    """t8 is 0.8 of 400 / (1.9 x 9) px: two corners nearer than that are merged."""
    return {
        "expected": lambda: least_square(400, 9),
        "hint": "how long is s_1, in px?",
        "slips": {
            "That is s_1; t8 is 0.8 of it.": lambda: (
                least_square(400, 9) / PUBLISHED.merge
            ),
            "The divisor 1.9 is missing.": lambda: (
                least_square(400, 9) * PUBLISHED.radius_divisor
            ),
        },
    }


def arc_task():
    """The radius is at right angles to the arc, and the arc's chord leaves its
    tangent by half the arc: 90 degrees less half the arc is t4 = 15 degrees."""
    return {
        "expected": widest_arc,
        "hint": "which angle do the chord and the tangent of an arc enclose?",
        "slips": {"The chord turns by half the arc.": lambda: widest_arc() / 2},
    }


def tangent_task():
    """r^2 / (2 x 470) is 0.1 r at r = 0.2 x 470 px."""
    return {
        "expected": lambda: largest_radius(470),
        "hint": "how far is an arc from its tangent at a distance r?",
        "slips": {
            "An arc of radius R leaves its tangent by half of r^2 / R.": (
                lambda: largest_radius(470) / 2
            )
        },
    }


def least_square(length_px, corners):
    """Smallest square (px) on a side that t8 does not merge: 0.8 s_i."""
    return PUBLISHED.merge * length_px / (PUBLISHED.radius_divisor * corners)


def widest_arc():
    """Arc (deg) of side 4 at which L4 comes within t4 of a radius at its end."""
    return 2 * (90 - PUBLISHED.first_angle_deg)


def largest_radius(curve_px):
    """Window radius (px) whose arc stays within t5 of its tangent.

    An arc of radius R leaves its tangent by r^2 / (2 R) at a distance r.
    """
    return 2 * PUBLISHED.edge_band * curve_px
