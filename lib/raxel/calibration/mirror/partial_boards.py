"""A board of which a mirror shows a part: the same corners before and after a bend.

A board that reaches beyond the mirror has no corner to count from. Its lattice, as
found in one picture, may be turned and shifted against that of another. What tells is
the clamp: there the mirror stays, so both pictures show the same places of the board
there. Where on the lattice these are, is run on from the corners to the clamp.
"""

from itertools import product

import numpy as np

from raxel.calibration.views.correspondence import BoardView
from raxel.errors import InputError
from raxel.features.detector import Partial

# Fewest corners of a picture, three for each number of a quadratic.
FEWEST = 18
# Steps of the lattice by which places at the clamp may differ between the pictures, and
# by which they must differ in any other labelling. On both geometries of chapter 5, 24
# runs of three deflections of 5 mm: 0.3 at most, and 0.9 at least.
STILL, OTHERS = 0.4, 0.7
# Room for lattices on a common one, in boards.
ROOM = 3
# A lattice may be turned by right angles, and turned over (rows with columns).
TURNS = tuple(
    np.array([[a, b], [c, d]])
    for a, b, c, d in product((-1, 0, 1), repeat=4)
    if abs(a * d - b * c) == 1 and abs(a) + abs(b) + abs(c) + abs(d) == 2
)


def lattice_of(detection):
    """The Partial of a Detection, of a whole board or of a part; None without any."""
    if not detection.found:
        return detection.partial
    there = np.isfinite(detection.corners[:, 0])
    row, column = np.divmod(np.arange(len(there)), detection.columns)
    indices = np.column_stack([row, column])
    return Partial(detection.corners[there], indices[there])


def labelled_like(before, after, clamp, name="board"):
    """The Partial `after`, each corner with the indices that the Partial `before` has
    for it.

    clamp: (L, 2) px, points along the edge at which the mirror is held. Raises
    InputError, which begins with `name`, where a picture shows too few corners and
    where it cannot be told which is which.
    """
    fewest = min(len(before.corners), len(after.corners))
    if fewest < FEWEST:
        raise InputError(
            f"{name}: a picture shows {fewest} corners of the board; at least {FEWEST} "
            "are needed to tell which is which",
            code="too-few-corners",
        )
    (there, hand), (places, other_hand) = (
        _run_on(partial, clamp) for partial in (before, after)
    )
    found = []
    for turn in TURNS:
        if np.linalg.det(turn) * other_hand * hand < 0:
            continue
        apart = there - places @ turn
        shift = np.rint(apart.mean(axis=0)).astype(int)
        gap = np.linalg.norm(apart - shift, axis=1).max()
        found.append((gap, after.indices @ turn + shift))
    found.sort(key=lambda one: one[0])
    if found[0][0] > STILL or found[1][0] < OTHERS:
        raise InputError(
            f"{name}: it cannot be told which corner of the board is which after the "
            "deflection; use a smaller one, or show the board up to the clamp",
            code="corners-not-matched",
        )
    return after._replace(indices=found[0][1])


def on_one_lattice(partials, board, names):
    """BoardViews of Partials that are labelled alike, all with the same corners.

    board: the Chessboard; the lattice is ROOM of its sides wide, with the first partial
    in its middle. Raises InputError where a partial reaches beyond.
    """
    side = ROOM * max(board.columns, board.rows)
    first = partials[0].indices
    origin = (first.min(axis=0) + first.max(axis=0) - side) // 2
    row, column = np.divmod(np.arange(side * side), side)
    points = board.pitch_mm * np.column_stack([column, row]).astype(float)
    views = []
    for partial, name in zip(partials, names, strict=True):
        at = partial.indices - origin
        if at.min() < 0 or at.max() >= side:
            raise InputError(
                f"{name}: its corners are {ROOM // 2} boards away from those of "
                f"{names[0]}; use smaller deflections",
                code="corners-not-matched",
            )
        pixels = np.full((side * side, 2), np.nan)
        pixels[at @ [side, 1]] = partial.corners
        views.append(BoardView(pixels, points, side, side, name))
    return views


def _run_on(partial, clamp):
    """(Places (L, 2) on the lattice at pixels `clamp`, by a quadratic through all
    corners; whether rows and columns turn clockwise, 1 or -1)."""
    middle = partial.corners.mean(axis=0)
    scale = np.abs(partial.corners - middle).max()
    A, at = (_quadratic((p - middle) / scale) for p in (partial.corners, clamp))
    c = np.linalg.lstsq(A, partial.indices.astype(float), rcond=None)[0]
    return at @ c, np.sign(np.linalg.det(c[1:3]))


def _quadratic(p):
    x, y = p.T
    return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=1)
