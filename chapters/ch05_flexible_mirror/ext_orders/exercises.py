"""What the exercises of the page on knots compare an answer with."""

from scipy.stats import norm

from raxel.calibration.mirror.whiteness import BOUND

LENGTH_MM, FUNCTIONS, DEGREE = 160.0, 7, 2
CORNERS, COEFFICIENTS, POSE = 110, 30, 6


def interval_task():
    """K functions of degree k live on K - k intervals: each knot more is a function
    more, and a single interval carries k + 1."""
    return {
        "expected": lambda: LENGTH_MM / (FUNCTIONS - DEGREE),
        "hint": "how many functions has a single interval, and how many more are there "
        "with each further knot?",
        "slips": {
            "A single interval has three quadratic functions, not one.": lambda: (
                LENGTH_MM / FUNCTIONS
            ),
            "A single interval has three quadratic functions, not two.": lambda: (
                LENGTH_MM / (FUNCTIONS - 1)
            ),
        },
    }


def freedom_task():
    """Each corner gives two numbers across its ray; coefficients and the six numbers of
    a pose are free."""
    return {
        "expected": lambda: 2 * CORNERS - COEFFICIENTS - POSE,
        "hint": "a residual lies across its ray: how many numbers is that?",
        "slips": {
            "A corner gives two numbers.": lambda: CORNERS - COEFFICIENTS - POSE,
            "A vector of three numbers, but none of it lies along the ray.": lambda: (
                3 * CORNERS - COEFFICIENTS - POSE
            ),
            "The pose of the board is free as well.": lambda: (
                2 * CORNERS - COEFFICIENTS
            ),
        },
    }


def alarm_task():
    """The share of a normal distribution above the bound, on one side."""
    return {
        "expected": lambda: 100 * norm.sf(BOUND),
        "hint": "only neighbours that agree too well count",
        "slips": {
            "Neighbours that differ too much are no reason to go on.": lambda: (
                200 * norm.sf(BOUND)
            ),
            "That is the share below the bound.": lambda: 100 * norm.cdf(BOUND),
        },
    }
