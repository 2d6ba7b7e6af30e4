"""A chessboard with a spatial code: which part of it does an image show? (6.3.1)

P. Vuylsteke and A. Oosterlinck (IEEE PAMI 12(2), 148-164, 1990) mark the corners of a
chessboard with the bits of a code of which no small window occurs twice. Here a bit is
a mark, or none, in the middle of a square, and no window occurs twice in any of its
four turns. The code needs to know which squares are neighbours; the corners in order,
from `celect`, say so however the image is bent.
"""

from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from raxel.errors import InputError

MOST_REPAIRS = 5000
"""Bits changed before a code is given up as too hard."""

RING = (0.17, 0.5, 0.83)
"""Where a square's own colour is read, as shares of its sides; not in its middle."""

MARK_REACH = 0.09
"""Half of the side over which a mark is read, as a share of the square's."""

UNCLEAR = 0.2
"""A mark that is read within this of one half is neither there nor missing."""

MOST_CHANCE = 1e-3
"""Probability from which on that the marks fit by chance the block is refused."""

LEAST_LEAD = 3
"""How many marks the second best place must have wrong more than the best."""


class CodedGrid(NamedTuple):
    """The code: bits (rows, columns) bool, and what holds of its windows.

    Square (0, 0) is white. Any two different `window` x `window` squares of it, in any
    two turns, differ in at least `distance` bits, or in the colour of their squares.
    """

    bits: np.ndarray
    window: int
    distance: int


class Squares(NamedTuple):
    """What was read in the squares of a block of corners, (rows - 1, columns - 1).

    level: grey of the square itself; white: whether it is brighter than its neighbours;
    mark: 0 where its middle is like itself, 1 where it is as a mark ought to be.
    """

    level: np.ndarray
    white: np.ndarray
    mark: np.ndarray


class Location(NamedTuple):
    """Where a block lies on the grid, or why that is not known.

    indices (rows, columns, 2) int: (row, column) on the grid of every corner, as the
    upper left corner of the square of that number; -1 where not found. errors: marks
    that do not fit; unclear: marks that were not read; chance: probability that any
    place fits so well by chance; reason: one line, empty if found.
    """

    found: bool
    indices: np.ndarray
    errors: int
    unclear: int
    chance: float
    reason: str


def coded_grid(rows, columns, rng, *, window=5, distance=5):
    """A CodedGrid of rows x columns squares.

    From random bits of the numpy Generator `rng`: a bit of a window that is too like
    another is changed, and stays so if no more pairs are too alike than before, until
    none are. Raises InputError where this does not end: then there is no such code, or
    it is too hard to find.
    """
    if min(rows, columns) < window or window < 1 or distance < 1:
        raise InputError(
            f"coded grid: found {rows} x {columns} squares, window {window}, distance "
            f"{distance}; give a grid no smaller than its window, and positive numbers"
        )
    bits = rng.random((rows, columns)) < 0.5
    alike, pairs = _too_alike(bits, window, distance)
    for _ in range(MOST_REPAIRS):
        if not pairs:
            return CodedGrid(bits, window, distance)
        row, column = rng.choice(alike) + rng.integers(0, window, 2)
        bits[row, column] ^= True
        now, left = _too_alike(bits, window, distance)
        if left <= pairs:
            alike, pairs = now, left
        else:
            bits[row, column] ^= True
    raise InputError(
        f"coded grid: found no code of {rows} x {columns} squares with windows of "
        f"{window} and distance {distance}; give a larger window or a smaller distance"
    )


def least_distance(bits, window):
    """Fewest bits in which two windows of a grid (rows, columns) differ, in any turns.

    Of windows whose squares have the same colours; two turns of one window count too.
    """
    words = turned_windows(np.asarray(bits, bool), window)
    return int(min(_distances(w).min() for w, _ in words))


def turned_windows(bits, window):
    """For each colour of the first square: words (n, window^2), places (n, 2).

    All windows in all four turns; the place is that of the window's first square on
    the grid, before it is turned.
    """
    views = sliding_window_view(bits, (window, window))
    rows, columns = np.indices(views.shape[:2])
    words, places, white = [], [], []
    for turns in range(4):
        words.append(np.rot90(views, turns, (2, 3)).reshape(-1, window * window))
        places.append(np.column_stack((rows.ravel(), columns.ravel())))
        first = _first_is_white(rows, columns, window, window, turns)
        white.append(first.ravel())
    words, places, white = map(np.concatenate, (words, places, white))
    return [(words[white == w], places[white == w]) for w in (True, False)]


def _first_is_white(rows, columns, high, wide, turns):
    """Whether the first square of a window is white after it is turned by np.rot90."""
    down, across = ((0, 0), (0, wide - 1), (high - 1, wide - 1), (high - 1, 0))[turns]
    return (rows + columns + down + across) % 2 == 0


def _distances(words):
    """Differing bits of every pair of words (n, k), (n, n); the diagonal is k + 1."""
    signs = np.where(words, np.float32(1), np.float32(-1))
    apart = (words.shape[1] - signs @ signs.T) / 2
    np.fill_diagonal(apart, words.shape[1] + 1)
    return apart


def _too_alike(bits, window, distance):
    """Windows with another nearer than `distance`: places (n, 2), number of pairs."""
    alike, pairs = [], 0
    for words, places in turned_windows(bits, window):
        near = _distances(words) < distance
        alike.append(places[near.any(axis=1)])
        pairs += int(near.sum())
    return np.concatenate(alike), pairs


def read_squares(image, corners, contrast=1.0):
    """The Squares of a block of corners (rows, columns, 2) px in a grey image.

    Every square is read in its own coordinates: bilinear between its four corners. Its
    colour is that against its neighbours, so light may vary; `contrast` of a mark to
    its square is a share of that of the neighbours.
    """
    ring = [(x, y) for y in RING for x in RING if (x, y) != (0.5, 0.5)]
    steps = 0.5 + MARK_REACH * np.linspace(-1, 1, 5)
    middle = [(x, y) for y in steps for x in steps]
    level = _sampled(image, corners, np.array(ring)).mean(axis=-1)
    centre = _sampled(image, corners, np.array(middle)).mean(axis=-1)
    other = _mean_of_neighbours(level)
    full = contrast * (other - level)
    mark = np.full(level.shape, np.nan)
    np.divide(centre - level, full, out=mark, where=full != 0)
    return Squares(level, other < level, mark)


def _sampled(image, corners, places):
    """Grey values (rows - 1, columns - 1, n) at places (n, 2) in every square."""
    import cv2

    x, y = places.T[:, :, None]
    a, b = corners[:-1, :-1, None], corners[:-1, 1:, None]
    c, d = corners[1:, :-1, None], corners[1:, 1:, None]
    points = (1 - y) * ((1 - x) * a + x * b) + y * ((1 - x) * c + x * d)
    u, v = np.moveaxis(points.astype(np.float32), -1, 0)
    flat = cv2.remap(
        image.astype(np.float32),
        u.reshape(len(u), -1),
        v.reshape(len(v), -1),
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_REPLICATE,
    )
    return flat.reshape(u.shape)


def _mean_of_neighbours(level):
    """Mean of the two to four neighbours by a side, of a map (rows, columns)."""
    total, count = np.zeros_like(level), np.zeros_like(level)
    for here, there in (
        (np.s_[1:], np.s_[:-1]),
        (np.s_[:-1], np.s_[1:]),
        (np.s_[:, 1:], np.s_[:, :-1]),
        (np.s_[:, :-1], np.s_[:, 1:]),
    ):
        total[here] += level[there]
        count[here] += 1
    return total / np.maximum(count, 1)


def locate(squares, grid):
    """The Location of a block of Squares on a CodedGrid.

    The block is laid on every place of the grid in all four turns (not mirrored: it was
    clicked the right way round). The place with the fewest marks wrong is taken if the
    colours take turns, if so good a fit of any place by chance has a probability below
    0.001, and if every other place has at least three more marks wrong. Else it is
    refused: better no place than a wrong one.
    """
    high, wide = squares.white.shape
    size = high + 1, wide + 1
    known = np.abs(squares.mark - 0.5) >= UNCLEAR
    unclear = int((~known).sum())
    wrong = _wrong_colours(squares.white)
    if wrong:
        return _refused(size, unclear, f"colours do not take turns in {wrong} squares")
    fits = _fits(squares.mark > 0.5, known, squares.white[0, 0], grid.bits)
    if not len(fits):
        return _refused(size, unclear, "the block is larger than the grid")
    order = np.argsort(fits[:, 0], kind="stable")
    errors, turns, row, column = fits[order[0]]
    chance = chance_of(int(known.sum()), int(errors), len(fits))
    if chance > MOST_CHANCE:
        reason = f"{errors} marks wrong and {unclear} unclear: too many to be sure"
        return _refused(size, unclear, reason, int(errors), chance)
    if len(fits) > 1 and fits[order[1], 0] - errors < LEAST_LEAD:
        reason = "two places on the grid fit nearly as well as each other"
        return _refused(size, unclear, reason, int(errors), chance)
    indices = _indices(size, turns, row, column)
    return Location(True, indices, int(errors), unclear, chance, "")


def chance_of(known, errors, places):
    """Probability, at most 1, that random marks fit any of the places so well.

    A union bound over places of the binomial tail for `known` marks.
    """
    from scipy.stats import binom

    return min(1.0, places * float(binom.cdf(errors, known, 0.5)))


def _fits(marked, known, white, bits):
    """(errors, turns, row, column) of every place where the colours fit, (n, 4) int."""
    fits = []
    for turns in range(4):
        block, sure = np.rot90(marked, turns), np.rot90(known, turns)
        high, wide = block.shape
        if high > bits.shape[0] or wide > bits.shape[1]:
            continue
        views = sliding_window_view(bits, block.shape)
        errors = ((views != block) & sure).sum(axis=(2, 3))
        rows, columns = np.indices(errors.shape)
        first = _first_is_white(rows, columns, high, wide, (4 - turns) % 4)
        place = np.stack((errors, np.full_like(errors, turns), rows, columns), axis=-1)
        fits.append(place[first == white])
    return np.concatenate(fits) if fits else np.empty((0, 4), int)


def _indices(size, turns, row, column):
    """Corners' (row, column) on the grid, (rows, columns, 2), in the block's order."""
    high, wide = size if turns % 2 == 0 else size[::-1]
    indices = np.stack(np.indices((high, wide)), axis=-1) + (row, column)
    return np.rot90(indices, -turns)


def _wrong_colours(white):
    """Squares whose colour breaks the turns of colours: the fewer of the two ways."""
    parity = np.indices(white.shape).sum(axis=0) % 2 == 0
    wrong = int((white != parity).sum())
    return min(wrong, white.size - wrong)


def _refused(size, unclear, reason, errors=0, chance=1.0):
    return Location(False, np.full((*size, 2), -1), errors, unclear, chance, reason)
