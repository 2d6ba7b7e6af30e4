"""Answers to the exercises of section 3.3.2."""

from __future__ import annotations


def clicked_corners():
    """Corners of all 60 grids of 3.3.2."""
    return 3 * 15 * 7 * 5 + 7 * 9 * 7 + 8 * 12 * 9


def reach_of_merging(side_px, count):
    """t8 (px) on a side of `count` corners, `side_px` from end to end."""
    return 0.8 * side_px / (1.9 * count)
