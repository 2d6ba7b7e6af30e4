"""Answers to the exercises of the page on 6.3.1."""

import math


def bend_task():
    """Opposite to an edge there is none, so every product in the numerator is 0."""
    return {
        "expected": symmetry_of_a_bend,
        "hint": "what is the gradient where there is no edge?",
        "slips": {"That is an edge that goes straight on.": lambda: -1.0},
    }


def window_task():
    """r^2 / (4 x 144) is one bin at r = sqrt(576) px."""
    return {
        "expected": lambda: largest_window(144),
        "hint": "the curvature is one over the radius of curvature",
        "slips": {"That is its square.": lambda: largest_window(144) ** 2},
    }


def places_task():
    """Each place fits with a chance of 2^-25, and there are 512."""
    return {
        "expected": lambda: false_places(25, 512),
        "hint": "how likely is it that 25 fair bits are all right?",
        "slips": {"That is for one place.": lambda: false_places(25, 1)},
    }


def symmetry_of_a_bend():
    """Symmetry of a bend of an edge: nothing stands opposite to an edge."""
    return 0.0


def largest_window(radius_px):
    """Window radius (px) in which an arc leaves its best line by one px."""
    return math.sqrt(4 * radius_px)


def false_places(bits, places):
    """Places that random bits fit without an error, on average."""
    return places / 2**bits
