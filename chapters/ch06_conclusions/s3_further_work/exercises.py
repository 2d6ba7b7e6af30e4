"""Expected answers of the exercises on straight edges and spline coefficients."""

N_PIXELS, LINE_UNKNOWNS, PLANE_UNKNOWNS = 20, 4, 2
FUNCTIONS = 14, 9


def edge_task():
    """Each ray must meet the edge, which has four unknowns: 20 - 4."""
    return {
        "expected": lambda: N_PIXELS - LINE_UNKNOWNS,
        "hint": "how many numbers describe a line in space?",
        "slips": {
            "The edge is not known: its own unknowns use up equations.": lambda: (
                N_PIXELS
            ),
            "That holds for a central camera, whose rays determine a plane.": lambda: (
                N_PIXELS - PLANE_UNKNOWNS
            ),
        },
    }


def pairs_task():
    """One of the 126 coefficients is the scale: 125 unknowns, two equations a pair."""
    n_coefficients = FUNCTIONS[0] * FUNCTIONS[1]
    return {
        "expected": lambda: -(-(n_coefficients - 1) // 2),
        "hint": "count the unknowns without the scale, and round up",
        "slips": {
            "Each pair gives two equations.": lambda: n_coefficients - 1,
            "The pairs must give at least 125 equations.": lambda: (
                (n_coefficients - 1) // 2
            ),
        },
    }
