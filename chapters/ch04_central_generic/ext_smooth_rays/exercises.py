"""Expected answers of the exercises on smooth rays."""


def controls_task():
    """A cubic spline on n cells has n + 3 control values per direction, for two
    coordinates."""
    return {
        "expected": lambda: 2 * (8 + 3) ** 2,
        "hint": "how many basis functions overlap one cell, per direction?",
        "slips": {
            "The field has two coordinates.": lambda: (8 + 3) ** 2,
            "Cells at the edge use control values beyond it.": lambda: 2 * 8**2,
        },
    }
