"""Expected answers of the exercise on the test of centrality."""


def unknowns_task():
    """A line has two unknowns more than a ray from one point, and the three unknowns
    of the centre are saved."""
    return {
        "expected": lambda: 2 * 500 - 3,
        "hint": "count what a line needs beyond a direction, and what the "
        "central camera has that the lines do not",
        "slips": {
            "The central camera has three unknowns of its own.": lambda: 2 * 500,
            "A line has four unknowns, a direction two of them.": lambda: 4 * 500 - 3,
        },
    }
