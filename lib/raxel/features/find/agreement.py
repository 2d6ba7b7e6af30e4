"""How certain corners are by what their own edges say.

The noise of single pixels does not tell how well a corner is placed in a picture that
was compressed, smoothed or clipped, nor what pixels do to edges that are sharper than
they: its errors are alike over many pixels. But the near and the far part of a corner's
window say independently of each other where it lies (`corners.Placed.apart`). How far
they are apart, in SDs of what noise alone would do, says how many times larger than
that of noise the error of the corner itself is. One corner says it badly; those around
it lie in the same light and blur.
"""

import numpy as np

# How far neighbours count: weights fall off with this SD, in steps.
NEAR = 1.5
# As much as so many numbers, of which each corner has two, is known beforehand: of
# a board, that errors are those of noise; of a corner, that they are its board's.
BEFORE, OF_BOARD = 2.0, 2.0
# What stands out by more SDs than these is one corner's, and no neighbour's. So many
# rounds, each with the last one's SDs, leave little of the largest, also where a row of
# corners lies in the edge of a shadow: it is a third of those around its neighbours.
STANDS_OUT, ROUNDS = 1.5, 12
# Of the variance of a Gaussian, what is left where it is cut at so many SDs.
LEFT = 0.778
# A corner whose own parts disagree by more than this many SDs is less certain than its
# neighbours; up to there it is chance.
CHANCE = 2.5


def times_noise(apart):
    """How many times the SD of noise corners err, (rows, columns).

    apart: (rows, columns, 2), see `corners.Placed`, NaN where there is no corner.
    """
    known = np.isfinite(apart[..., 0])
    square = np.where(known[..., None], apart, 0.0) ** 2
    usual = np.full(known.shape, np.inf)
    for _ in range(ROUNDS):
        cut = np.minimum(square, (STANDS_OUT**2 * usual)[..., None])
        usual = _around(cut / LEFT, known)
    own = np.sqrt(square.max(axis=2)) / CHANCE
    return np.where(known, np.maximum(np.sqrt(usual), own), np.nan)


def at_most_usual(times):
    """`times_noise` (rows, columns), none larger than the median of the board."""
    known = times[np.isfinite(times)]
    return np.minimum(times, np.median(known)) if len(known) else times


def with_shift(sd, shift):
    """SDs (N,) px of corners that half a turn moves by `shift` (N,) px.

    Beyond chance it is theirs: what a whole window shares, a shadow's soft edge or a
    stain, moves its near and its far part alike.
    """
    return np.hypot(sd, np.sqrt(np.maximum(shift**2 - (CHANCE * sd) ** 2, 0)))


def _around(square, known):
    """Mean (rows, columns) of numbers (rows, columns, 2) around every cell."""
    board = (square.sum() + BEFORE) / (2 * np.count_nonzero(known) + BEFORE)
    rows, columns = (_nearness(count) for count in known.shape)
    total = rows @ square.sum(axis=2) @ columns
    count = rows @ (2.0 * known) @ columns
    return (total + OF_BOARD * board) / (count + OF_BOARD)


def _nearness(count):
    """Weights (count, count) of a row's cells for each other."""
    steps = np.subtract.outer(np.arange(count), np.arange(count))
    return np.exp(-(steps**2) / (2 * NEAR**2))
