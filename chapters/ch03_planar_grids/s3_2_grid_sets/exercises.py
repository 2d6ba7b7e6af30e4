"""Answers to the exercises of section 3.3.2."""

ONLY_ONE, ONLY_OTHER = 27, 2
SIDE_PX, SIDE_CORNERS = 120.0, 7


def split_task():
    """If both are equally good, each of the 29 images is a fair coin toss.

    Splits with 0, 1 or 2 on one side are 1 + 29 + 406 of 2^29 cases, and the same on
    the other side.
    """
    from scipy.stats import binom, binomtest

    count = ONLY_ONE + ONLY_OTHER
    chance, this_split = (
        float(binomtest(ONLY_OTHER, count).pvalue),
        float(binom.pmf(ONLY_OTHER, count, 0.5)),
    )
    return {
        "expected": lambda: chance,
        "hint": "which splits are at least as unequal as this one?",
        "slips": {
            "That is one-sided.": lambda: chance / 2,
            "More unequal splits count too.": lambda: 2 * this_split,
            "More unequal splits count too, and those of the other side.": lambda: (
                this_split
            ),
        },
    }


def clicks_task():
    """3 x 15 x 35, and 7 x 63 and 8 x 108 of the fourth set."""
    return {
        "expected": lambda: 3 * 15 * 7 * 5 + 7 * 9 * 7 + 8 * 12 * 9,
        "hint": "count the images of each board",
        "slips": {
            "The fourth set is missing.": lambda: 3 * 15 * 7 * 5,
            "Three sets have the small board.": lambda: (
                15 * 7 * 5 + 7 * 9 * 7 + 8 * 12 * 9
            ),
            "Those are the squares.": lambda: 3 * 15 * 8 * 6 + 7 * 10 * 8 + 8 * 13 * 10,
        },
    }


def reach_task():
    """t8 is 0.8 of the side's radius, its length divided by 1.9 times its number of
    corners."""
    return {
        "expected": reach_of_merging,
        "hint": "which threshold decides about merging, and what is its unit?",
        "slips": {
            "That is s itself.": lambda: reach_of_merging() / 0.8,
            "The number of corners counts, not that of squares.": lambda: (
                reach_of_merging() * SIDE_CORNERS / (SIDE_CORNERS - 1)
            ),
            "That is a share of the step, which is about twice s.": lambda: (
                reach_of_merging() * 1.9
            ),
        },
    }


def reach_of_merging():
    """Return the largest distance (px) of two responses that are merged."""
    return 0.8 * SIDE_PX / (1.9 * SIDE_CORNERS)
