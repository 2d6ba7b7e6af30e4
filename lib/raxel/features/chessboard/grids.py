"""From a lattice of links to a grid of verified corners: checked, filled, run on."""

from __future__ import annotations

from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from raxel.features.chessboard.corners import (
    FULL,
    QUICK,
    TURNED,
    WINDOW,
    fields_of,
    half_turned,
    placed,
    uneven,
)

# How certain corners are by what their own edges say. The noise of single pixels does
# not tell how well a corner is placed in a picture that was compressed, smoothed or
# clipped, nor what pixels do to edges that are sharper than they: its errors are
# alike over many pixels. But the near and the far part of a corner's window say
# independently of each other where it lies (`corners.Placed.apart`). How far they are
# apart, in SDs of what noise alone would do, says how many times larger than that of
# noise the error of the corner itself is. One corner says it badly; those around it
# lie in the same light and blur.


# How far neighbours count: weights fall off with this SD, in steps.
NEAR = 1.5
# As much as so many numbers, of which each corner has two, is known beforehand: of
# a board, that errors are those of noise; of a corner, that they are its board's.
BEFORE, OF_BOARD = 2.0, 2.0
# What stands out by more SDs than these is one corner's, and no neighbour's. So many
# rounds, each with the last one's SDs, leave little of the largest, also where a row of
# corners lies in the edge of a shadow: it is a third of those around its neighbours.
STANDS_OUT, AGREEMENT_ROUNDS = 1.5, 12
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
    for _ in range(AGREEMENT_ROUNDS):
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


# The neighbourhood of each corner, as its own lattice bends it. Around corner p the
# lattice is x(s, t) = p + s u + t v + s^2 uu + t^2 vv + s t w, with p's neighbours at
# s, t = -1, 0, 1. In (s, t) the edges are straight and cross at right angles,
# whatever the lens, so windows are squares there.


AXES = ((0, 1), (0, -1), (1, 0), (-1, 0))


class Patches(NamedTuple):
    """Local shape of a lattice at N corners, px: each field is (N, 2)."""

    p: np.ndarray
    u: np.ndarray
    v: np.ndarray
    uu: np.ndarray
    vv: np.ndarray
    w: np.ndarray

    def at(self, s, t):
        """Pixels (N, *shape, 2) of (s, t), arrays of one shape."""
        s, t = s[..., None], t[..., None]
        of = Patches(*(a.reshape(len(a), *(1,) * (s.ndim - 1), 2) for a in self))
        bent = s * s * of.uu + t * t * of.vv + s * t * of.w
        return of.p + s * of.u + t * of.v + bent

    def moved(self, shift):
        """The same shapes around corners moved by shift (N, 2) px."""
        return self._replace(p=self.p + shift)

    def shrunk(self, share):
        """The same bends, for (s, t) that are the share (N,) of theirs."""
        one = share[:, None]
        bent = (one**2 * a for a in (self.uu, self.vv, self.w))
        return Patches(self.p, one * self.u, one * self.v, *bent)

    def of(self, index):
        """Some of them."""
        return Patches(*(a[index] for a in self))

    @property
    def size(self):
        """Length in px of the shorter of u and v, (N,)."""
        return np.minimum(*(np.linalg.norm(a, axis=1) for a in (self.u, self.v)))


def shifted(grid, rows, columns):
    """grid[i + rows, j + columns], NaN beyond its ends; grid (rows, columns, ...)."""
    out = np.full_like(grid, np.nan)
    height, width = grid.shape[:2]
    i, j = (
        slice(max(0, -rows), height - max(0, rows)),
        slice(max(0, -columns), width - max(0, columns)),
    )
    k, m = (
        slice(max(0, rows), height + min(0, rows)),
        slice(max(0, columns), width + min(0, columns)),
    )
    if i.start < i.stop and j.start < j.stop:
        out[i, j] = grid[k, m]
    return out


def predicted(grid):
    """Where each corner should be, from the others: (rows, columns, 2), NaN unknown.

    The middle of neighbours on both sides, where there are such; else the median of
    lines run on and of parallelograms.
    """
    near = {d: shifted(grid, *d) for d in AXES}
    far = {d: shifted(grid, 2 * d[0], 2 * d[1]) for d in AXES}
    between, beyond = [], []
    for d in ((0, 1), (1, 0)):
        e = -d[0], -d[1]
        plain = (near[d] + near[e]) / 2
        better = (4 * (near[d] + near[e]) - far[d] - far[e]) / 6
        between.append(np.where(np.isfinite(better), better, plain))
    for d in AXES:
        third = shifted(grid, 3 * d[0], 3 * d[1])
        line = 2 * near[d] - far[d]
        curve = line + near[d] - 2 * far[d] + third
        beyond.append(np.where(np.isfinite(curve), curve, line))
    for d in AXES[:2]:
        for e in AXES[2:]:
            corner = shifted(grid, d[0] + e[0], d[1] + e[1])
            beyond.append(near[d] + near[e] - corner)
    inner = _median(between)
    return np.where(np.isfinite(inner), inner, _median(beyond))


def _median(arrays):
    stack = np.stack(arrays)
    known = np.isfinite(stack).all(axis=-1)
    some = known.any(axis=0)
    stack[:, ~some] = 0
    known[:, ~some] = True
    ordered = np.sort(np.where(known[..., None], stack, np.inf), axis=0)
    count = known.sum(axis=0)
    low, high = (count - 1) // 2, count // 2
    pick = [
        np.take_along_axis(ordered, k[None, ..., None], axis=0)[0] for k in (low, high)
    ]
    middle = (pick[0] + pick[1]) / 2
    middle[~some] = np.nan
    return middle


def patches_of(grid):
    """(Patches, rows (N,), columns (N,)) of the corners of a grid that have a shape.

    Neighbours that are missing are predicted; corners alone in their row or column
    have no shape.
    """
    full = np.pad(grid, ((1, 1), (1, 1), (0, 0)), constant_values=np.nan)
    guess = predicted(full)
    near = np.where(np.isfinite(full), full, guess)
    ring = {d: shifted(near, *d) for d in AXES}
    for d in AXES:
        opposite = ring[-d[0], -d[1]]
        ring[d] = np.where(np.isfinite(ring[d]), ring[d], 2 * full - opposite)
    right, left, below, above = (ring[d] for d in AXES)
    u, v = (right - left) / 2, (below - above) / 2
    uu, vv = (right + left) / 2 - full, (below + above) / 2 - full
    turns = [
        a * b * (shifted(near, a, b) - full - b * u - a * v - uu - vv)
        for a in (-1, 1)
        for b in (-1, 1)
    ]
    w = _mean(turns)
    shape = [full, u, v, uu, vv, w]
    known = np.isfinite(np.concatenate(shape[:5], axis=-1)).all(axis=-1)
    i, j = np.nonzero(known)
    return Patches(*(a[i, j] for a in shape)), i - 1, j - 1


def side_patches_of(grid):
    """As `patches_of`, of corners on the sides, with bends that change as inside.

    `patches_of` gives a corner on a side the bend of the one next to it.
    """
    full = np.pad(grid, ((1, 1), (1, 1), (0, 0)), constant_values=np.nan)
    for a, b in AXES:
        line = [shifted(full, k * a, k * b) for k in (1, 2, 3, 4)]
        cubic = 4 * line[0] - 6 * line[1] + 4 * line[2] - line[3]
        full = np.where(np.isfinite(full), full, cubic)
    full[1:-1, 1:-1] = grid
    patches, i, j = patches_of(full)
    rows, columns = grid.shape[:2]
    inside = (i > 0) & (i <= rows) & (j > 0) & (j <= columns)
    side = inside & ((i == 1) | (i == rows) | (j == 1) | (j == columns))
    return patches.of(side), i[side] - 1, j[side] - 1


def _mean(arrays):
    stack = np.stack(arrays)
    known = np.isfinite(stack)
    return np.where(known, stack, 0).sum(axis=0) / np.maximum(known.sum(axis=0), 1)


ROUNDS = 12
SNAP, INNER_SNAP = 0.3, 0.45
TAKEN_PX = 3.0
LEAST_CONTRAST = 0.35
# Of the median, in a lattice that is not checked yet: light may vary across it.
FIRST_SHARE = 0.4
MOST_MISFIT = 0.45
# Most of a corner that is added, by those beside it: blur is alike there.
MISFIT_RATIO, MISFIT_MORE = 1.7, 0.05
LEAST_SPACING = 4.0
LEAST_SIDE = 3
# One in so many of a row or column may be missing. Chance patterns beside a board add
# rows that are nearly empty; with two thirds of each seen, no row is one of those.
ONE_MISSING_OF = 3
FAKE_SHARE, FAKE_COUNT = 0.25, 2
# Of a row beyond a board whose size is known: half of it is no chance any more.
MOST_CHANCE = 0.5
# Windows in px of the finest level: the next is taken where a corner is too uncertain.
WINDOWS = (7.0, 14.0, 28.0)
ALIKE, CLEARER = 1.2, 0.6
SURE_SD, SURE_MISFIT = 0.03, 0.25
SHARP_SD = 0.05
# SD of what pixels do to edges as sharp as they are without its showing: both parts of
# a window err alike. Of corners drawn without noise at random places, turned anyhow or
# along the pixels, blur 0.3 to 1.2 px.
SAMPLING_PX = 0.002
# Half covered corners of drawn boards are at 0.3 and above, whole ones of the recorded
# photographs and of drawn boards in uneven light below 0.2.
MOST_UNEVEN = 0.25
# Three of them are a pixel.
MOST_SD = 1 / 3
# How far from a corner half a turn says where it is: beyond, edges bend otherwise than
# the lattice about it says, where a lens bends strongly.
TURNED_PX = 10.0
# Samples along a window that half a turn moves: less than a pixel apart they say what
# moves its corner; farther apart, what pixels do to edges as sharp as they are.
DENSE, THIN = 24, 12


class Grid(NamedTuple):
    """Verified corners of one lattice, (rows, columns, ...), NaN where there is none.

    points px; sd: see `raxel.sets.model`; misfit: see `corners.Placed`;
    contrast: smallest difference between neighbouring fields; sign: of the field
    between rising rows and columns.
    """

    points: np.ndarray
    sd: np.ndarray
    misfit: np.ndarray
    contrast: np.ndarray
    sign: np.ndarray

    @property
    def known(self):
        """Which cells hold a corner, (rows, columns) bool."""
        return np.isfinite(self.points[..., 0])

    @property
    def count(self):
        """Number of corners."""
        return int(np.count_nonzero(self.known))

    @property
    def complete(self):
        """Whether every cell holds a corner."""
        return bool(self.known.all())


def grid_of(start, nodes, level):
    """The Grid that grows from corners `start` (rows, columns, 2), NaN where none.

    nodes: (N, 2) px of corners that were seen, taken where the lattice says that one
    should be; level: the finest. None if nothing of it stands the checks.
    """
    rows, columns = start.shape[:2]
    empty = np.full((rows, columns), np.nan)
    blank = Grid(np.full_like(start, np.nan), *(empty.copy() for _ in range(4)))
    grid = accept_corners(blank, start, np.isfinite(start[..., 0]), level)
    grid = _largest_part(grid)
    for _ in range(ROUNDS):
        if grid.count < 4:
            return None
        grid = padded(_cropped(grid))
        before = grid.count
        for wanted, snap in (_holes(grid), INNER_SNAP), (_rim(grid), SNAP):
            guess = predicted(grid.points)
            near = _snapped(guess, grid.points, nodes, snap)
            for trial in (near, guess):
                if grid.count == before:
                    grid = accept_corners(grid, trial, wanted, level)
        if grid.count == before:
            break
    grid = _cropped(_largest_part(grid))
    return grid if grid.count >= 4 else None


def settled(grid, levels):
    """A complete grid with every corner placed as well as can be.

    levels: from smooth to sharp; a sharper one is taken where noise leaves a corner
    certain in it, for smoothing moves corners of small squares. The SD is that of the
    pixels' noise, as many times larger as edges say (`agreement`), what pixels do
    (SAMPLING_PX), and by how much half a turn moves the corner beyond chance.
    A corner of which something covers a part has an infinite SD: edges of what covers
    it take part in the fit, and nothing in the fit tells. So has one that half a turn
    moves by more than MOST_SD and by more than chance does, which is taken as usual on
    the board: a row along the edge of a shadow disagrees with itself.
    """
    grid = Grid(*(a.copy() for a in grid))
    apart = np.full((*grid.known.shape, 2), np.nan)
    for number, level in enumerate(levels):
        patches, i, j = patches_of(grid.points)
        put = placed_well(patches, level, FULL)
        better = put.good & ((number == 0) | (put.sd < SHARP_SD))
        grid.sd[i, j] = np.where(put.good, grid.sd[i, j], np.inf)
        i, j = i[better], j[better]
        grid.points[i, j], grid.sd[i, j] = put.points[better], put.sd[better]
        grid.misfit[i, j] = put.misfit[better]
        apart[i, j] = put.apart[better]
    times = times_noise(apart)
    sd, chance = (
        np.hypot(grid.sd * k, SAMPLING_PX) for k in (times, at_most_usual(times))
    )
    patches, i, j = patches_of(grid.points)
    near = patches.shrunk(_near_share(patches, levels[0]))
    thin = half_turned(near, levels[0], THIN)
    off = (thin > MOST_SD) & (thin > CHANCE * chance[i, j])
    off |= uneven(patches, levels[0]) > MOST_UNEVEN
    shift = np.full(sd.shape, np.nan)
    shift[i, j] = half_turned(near, levels[0], DENSE)
    shift = _at_sides(shift, grid.points, levels[0])[i, j]
    sd[i, j] = with_shift(np.maximum(sd[i, j], thin / CHANCE), shift)
    sd[i, j] = np.where(off, np.inf, sd[i, j])
    return grid._replace(sd=sd)


def _at_sides(shift, points, level):
    """Shifts (rows, columns), at the sides those by the bend that suits better.

    Nobody sees how the lattice bends there, and an even window tells.
    """
    patches, i, j = side_patches_of(points)
    if not len(i):  # part of a board whose outer lines nobody sees
        return shift
    near = patches.shrunk(_near_share(patches, level))
    shift[i, j] = np.fmin(shift[i, j], half_turned(near, level, DENSE))
    return shift


def _near_share(patches, level):
    """Share (N,) of the spacing that a window of TURNED_PX is, where it is less."""
    longer = np.maximum(*(np.linalg.norm(a, axis=1) for a in (patches.u, patches.v)))
    return np.minimum(1, TURNED_PX * level.scale / (TURNED * longer))


def _holes(grid):
    """Cells without a corner between two that have one, (rows, columns) bool."""
    side = {d: np.isfinite(shifted(grid.points, *d)[..., 0]) for d in AXES}
    right, left, below, above = (side[d] for d in AXES)
    return ~grid.known & ((right & left) | (below & above))


def _rim(grid):
    """Other cells beside a corner."""
    side = [np.isfinite(shifted(grid.points, *d)[..., 0]) for d in AXES]
    return ~grid.known & np.any(side, axis=0) & ~_holes(grid)


def accept_corners(
    grid: Grid, trial: np.ndarray, wanted: np.ndarray, level: Any
) -> Grid:
    """Return the grid with those of the trial corners that are corners.

    Parameters
    ----------
    grid : Grid
        Verified corners.
    trial : np.ndarray
        (rows, columns, 2) px (u, v), NaN where there is none.
    wanted : np.ndarray
        (rows, columns) bool: cells to be tested. Known cells stay as they are.
    level : saddles.Level
        The image at one scale.

    Returns
    -------
    Grid
        The same grid where no trial corner is accepted, else a copy with them.
    """
    known = grid.known
    wanted = wanted & np.isfinite(trial[..., 0]) & ~known
    points = np.where(wanted[..., None], trial, grid.points)
    patches, i, j = patches_of(points)
    new = wanted[i, j]
    if not new.any():
        return grid
    patches, i, j = patches.of(new), i[new], j[new]
    put = placed_well(patches, level, QUICK)
    patches = patches._replace(p=put.points)
    fields = fields_of(patches, level)
    parity = np.where((i + j) % 2 == 0, fields.sign, -fields.sign)
    flip = np.where(np.add.outer(*map(np.arange, known.shape)) % 2 == 0, 1, -1)
    common = np.nansum(grid.sign * flip) if known.any() else parity.sum()
    height, width = level.grey.shape
    rim = level.scale * np.array([width - 2, height - 2])
    inside = np.all((put.points > level.scale) & (put.points < rim), axis=1)
    good = put.good & fields.alternate & (parity * common > 0) & inside
    good &= (put.misfit < MOST_MISFIT) & (patches.size > LEAST_SPACING)
    if known.any():
        good &= fields.contrast > LEAST_CONTRAST * _beside(grid.contrast, np.fmin)[i, j]
        usual = _beside(grid.misfit, np.fmax)[i, j]
        good &= put.misfit < MISFIT_RATIO * usual + MISFIT_MORE
    elif good.any():
        good &= fields.contrast > FIRST_SHARE * np.median(fields.contrast[good])
    i, j = i[good], j[good]
    filled = Grid(*(a.copy() for a in grid))
    filled.points[i, j] = put.points[good]
    filled.sd[i, j] = put.sd[good]
    filled.misfit[i, j] = put.misfit[good]
    filled.contrast[i, j] = fields.contrast[good]
    filled.sign[i, j] = fields.sign[good]
    return filled


def placed_well(patches, level, effort):
    """As `placed`, each corner in the first window that suits it.

    Wider ones are for corners that noise leaves uncertain, and for those whose edges do
    not meet in a point: blur fills the window, more so between edges at a sharp angle.
    """
    best = placed(patches, level, WINDOWS[0], effort)
    longer = np.maximum(*(np.linalg.norm(a, axis=1) for a in (patches.u, patches.v)))
    for last, window in pairwise(WINDOWS):
        unsure = (best.sd > SURE_SD) | (best.misfit > SURE_MISFIT) | ~best.good
        again = np.flatnonzero(
            unsure & (WINDOW * longer > effort.wider * last * level.scale)
        )
        if not len(again):
            break
        other = placed(patches.of(again), level, window, effort)
        sharper = other.sd < best.sd[again]
        alike = other.misfit < ALIKE * best.misfit[again]
        clearer = other.misfit < CLEARER * best.misfit[again]
        better = ~best.good[again] | (sharper & alike) | clearer
        _replaced(best, other, again, other.good & better)
    return best


def _replaced(best, other, again, better):
    """Put the better ones of `other` in the places `again` of `best`."""
    for mine, theirs in zip(best, other, strict=True):
        mine[again[better]] = theirs[better]


def _beside(values, choose):
    """Smallest or largest (np.fmin, np.fmax) value among the eight around each cell.

    Smallest contrast, since light may fall off steeply across a board.
    """
    around = [shifted(values, a, b) for a in (-1, 0, 1) for b in (-1, 0, 1)]
    return choose.reduce(around)


def _snapped(guess, grid, nodes, share):
    """Guesses (rows, columns, 2) moved to a node within this share of a step."""
    from raxel.features.chessboard.compiled import nearest

    i, j = np.nonzero(np.isfinite(guess[..., 0]) & ~np.isfinite(grid[..., 0]))
    if not len(i) or not len(nodes):
        return guess
    steps = np.stack([np.linalg.norm(shifted(grid, *d) - guess, axis=2) for d in AXES])
    reach = share * np.nanmin(
        np.where(np.isfinite(steps), steps, np.inf)[:, i, j], axis=0
    )
    known = grid[np.isfinite(grid[..., 0])]
    nodes = nodes[nearest(nodes, known)[1] >= TAKEN_PX]
    if not len(nodes):
        return guess
    index, apart = nearest(guess[i, j], nodes)
    near = apart < reach
    guess = guess.copy()
    guess[i[near], j[near]] = nodes[index[near]]
    return guess


def padded(grid):
    """The grid with an empty row and column on each side."""
    return Grid(
        *(
            np.pad(a, ((1, 1), (1, 1), (0, 0))[: a.ndim], constant_values=np.nan)
            for a in grid
        )
    )


def _cropped(grid):
    """Without empty rows and columns at the sides."""
    known = grid.known
    if not known.any():
        return grid
    i, j = (np.flatnonzero(known.any(axis=axis)) for axis in (1, 0))
    return Grid(*(a[i[0] : i[-1] + 1, j[0] : j[-1] + 1] for a in grid))


def holed(grid, gone):
    """The grid with no corners in the cells `gone` (rows, columns) bool."""
    left = Grid(*(a.copy() for a in grid))
    for a in left:
        a[gone] = np.nan
    return left


def without(grid, gone):
    """As `holed`, and without the rows and columns at the sides that are empty then."""
    return _cropped(holed(grid, gone))


def nearly_complete(grid):
    """Whether a grid may be a whole board that lacks some corners (ONE_MISSING_OF)."""
    missing = ~grid.known
    few = all(
        (ONE_MISSING_OF * missing.sum(axis=axis) <= missing.shape[axis]).all()
        for axis in (0, 1)
    )
    return min(missing.shape) >= LEAST_SIDE and few


def trimmed(grid):
    """The grid without side rows that hold next to nothing, if little then is missing.

    What stands there by itself is a chance pattern beside the board.
    """
    left = grid
    while min(left.known.shape) > LEAST_SIDE and not nearly_complete(left):
        gone, count, length = _emptiest_side(left)
        if count > min(FAKE_COUNT, FAKE_SHARE * length):
            break
        left = without(left, gone)
    return left if nearly_complete(left) else grid


def cut_to(grid, sizes):
    """The grid without side rows that are mostly empty, if it then has one of `sizes`.

    For a size that somebody knows: a row of which less than half is seen (MOST_CHANCE),
    beyond a board of this size with two thirds of each row, is a chance pattern in the
    board's border. A row with half of its corners or more may be the board's own.
    """
    left = grid
    while min(left.known.shape) > LEAST_SIDE and left.known.shape not in sizes:
        gone, count, length = _emptiest_side(left)
        if count >= MOST_CHANCE * length:
            break
        left = without(left, gone)
    return left if left.known.shape in sizes and nearly_complete(left) else grid


def _emptiest_side(grid):
    """(cells (rows, columns) bool, corners there, cells there) of the emptiest side."""
    known = grid.known
    sides = {
        (0, 0): known[0],
        (0, -1): known[-1],
        (1, 0): known[:, 0],
        (1, -1): known[:, -1],
    }
    (axis, end), row = min(sides.items(), key=lambda side: side[1].mean())
    gone = np.zeros_like(known)
    gone[(slice(None),) * axis + (end,)] = True
    return gone, row.sum(), len(row)


def _largest_part(grid):
    """The grid with its largest set of corners that are neighbours."""
    import cv2

    known = grid.known.astype(np.uint8)
    _, parts = cv2.connectedComponents(known, connectivity=4)
    sizes = np.bincount(parts.ravel())
    if len(sizes) < 2:
        return grid
    sizes[0] = 0
    return without(grid, parts != sizes.argmax())
