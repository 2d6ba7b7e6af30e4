"""The exercise of the page on extraction without clicks."""

from math import ceil


def part_task():
    """Eight columns of six are left, 48 corners; 95 % of them, rounded up."""
    return {
        "expected": least_in_order,
        "hint": "how many corners are left, and what is part of a corner?",
        "slips": {"That counts the lost column too.": lambda: ceil(0.95 * 54)},
    }


def least_in_order():
    """Corners that make 95 % of eight columns of six."""
    return ceil(0.95 * 48)
