"""Answer to the exercise of the page on extraction without clicks."""

from math import ceil


def part_task():
    """Eight columns of six are left, 48 corners; 95 % of them, rounded up."""
    return {
        "expected": min_in_order,
        "hint": "how many corners remain, and how is a fraction rounded?",
        "slips": {"That counts the lost column too.": lambda: ceil(0.95 * 54)},
    }


def min_in_order():
    """Return the number of corners that is 95 % of eight columns of six."""
    return ceil(0.95 * 48)
