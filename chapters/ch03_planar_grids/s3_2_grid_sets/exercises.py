"""Answers to the exercises of section 3.3.2."""

from __future__ import annotations


def clicked_corners():
    """3 x 15 x 35, and 7 x 63 and 8 x 108 of the fourth set."""
    return 3 * 15 * 7 * 5 + 7 * 9 * 7 + 8 * 12 * 9


def reach_of_merging(side_px, count):
    """t8 is 0.8 of the side's radius, its length divided by 1.9 times its number of
    corners.
    """
    return 0.8 * side_px / (1.9 * count)
