"""A board of known size in a lattice that runs on over what lies about it.

Tiles or checked cloth carry the lattice of a board on that is cut along its squares.
What tells the two apart is by how much dark and bright differ, over their mean, since
light takes both down alike: that changes at once where the board ends. So may the
distance of corners, or few are seen there.
"""

import numpy as np

from raxel.features.find.agreement import CHANCE
from raxel.features.find.ends import steps_across
from raxel.features.find.grids import LEAST_SIDE, MOST_CHANCE, Grid, nearly_complete
from raxel.features.find.patches import patches_of, predicted
from raxel.features.find.sides import MOST_UNEQUAL_END

# What differs by this share of the board's own difference is of other tones: paint,
# ink and light from aside differ by less from row to row of one board.
OTHER_TONES = 0.2
# Rings of corners that a lattice is run on by, to tell which the image would show.
FORETOLD = 3


def window_of(grid, sizes, level):
    """The part of a grid that is a board of one of `sizes`, (rows, columns), or None.

    level: `saddles.Level`. Two thirds of each of its rows are seen, and beyond each of
    its sides the grid ends, holds little, or has other tones or another pitch. None as
    well where that holds for several parts, and of a grid that is whole: another board.
    """
    if nearly_complete(grid):
        return None
    known, found = grid.known, []
    rooms = [
        (slice(i, i + high), slice(j, j + wide))
        for high, wide in set(sizes)
        for i in range(len(known) - high + 1)
        for j in range(known.shape[1] - wide + 1)
    ]
    steps = _steps(grid, level) if rooms else None
    shown = _shown(grid.points, level) if rooms else None
    for room in rooms:
        part = Grid(*(a[room] for a in grid))
        if nearly_complete(part) and _ends(grid.points, shown, steps, room):
            found.append(part)
    return found[0] if len(found) == 1 else None


def _steps(grid, level):
    """Steps (rows, columns, 2) from field to field along rows, before and behind them,
    and along columns; of one sign behind on a whole board, of the other before."""
    points = np.where(grid.known[..., None], grid.points, predicted(grid.points))
    patches, i, j = patches_of(points)
    both = []
    for axis in (0, 1):
        steps, inside = steps_across(patches, level, axis)
        steps = steps * np.where((i + j) % 2 == 0, 1.0, -1.0)[:, None]
        all_steps = np.full((*grid.known.shape, 2), np.nan)
        all_steps[i, j] = np.where(inside[:, None], steps, np.nan)
        both.append(all_steps)
    return both


def _shown(points, level):
    """Which corners of a lattice (rows, columns, 2) the image would show, as far as
    they can be foretold: what it does not show says nothing of where a board ends."""
    for _ in range(FORETOLD):
        points = np.where(np.isfinite(points), points, predicted(points))
    height, width = level.grey.shape
    most = level.scale * np.array([width - 2, height - 2])
    return ~((points <= level.scale) | (points >= most)).any(axis=2)


def _ends(points, shown, steps, room):
    """Whether a part of a lattice, two slices, ends at all of its sides.

    points: (rows, columns, 2); shown: see `_shown`; steps: see `_steps`.
    """
    for axis, of_axis in enumerate(steps):
        along = room[1 - axis]
        lines, corners, there = (
            a.swapaxes(0, axis)[:, along] for a in (of_axis, points, shown)
        )
        first, last = room[axis].start, room[axis].stop - 1
        for beyond, inward, outer in ((first - 1, 1, 0), (last + 1, -1, 1)):
            if not 0 <= beyond < len(lines):
                continue
            seen = np.isfinite(corners[beyond, there[beyond], 0])
            few = len(seen) >= LEAST_SIDE and seen.mean() < MOST_CHANCE
            next_ones = corners[[beyond + k * inward for k in range(3)]]
            own = lines[first : last + 1, :, 1 - outer]
            tones = -lines[beyond, :, outer]
            if not (few or _other_pitch(next_ones) or _other_tones(tones, own)):
                return False
    return True


def _other_pitch(lines):
    """Whether the first of three lines of corners (3, n, 2) stands as no board's."""
    lengths = np.log(np.linalg.norm(np.diff(lines, axis=0), axis=2))
    off = np.subtract(*lengths)
    off = off[np.isfinite(off)]
    return len(off) >= LEAST_SIDE and abs(np.median(off)) > MOST_UNEQUAL_END


def _other_tones(beyond, own):
    """Whether steps (n,) beyond a side are surely not as a board's `own` (rows, n),
    which may differ from row to row: with the paint of its squares, or in glare."""
    beyond = beyond[np.isfinite(beyond)]
    of_rows = np.array([row[np.isfinite(row)].mean() for row in own if _some(row)])
    if len(beyond) < LEAST_SIDE or len(of_rows) < LEAST_SIDE or not of_rows.mean():
        return False
    usual = of_rows.mean()
    sd = beyond.std(ddof=1) / np.sqrt(len(beyond))
    chance = np.hypot(sd, of_rows.std(ddof=1)) / abs(usual)
    return abs(beyond.mean() / usual - 1) > max(OTHER_TONES, CHANCE * chance)


def _some(row):
    return np.isfinite(row).any()
