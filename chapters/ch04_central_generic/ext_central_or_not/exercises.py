"""What the exercises of this page compare an answer with."""


def unknowns_task():
    """Lines have two unknowns more than rays from one point, but the centre's three
    are then free."""
    return {
        "expected": lambda: 2 * 500 - 3,
        "hint": "count what a line needs beyond a direction, and what the "
        "central camera has that the lines do not",
        "slips": {
            "The central camera has three unknowns of its own.": lambda: 2 * 500,
            "A line has four unknowns, a direction two of them.": lambda: 4 * 500 - 3,
        },
    }
