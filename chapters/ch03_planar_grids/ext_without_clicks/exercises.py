"""The exercise of the page on extraction without clicks."""

from __future__ import annotations

from math import ceil


def part_task():
    """What `check` needs for the exercise."""
    return {
        "expected": least_in_order,
        "hint": "round up: part of a corner is none",
        "slips": {
            "That counts the lost column too.": lambda: ceil(0.95 * 54),
        },
    }


def least_in_order():
    """Corners that make 95 % of eight columns of six."""
    return ceil(0.95 * 48)
