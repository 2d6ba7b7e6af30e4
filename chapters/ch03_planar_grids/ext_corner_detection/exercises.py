"""Answers to the exercises of the page on 6.3.1."""

from __future__ import annotations

import math


def symmetry_of_a_bend():
    """Symmetry of a bend of an edge: nothing stands opposite to an edge."""
    return 0.0


def largest_window(radius_px):
    """Window radius (px) in which an arc leaves its best line by one px."""
    return math.sqrt(4 * radius_px)


def false_places(bits, places):
    """Places that random bits fit without an error, on average."""
    return places / 2**bits
