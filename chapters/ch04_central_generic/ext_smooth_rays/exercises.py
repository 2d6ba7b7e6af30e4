"""What the exercises of this page compare an answer with."""


def controls_task():
    """A cubic spline on n cells has n + 3 control values each way, for two
    coordinates."""
    return {
        "expected": lambda: 2 * (8 + 3) ** 2,
        "hint": "how many cubic pieces have a share in one cell, each way?",
        "slips": {
            "The field has two coordinates.": lambda: (8 + 3) ** 2,
            "Cells at the rim have shares in values beyond it.": lambda: 2 * 8**2,
        },
    }
