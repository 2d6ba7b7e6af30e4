"""How certain corners are by what their own edges say.

The noise of single pixels does not tell how well a corner is placed in a picture that
was compressed, smoothed or clipped: its errors are alike over many pixels. But two
opposite edges of a corner say independently of each other where it lies across them.
Blur, motion, thick ink and clipped whites move them apart as well, without moving the
corner between them; those do the same at all corners nearby of the same colours, and
what neighbours share is taken out.
"""

import numpy as np

from raxel.features.find.patches import shifted

# Neighbours with the same fields lie as on one colour of a chessboard, this far around;
# the weight of one falls off with this SD, in steps.
AROUND, NEAR = 3, 2.0
ALIKE = [
    (i, j)
    for i in range(-AROUND, AROUND + 1)
    for j in range(-AROUND, AROUND + 1)
    if (i + j) % 2 == 0 and (i, j) != (0, 0)
]
FEWEST = 2
# Median of |x| of a normal distribution, in its SD.
MEDIAN_OF_SD = 0.6745
# A corner whose own edges disagree by more than this many SDs of the board is less
# certain than the others; up to there it is chance.
CHANCE = 2.5


def sd_of_edges(halves):
    """SD (rows, columns) px of corners, the larger axis, from `corners.Placed.halves`.

    halves: (rows, columns, 2, 2) px, NaN where there is no corner. NaN of a board too
    small to tell.
    """
    own = halves - _shared(halves)
    own = own.reshape(*own.shape[:2], 4)
    size = np.linalg.norm(own.reshape(*own.shape[:2], 2, 2), axis=3)
    known = np.isfinite(size[..., 0])
    if np.count_nonzero(known) < FEWEST:
        return np.full(known.shape, np.nan)
    usual = np.median(size[known], axis=0) / MEDIAN_OF_SD
    spread = np.maximum(usual, size / CHANCE)
    spread = np.where(known[..., None], spread, usual)
    axes = halves / np.maximum(np.linalg.norm(halves, axis=3, keepdims=True), 1e-12)
    return _largest(axes * spread[..., None])


def _shared(halves):
    """What the neighbours of the same colours have in common, (rows, columns, 2, 2).

    The plane through theirs, by least squares, at the corner itself: at the side of a
    board, and where a lens bends, it changes from one to the next.
    """
    around = np.stack([shifted(halves, *step) for step in ALIKE])
    steps = np.array(ALIKE, float)
    weight = np.exp(-(steps**2).sum(axis=1) / (2 * NEAR**2))
    weight = weight[:, None, None] * np.isfinite(around[..., 0, 0])
    design = np.column_stack([np.ones(len(steps)), steps])
    normal = np.einsum("nij,na,nb->ijab", weight, design, design)
    normal += 1e-3 * np.diag([0.0, 1.0, 1.0])
    values = np.nan_to_num(around).reshape(*around.shape[:3], 4)
    right = np.einsum("nij,na,nijc->ijac", weight, design, values)
    enough = (weight > 0).sum(axis=0) >= FEWEST
    normal[~enough] = np.eye(3)
    shared = np.linalg.solve(normal, right)[..., 0, :].reshape(halves.shape)
    return np.where(enough[..., None, None], shared, np.nan)


def _largest(axes):
    """Length (...) of the largest axis of the ellipse from two vectors (..., 2, 2)."""
    a = (axes**2).sum(axis=(-2, -1))
    cross = axes[..., 0, 0] * axes[..., 1, 1] - axes[..., 0, 1] * axes[..., 1, 0]
    return np.sqrt((a + np.sqrt(np.maximum(a**2 - 4 * cross**2, 0))) / 2)
