"""Answers to the exercises of section 3.3.2."""

from __future__ import annotations

import math


def chance_of_split(only_one, only_other):
    """Exact two-sided chance of McNemar's test for a split of pictures."""
    count = only_one + only_other
    fewer = min(only_one, only_other)
    tail = sum(math.comb(count, k) for k in range(fewer + 1))
    return min(1.0, 2 * tail / 2**count)


def clicked_corners():
    """Corners of all 60 grids of 3.3.2."""
    return 3 * 15 * 7 * 5 + 7 * 9 * 7 + 8 * 12 * 9


def reach_of_merging(side_px, count):
    """t8 (px) on a side of `count` corners, `side_px` from end to end."""
    return 0.8 * side_px / (1.9 * count)
