"""Expected answers of the exercises on verdicts of statements."""

SHARE_PERCENT, N_CLAIMS = 80.0, 3


def product_task():
    """All three must be reproduced: the probabilities multiply to 0.8³."""
    return {
        "expected": lambda: 100 * (SHARE_PERCENT / 100) ** N_CLAIMS,
        "hint": "how likely is it that all three are reproduced?",
        "slips": {
            "That is one claim; the statement needs all three.": lambda: SHARE_PERCENT,
            "That is the probability that at least one is reproduced.": lambda: (
                100 * (1 - (1 - SHARE_PERCENT / 100) ** N_CLAIMS)
            ),
        },
    }


def open_task():
    """Eight combinations have no claim that differs, and one of them is reproduced."""
    return {
        "expected": lambda: 2**N_CLAIMS - 1,
        "hint": "first count the combinations in which no claim differs",
        "slips": {
            "One of these has three reproduced claims.": lambda: 2**N_CLAIMS,
            "A claim that differs decides, also next to undecided ones.": lambda: (
                3**N_CLAIMS - 2**N_CLAIMS
            ),
        },
    }
