"""From a lattice of links to a grid of verified corners."""

from __future__ import annotations

from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from raxel.features.chessboard.corners import (
    FULL_EFFORT,
    HALF_WINDOW_STEPS,
    QUICK_EFFORT,
    SYMMETRY_HALF_WINDOW_STEPS,
    asymmetry,
    localise_corners,
    squares_around,
    symmetry_shift,
)
from raxel.features.chessboard.outer_corners import outer_corner_error

# Uncertainty of corners from their own edges. Pixel noise alone does not determine the
# error of a corner in an image that was compressed, smoothed or clipped, nor the
# aliasing of edges sharper than pixels: such errors are correlated over many pixels.
# But the inner and the outer part of a corner's window determine it independently
# (`corners.LocalisedCorners.disagreement`). Their difference, in SDs of what noise
# alone explains, estimates the ratio of the actual error to that of noise. One corner
# gives a poor estimate; its neighbours share its light and blur.


# SD in steps of the Gaussian weights of neighbours.
NEIGHBOUR_SIGMA_STEPS = 1.5
# Prior weights, in numbers (each corner gives two): for a board, that the errors are
# those of noise; for a corner, that its errors are those of its board.
BOARD_PRIOR_WEIGHT, CORNER_PRIOR_WEIGHT = 2.0, 2.0
# A larger deviation, in SDs, belongs to one corner and not to its neighbours. So many
# rounds, each with the SDs of the last, leave little of the largest one, also where a
# row of corners is in the edge of a shadow: it is a third of its neighbourhood.
CLIP_SIGMAS, N_CLIP_ROUNDS = 1.5, 12
# Fraction of the variance of a Gaussian that clipping at CLIP_SIGMAS leaves.
CLIPPED_VARIANCE = 0.778
# A corner whose two parts disagree by more than this many SDs is less certain than its
# neighbours; up to there the difference is a statistical fluctuation.
CHANCE_SIGMAS = 2.5


def noise_ratio(disagreement):
    """Ratio of the errors of corners to those of noise alone, (rows, columns).

    disagreement: (rows, columns, 2), see `corners.LocalisedCorners`, NaN where there is
    no corner.
    """
    known = np.isfinite(disagreement[..., 0])
    square = np.where(known[..., None], disagreement, 0.0) ** 2
    usual = np.full(known.shape, np.inf)
    for _ in range(N_CLIP_ROUNDS):
        cut = np.minimum(square, (CLIP_SIGMAS**2 * usual)[..., None])
        usual = _neighbourhood_mean(cut / CLIPPED_VARIANCE, known)
    own = np.sqrt(square.max(axis=2)) / CHANCE_SIGMAS
    return np.where(known, np.maximum(np.sqrt(usual), own), np.nan)


def clip_at_median(times):
    """`noise_ratio` (rows, columns), clipped at the median of the board."""
    known = times[np.isfinite(times)]
    return np.minimum(times, np.median(known)) if len(known) else times


def add_shift_variance(sd, shift):
    """SDs (N,) px of corners with a symmetry shift of `shift` (N,) px included.

    The part of the shift above a statistical fluctuation is added. A disturbance of the
    whole window (the soft edge of a shadow, a stain) moves its inner and its outer part
    alike.
    """
    return np.hypot(sd, np.sqrt(np.maximum(shift**2 - (CHANCE_SIGMAS * sd) ** 2, 0)))


def _neighbourhood_mean(square, known):
    """Weighted mean (rows, columns) of numbers (rows, columns, 2) around every cell."""
    board = (square.sum() + BOARD_PRIOR_WEIGHT) / (
        2 * np.count_nonzero(known) + BOARD_PRIOR_WEIGHT
    )
    rows, columns = (_neighbour_weights(count) for count in known.shape)
    total = rows @ square.sum(axis=2) @ columns
    count = rows @ (2.0 * known) @ columns
    return (total + CORNER_PRIOR_WEIGHT * board) / (count + CORNER_PRIOR_WEIGHT)


def _neighbour_weights(count):
    """Weights (count, count) of the cells of a row for each other."""
    steps = np.subtract.outer(np.arange(count), np.arange(count))
    return np.exp(-(steps**2) / (2 * NEIGHBOUR_SIGMA_STEPS**2))


# Local shape of the lattice. Around corner p the lattice is x(s, t) = p + s u + t v +
# s^2 uu + t^2 vv + s t w, with the neighbours of p at s, t = -1, 0, 1. In (s, t) the
# edges are straight and perpendicular under any lens distortion, so that windows are
# squares.


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
        """The same shapes around corners shifted by (N, 2) px."""
        return self._replace(p=self.p + shift)

    def shrunk(self, share):
        """The same shapes in (s, t) scaled by share (N,)."""
        one = share[:, None]
        bent = (one**2 * a for a in (self.uu, self.vv, self.w))
        return Patches(self.p, one * self.u, one * self.v, *bent)

    def of(self, index):
        """The patches with these indices."""
        return Patches(*(a[index] for a in self))

    @property
    def size(self):
        """Length in px of the shorter of u and v, (N,)."""
        return np.minimum(*(np.linalg.norm(a, axis=1) for a in (self.u, self.v)))


def shifted(grid, rows, columns):
    """grid[i + rows, j + columns], NaN outside; grid (rows, columns, ...)."""
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
    """Predict each corner from the others: (rows, columns, 2), NaN where unknown.

    The mean of neighbours on both sides, where both exist. Otherwise the median of
    lines extrapolated and of parallelograms.
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
    any_known = known.any(axis=0)
    stack[:, ~any_known] = 0
    known[:, ~any_known] = True
    ordered = np.sort(np.where(known[..., None], stack, np.inf), axis=0)
    count = known.sum(axis=0)
    low, high = (count - 1) // 2, count // 2
    pick = [
        np.take_along_axis(ordered, k[None, ..., None], axis=0)[0] for k in (low, high)
    ]
    middle = (pick[0] + pick[1]) / 2
    middle[~any_known] = np.nan
    return middle


def patches_of(grid):
    """(Patches, rows (N,), columns (N,)) of the corners of a grid that have a shape.

    Missing neighbours are predicted. A corner that is alone in its row or column has no
    shape.
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
    """As `patches_of`, for corners on the sides, with extrapolated curvature.

    `patches_of` gives a corner on a side the curvature of the corner next to it.
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


MAX_GROWTH_ROUNDS = 12
OUTER_SNAP_STEPS, INNER_SNAP_STEPS = 0.3, 0.45
MIN_NODE_DISTANCE_PX = 3.0
MIN_NEIGHBOUR_CONTRAST_RATIO = 0.35
# Of the median, in a lattice not verified yet: light may vary across it.
MIN_MEDIAN_CONTRAST_RATIO = 0.4
MAX_LATTICE_MISFIT = 0.45
# Largest misfit of an added corner, relative to its neighbours: blur is similar there.
MAX_MISFIT_RATIO, MISFIT_MARGIN = 1.7, 0.05
# Up to a tenth of a step, noise does not move a corner to another square.
MAX_LATTICE_SD_STEPS = 0.1
MIN_N_SIDE_CORNERS = 3
# One in so many corners of a row or column may be missing. Chance patterns next to a
# board add rows that are nearly empty. With two thirds of each row known, no row is one
# of those.
MIN_CORNERS_PER_MISSING = 3
MAX_STRAY_FRACTION, MAX_N_STRAYS = 0.25, 2
# For a known size: a row with half of its corners is not a chance pattern, and three
# outer corners of a lattice of this size determine the fourth.
MIN_ROW_FRACTION, MIN_N_OUTER_CORNERS = 0.5, 3
# Half windows in px of the finest level: the next one is used where a corner is too
# uncertain.
HALF_WINDOWS_PX = (7.0, 14.0, 28.0)
SIMILAR_MISFIT_RATIO, CLEARER_MISFIT_RATIO = 1.2, 0.6
WIDER_WINDOW_SD_PX, WIDER_WINDOW_MISFIT = 0.03, 0.25
MAX_SHARP_SD_PX = 0.05
# SD of the aliasing of edges that are sharper than pixels, which both parts of a window
# share. Measured on noise-free rendered corners at random positions, rotated freely or
# along the pixels, blur 0.3 to 1.2 px.
SAMPLING_SD_PX = 0.002
# Half occluded corners of rendered boards are at 0.3 and above. Whole corners of the
# recorded images and of rendered boards in uneven light are below 0.2.
MAX_ASYMMETRY = 0.25
# A third of a pixel.
MAX_CORNER_SD_PX = 1 / 3
# Largest window of the symmetry test in px. In larger windows, under strong distortion,
# edges deviate from the local shape of the lattice.
MAX_SYMMETRY_WINDOW_PX = 10.0
# Samples along the window of the symmetry test. Dense samples, less than a pixel apart,
# measure what moves a corner; thin samples, farther apart, the aliasing of sharp edges.
N_DENSE_SAMPLES, N_THIN_SAMPLES = 24, 12


class Grid(NamedTuple):
    """Verified corners of one lattice, (rows, columns, ...), NaN where missing.

    points px; sd: see `raxel.sets.model`; misfit: see `corners.LocalisedCorners`;
    contrast: smallest difference between neighbouring squares; sign: of the square
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
    """The Grid grown from corners `start` (rows, columns, 2), NaN where unknown.

    nodes: (N, 2) px of detected corners, used where the lattice predicts one; level:
    the finest. None if no part of the lattice passes the checks.
    """
    rows, columns = start.shape[:2]
    empty = np.full((rows, columns), np.nan)
    blank = Grid(np.full_like(start, np.nan), *(empty.copy() for _ in range(4)))
    grid = accept_corners(blank, start, np.isfinite(start[..., 0]), level)
    grid = _largest_part(grid)
    for _ in range(MAX_GROWTH_ROUNDS):
        if grid.count < 4:
            return None
        grid = padded(_cropped(grid))
        before = grid.count
        for wanted, snap in (
            (_holes(grid), INNER_SNAP_STEPS),
            (_outer_neighbours(grid), OUTER_SNAP_STEPS),
        ):
            guess = predicted(grid.points)
            near = _snap_to_nodes(guess, grid.points, nodes, snap)
            for trial in (near, guess):
                if grid.count == before:
                    grid = accept_corners(grid, trial, wanted, level)
        if grid.count == before:
            break
    grid = _cropped(_largest_part(grid))
    return grid if grid.count >= 4 else None


def refine_grid(grid, levels):
    """A complete grid with every corner localised as precisely as possible.

    levels: from smooth to sharp. A sharper level is used where noise leaves a corner
    certain in it, since smoothing biases corners of small squares. The SD is that of
    pixel noise, scaled by `noise_ratio`, plus the aliasing of pixels (SAMPLING_SD_PX)
    and the symmetry shift above fluctuations. An occluded corner has an infinite SD,
    since the edges of the occluder take part in the fit undetected. So has a corner
    with a symmetry shift above MAX_CORNER_SD_PX and above fluctuations, whose SD is
    clipped at the median of the board: a row along the edge of a shadow disagrees with
    itself.
    """
    grid = Grid(*(a.copy() for a in grid))
    disagreement = np.full((*grid.known.shape, 2), np.nan)
    half = np.full(grid.known.shape, np.nan)
    for number, level in enumerate(levels):
        patches, i, j = patches_of(grid.points)
        found = localise_in_windows(patches, level, FULL_EFFORT)
        better = found.good & ((number == 0) | (found.sd < MAX_SHARP_SD_PX))
        grid.sd[i, j] = np.where(found.good, grid.sd[i, j], np.inf)
        i, j = i[better], j[better]
        grid.points[i, j], grid.sd[i, j] = found.points[better], found.sd[better]
        grid.misfit[i, j] = found.misfit[better]
        disagreement[i, j] = found.disagreement[better]
        half[i, j] = found.half[better]
    times = noise_ratio(disagreement)
    sd, chance = (
        np.hypot(grid.sd * k, SAMPLING_SD_PX) for k in (times, clip_at_median(times))
    )
    patches, i, j = patches_of(grid.points)
    near = patches.shrunk(_window_fraction(patches, levels[0]))
    thin = symmetry_shift(near, levels[0], N_THIN_SAMPLES)
    rejected = (thin > MAX_CORNER_SD_PX) & (thin > CHANCE_SIGMAS * chance[i, j])
    rejected |= asymmetry(patches, levels[0]) > MAX_ASYMMETRY
    shift = np.full(sd.shape, np.nan)
    shift[i, j] = symmetry_shift(near, levels[0], N_DENSE_SAMPLES)
    shift = _replace_side_shifts(shift, grid.points, levels[0])[i, j]
    sd[i, j] = add_shift_variance(np.maximum(sd[i, j], thin / CHANCE_SIGMAS), shift)
    sd[i, j] = np.where(rejected, np.inf, sd[i, j])
    u, v = np.full((2, *sd.shape), np.nan)
    u[i, j], v[i, j] = (np.linalg.norm(a, axis=1) for a in (patches.u, patches.v))
    return grid._replace(sd=np.hypot(sd, outer_corner_error(grid.misfit, half, u, v)))


def _replace_side_shifts(shift, points, level):
    """Shifts (rows, columns), at the sides those of the better of two curvatures.

    The curvature of the lattice is not observed there. The one with the smaller
    symmetry shift is used.
    """
    patches, i, j = side_patches_of(points)
    if not len(i):  # part of a board without its outer lines
        return shift
    near = patches.shrunk(_window_fraction(patches, level))
    shift[i, j] = np.fmin(shift[i, j], symmetry_shift(near, level, N_DENSE_SAMPLES))
    return shift


def _window_fraction(patches, level):
    """Fraction (N,) of the spacing of a MAX_SYMMETRY_WINDOW_PX window, at most 1."""
    longer = np.maximum(*(np.linalg.norm(a, axis=1) for a in (patches.u, patches.v)))
    return np.minimum(
        1, MAX_SYMMETRY_WINDOW_PX * level.scale / (SYMMETRY_HALF_WINDOW_STEPS * longer)
    )


def _holes(grid):
    """Cells without a corner between two that have one, (rows, columns) bool."""
    side = {d: np.isfinite(shifted(grid.points, *d)[..., 0]) for d in AXES}
    right, left, below, above = (side[d] for d in AXES)
    return ~grid.known & ((right & left) | (below & above))


def _outer_neighbours(grid):
    """Other cells next to a corner."""
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
        (rows, columns, 2) px (u, v), NaN where unknown.
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
    found = localise_in_windows(patches, level, QUICK_EFFORT)
    patches = patches._replace(p=found.points)
    fields = squares_around(patches, level)
    parity = np.where((i + j) % 2 == 0, fields.sign, -fields.sign)
    flip = np.where(np.add.outer(*map(np.arange, known.shape)) % 2 == 0, 1, -1)
    common = np.nansum(grid.sign * flip) if known.any() else parity.sum()
    height, width = level.grey.shape
    upper = level.scale * np.array([width - 2, height - 2])
    inside = np.all((found.points > level.scale) & (found.points < upper), axis=1)
    good = found.good & fields.alternate & (parity * common > 0) & inside
    good &= (found.misfit < MAX_LATTICE_MISFIT) & (
        found.sd < MAX_LATTICE_SD_STEPS * patches.size
    )
    if known.any():
        good &= (
            fields.contrast
            > MIN_NEIGHBOUR_CONTRAST_RATIO
            * _extreme_around(grid.contrast, np.fmin)[i, j]
        )
        usual = _extreme_around(grid.misfit, np.fmax)[i, j]
        good &= found.misfit < MAX_MISFIT_RATIO * usual + MISFIT_MARGIN
    elif good.any():
        good &= fields.contrast > MIN_MEDIAN_CONTRAST_RATIO * np.median(
            fields.contrast[good]
        )
    i, j = i[good], j[good]
    filled = Grid(*(a.copy() for a in grid))
    filled.points[i, j] = found.points[good]
    filled.sd[i, j] = found.sd[good]
    filled.misfit[i, j] = found.misfit[good]
    filled.contrast[i, j] = fields.contrast[good]
    filled.sign[i, j] = fields.sign[good]
    return filled


def localise_in_windows(patches, level, effort):
    """As `localise_corners`, each corner in the first window that suits it.

    Wider windows are for corners that noise leaves uncertain, and for corners whose
    edges do not meet in a point: blur fills the window, more so between edges at a
    sharp angle.
    """
    best = localise_corners(patches, level, HALF_WINDOWS_PX[0], effort)
    longer = np.maximum(*(np.linalg.norm(a, axis=1) for a in (patches.u, patches.v)))
    for last, window in pairwise(HALF_WINDOWS_PX):
        unsure = (
            (best.sd > WIDER_WINDOW_SD_PX)
            | (best.misfit > WIDER_WINDOW_MISFIT)
            | ~best.good
        )
        retried = np.flatnonzero(
            unsure & (HALF_WINDOW_STEPS * longer > effort.widening * last * level.scale)
        )
        if not len(retried):
            break
        other = localise_corners(patches.of(retried), level, window, effort)
        sharper = other.sd < best.sd[retried]
        similar = other.misfit < SIMILAR_MISFIT_RATIO * best.misfit[retried]
        clearer = other.misfit < CLEARER_MISFIT_RATIO * best.misfit[retried]
        better = ~best.good[retried] | (sharper & similar) | clearer
        replace_rows(best, other, retried, other.good & better)
    return best


def replace_rows(best, other, rows, better):
    """Copy the better ones of `other` into the rows `rows` of `best`."""
    for mine, theirs in zip(best, other, strict=True):
        mine[rows[better]] = theirs[better]


def _extreme_around(values, choose):
    """Smallest or largest (np.fmin, np.fmax) of the eight values around each cell.

    Smallest contrast, since light may fall off steeply across a board.
    """
    around = [shifted(values, a, b) for a in (-1, 0, 1) for b in (-1, 0, 1)]
    return choose.reduce(around)


def _snap_to_nodes(guess, grid, nodes, share):
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
    nodes = nodes[nearest(nodes, known)[1] >= MIN_NODE_DISTANCE_PX]
    if not len(nodes):
        return guess
    index, distance = nearest(guess[i, j], nodes)
    near = distance < reach
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


def mask_corners(grid, removed):
    """The grid without the corners in the cells `removed` (rows, columns) bool."""
    masked = Grid(*(a.copy() for a in grid))
    for a in masked:
        a[removed] = np.nan
    return masked


def without(grid, removed):
    """As `mask_corners`, also without side rows and columns that become empty."""
    return _cropped(mask_corners(grid, removed))


def is_nearly_complete(grid, known_size=False):
    """Whether a grid may be a whole board with some corners missing.

    At most one in MIN_CORNERS_PER_MISSING of each row and column may be missing. For a
    known size, a grid with three outer corners and MIN_ROW_FRACTION of each side ends
    where the board does: one row or column may have more missing, if so many of all
    corners are known. Incomplete lattices of cloth and screens have several such rows.
    """
    missing = ~grid.known
    if min(missing.shape) < MIN_N_SIDE_CORNERS:
        return False
    rows, columns = (missing.mean(axis=axis) for axis in (1, 0))
    empty = MIN_CORNERS_PER_MISSING * np.concatenate([rows, columns]) > 1
    sides = rows[[0, -1]], columns[[0, -1]]
    outer = ~missing[[0, 0, -1, -1], [0, -1, 0, -1]]
    ends_known = (
        known_size
        and outer.sum() >= MIN_N_OUTER_CORNERS
        and np.max(sides) <= 1 - MIN_ROW_FRACTION
        and MIN_CORNERS_PER_MISSING * missing.mean() <= 1
    )
    return bool(empty.sum() <= ends_known)


def trimmed(grid):
    """The grid without nearly empty side rows, if few corners are missing then.

    Isolated corners there are a chance pattern next to the board.
    """
    result = grid
    while min(result.known.shape) > MIN_N_SIDE_CORNERS and not is_nearly_complete(
        result
    ):
        removed, count, length = _emptiest_side(result)
        if count > min(MAX_N_STRAYS, MAX_STRAY_FRACTION * length):
            break
        result = without(result, removed)
    return result if is_nearly_complete(result) else grid


def cut_to(grid, sizes):
    """The grid without side rows that are mostly empty, if it then has one of `sizes`.

    For a known size: a row of which less than MIN_ROW_FRACTION is known, outside a
    nearly complete board of this size, is a chance pattern in the board's
    border. A row with half of its corners or more may be the board's own.
    """
    result = grid
    while (
        min(result.known.shape) > MIN_N_SIDE_CORNERS and result.known.shape not in sizes
    ):
        removed, count, length = _emptiest_side(result)
        if count >= MIN_ROW_FRACTION * length:
            break
        result = without(result, removed)
    return (
        result
        if result.known.shape in sizes and is_nearly_complete(result, known_size=True)
        else grid
    )


def _emptiest_side(grid):
    """(cells (rows, columns) bool, known corners, cells) of the emptiest side."""
    known = grid.known
    sides = {
        (0, 0): known[0],
        (0, -1): known[-1],
        (1, 0): known[:, 0],
        (1, -1): known[:, -1],
    }
    (axis, end), row = min(sides.items(), key=lambda side: side[1].mean())
    cells = np.zeros_like(known)
    cells[(slice(None),) * axis + (end,)] = True
    return cells, row.sum(), len(row)


def _largest_part(grid):
    """The grid reduced to its largest connected set of corners."""
    import cv2

    known = grid.known.astype(np.uint8)
    _, parts = cv2.connectedComponents(known, connectivity=4)
    sizes = np.bincount(parts.ravel())
    if len(sizes) < 2:
        return grid
    sizes[0] = 0
    return without(grid, parts != sizes.argmax())
