"""Where a board ends: is a side row of corners one, or the edge of the paper?

About a corner dark and bright change places along the row on both of its sides. Where a
board ends, the edges between its outermost squares meet the edge of these squares or of
the paper, and what lies beyond has no part in the change: paper, table or cloth. A
chance pattern there makes a few corners pass one by one; all fields beyond the row
together do not change in step with the board.
"""

from typing import NamedTuple

import numpy as np

from raxel.features.chessboard.corners import QUADRANT, sampled, uneven
from raxel.features.chessboard.grids import (
    CHANCE,
    FAKE_COUNT,
    FAKE_SHARE,
    LEAST_SIDE,
    MOST_CHANCE,
    MOST_UNEVEN,
    Grid,
    nearly_complete,
    patches_of,
    predicted,
    without,
)
from raxel.features.chessboard.sides import (
    MOST_UNEQUAL_END,
    grey_at,
    lengths_outward,
    side_named,
    sides_of,
)

# Between what a row of a board has, 1, and what the edge of a paper has, 0.
MIDDLE = 0.5
# Of the outermost squares of a board, so many are seen where it ends; as of its rows.
LEAST_WITHIN = 2 / 3


class Side(NamedTuple):
    """A side row of a grid: how its outer fields change, over how the board's do.

    name: which side, (axis, whether its end); cells: of the row, (rows, columns) bool;
    share: 1 for a row of a board, 0 for the edge of the paper, NaN where the image does
    not show it; sd of it; sound: how many of its corners have fields of the same tones
    on both sides; within: share of its places inside of which there are squares.
    """

    name: tuple
    cells: np.ndarray
    share: float
    sd: float
    sound: int
    within: float

    def is_edge(self, told):
        """Whether the row is certainly no row of corners; see `ended`."""
        length = np.count_nonzero(self.cells)
        most = min(FAKE_COUNT, FAKE_SHARE * length) if told else 0
        may_be_row = self.share >= MIDDLE or self.share + CHANCE * self.sd >= 1
        return self.sound <= most and not may_be_row

    @property
    def is_row(self):
        """Whether the row is certainly one of corners."""
        changes = self.share > MIDDLE and self.share - CHANCE * self.sd > 0
        return changes or self.sound > FAKE_SHARE * np.count_nonzero(self.cells)


def ended(grid, level, told):
    """The grid without side rows that are the edge of the paper, or a pattern beside.

    Such a row goes where all of it says so: no corner of it is sound, and its outer
    fields together do not change as the board's. With a size `told`, a few may be sound
    by chance: nothing but a board of this size is returned then. Corners that a hand
    leaves of a row are sound; where a shadow ends in a row its fields change as the
    board's. The board must be whole up to the first row that goes: something that
    covers the board's end covers squares as well.
    """
    left, first = grid, {}
    while edges := [side for side in sides_seen(left, level) if side.is_edge(told)]:
        edge = min(edges, key=lambda side: side.sound)
        first[edge.name] = edge.within
        left = without(left, edge.cells)
        if left.count < LEAST_SIDE**2:
            return grid
    return left if min(first.values(), default=1.0) >= LEAST_WITHIN else grid


def doubtful_side(grid, level):
    """Which side row may be one or the edge of the paper (`side_named`), or ''."""
    for side in sides_seen(grid, level):
        if not side.is_row:
            row = grid.points[side.cells & grid.known]
            return side_named(row, grid.points[grid.known])
    return ""


def sides_seen(grid, level):
    """The Sides of a grid that would leave a board without them, looked at in a Level.

    level: `saddles.Level`.
    """
    known = grid.known
    if min(known.shape) < LEAST_SIDE:
        return []
    points = np.where(known[..., None], grid.points, predicted(grid.points))
    patches, i, j = patches_of(points)
    even = known[i, j] & (uneven(patches, level) <= MOST_UNEVEN)
    sides = []
    for axis, at in enumerate((i, j)):
        if known.shape[axis] <= LEAST_SIDE:
            continue
        steps, inside = steps_across(patches, level, axis)
        steps = steps * np.where((i + j) % 2 == 0, 1.0, -1.0)[:, None]
        for end, outer in ((0, 0), (known.shape[axis] - 1, 1)):
            row = at == end
            beyond, within = steps[:, outer], steps[:, 1 - outer]
            usual = [_mean(within[(np.abs(at - end) == k) & inside]) for k in range(2)]
            usual = max(usual, key=abs)
            share, sd = np.nan, np.nan
            # Across a row of corners dark and bright change places.
            seen = -beyond[row & inside]
            if len(seen) >= LEAST_SIDE and usual:
                share = seen.mean() / usual
                sd = seen.std(ddof=1) / np.sqrt(len(seen)) / abs(usual)
            equal = np.abs(beyond + within) <= MOST_UNEVEN * np.abs(within)
            there = within[row & inside] / usual if usual else np.zeros(1)
            whole = np.mean(there > MIDDLE) if len(there) else 0.0
            cells = np.zeros_like(known)
            cells[(slice(None),) * axis + (end,)] = True
            sound = np.count_nonzero(row & even & equal)
            name = axis, bool(end)
            sides.append(Side(name, cells, share, sd, sound, whole))
    return sides


def _mean(values):
    return values.mean() if len(values) else 0.0


def steps_across(patches, level, axis):
    """(steps (N, 2), inside (N,)): from one field to the next along a row, before and
    behind it, over their mean; and which corners have their fields inside the image.

    Over their mean, since light that falls off takes dark and bright down alike.
    """
    along, across = np.meshgrid(QUADRANT, QUADRANT)
    along, across = along.ravel(), across.ravel()
    signs = ((-1, -1), (1, -1), (-1, 1), (1, 1))
    a = np.concatenate([x * along for x, _ in signs])
    b = np.concatenate([y * across for _, y in signs])
    s, t = (a, b) if axis == 0 else (b, a)
    pixels = patches.at(s, t)
    height, width = level.grey.shape
    most = level.scale * np.array([width - 1, height - 1])
    inside = np.all((pixels >= 0) & (pixels <= most), axis=(1, 2))
    grey = sampled(level, pixels).reshape(-1, 2, 2, along.size).mean(axis=3)
    step = grey[..., 1] - grey[..., 0]
    return step / np.maximum(grey.mean(axis=2), 1.0), inside


# A board of known size in a lattice that runs on over what lies about it. Tiles or
# checked cloth carry the lattice of a board on that is cut along its squares. What
# tells the two apart is by how much dark and bright differ, over their mean, since
# light takes both down alike: that changes at once where the board ends. So may the
# distance of corners, or few are seen there.


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


# Does a side of a board end where something lies before it, or where a shadow falls?
# The edge of a sheet, a book or a table top is straight and does not stop where the
# board does: it runs on beyond both ends of the side, with the same tone behind it.
# The squares in a shadow are as many times darker as the shadow is, dark and bright
# alike.


# Places beyond the end of a side, and to both sides of its edge, in squares: at the
# edge's foot, and farther out; and how many behind each of its squares.
ON = np.array([0.2, 0.45, 0.7, 0.95])
PER_SQUARE = 5
FOOT, FARTHER = 0.25, 0.5
# Lengths of outer squares farther than this from their median tell nothing of an edge.
OFF_LINE = 0.25
# On the scale of the squares: what is of one tone differs by less; an edge has a step
# of more, and of so many times what the tones on either side of it differ by. White
# paper upon white paper has a step of three hundredths.
ONE_TONE, STEP, SHARP = 0.1, 0.025, 4.0
# Of the places beyond the ends, so many must be seen, and the edge at this share: what
# lies before it may be of the same tone in places.
LEAST_SEEN, LEAST_SHARP = 3, 0.5
# Where a corner's four fields are looked at, (s, t).
FIELDS = tuple(0.3 * np.array(k) for k in ((1, -1, -1, 1), (1, 1, -1, -1)))


def covered_side(grid, image):
    """Which side's end is a straight edge that runs on beyond it (`side_named`), or ''.

    image: (height, width) uint8.
    """
    patches, _, _ = patches_of(grid.points)
    tones = grey_at(image, patches.at(*FIELDS).astype(np.float32))
    scale = max(np.subtract(*np.percentile(tones, (90, 10))), 1.0)
    for on_side, outward in sides_of(grid):
        side = patches.of(on_side)
        length = lengths_outward(grid, image, on_side, outward)
        if _runs_on(image, side, outward, length, scale):
            return side_named(side.p, grid.points[grid.known])
    return ""


def _runs_on(image, side, outward, length, scale):
    """Whether the edge at `length` outward of a side's corners runs on beyond it.

    Straight in the image, or bent as the side is: one lens bends near and far alike,
    but its middle bends nothing.
    """
    usual = np.abs(length - np.median(length)) < OFF_LINE
    if np.count_nonzero(usual) < LEAST_SIDE:
        return False
    axis = 0 if outward[0] else 1
    out = outward[axis] * (side.u, side.v)[axis]
    bent = (side.uu, side.vv)[axis]
    edge = side.p + length[:, None] * out + (length**2)[:, None] * bent
    steps = np.linalg.norm(np.diff(edge, axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(steps)])
    ends = -steps[0] * (1 + ON), along[-1] + steps[-1] * (1 + ON)
    last = np.array(image.shape[::-1]) - 2

    def runs_on(curve):
        def grey(at, off):
            aside = np.column_stack([np.interp(at, along, out[:, k]) for k in (0, 1)])
            pixels = np.vander(at, len(curve)) @ curve + off * aside
            inside = np.all((pixels >= 1) & (pixels <= last), axis=1)
            values = grey_at(image, pixels[None].astype(np.float32))[0] / scale
            return np.where(inside, values, np.nan)

        behind = grey(np.linspace(along[0], along[-1], PER_SQUARE * len(along)), FOOT)
        return _is_edge(behind, np.concatenate(ends), grey)

    degrees = (1, 2) if np.count_nonzero(usual) > LEAST_SIDE else (1,)
    return any(runs_on(np.polyfit(along[usual], edge[usual], k)) for k in degrees)


def _is_edge(behind, beyond, grey):
    """Whether what is `behind` a side (N,) goes on with an edge at places `beyond` its
    ends; grey(places, off): how bright it is there, off the edge."""
    behind = behind[np.isfinite(behind)]
    if not len(behind) or behind.std() > ONE_TONE:
        return False
    tones = np.array([grey(beyond, off) for off in (FARTHER, FOOT, -FOOT, -FARTHER)])
    far, foot, within, deep = tones[:, np.isfinite(tones).all(axis=0)]
    if len(foot) < LEAST_SEEN or np.abs(foot - np.median(behind)).max() > ONE_TONE:
        return False
    step, outer, inner = (np.abs(a) for a in (foot - within, far - foot, within - deep))
    of_one_tone = np.abs([far, foot] - np.median(behind)).max()
    least = max(STEP, SHARP * behind.std())
    sharp = step > np.maximum(SHARP * np.maximum(outer, inner), least)
    # What is of one tone throughout ends at once, also on ground whose tone changes.
    ends = step > np.maximum(inner, max(SHARP * of_one_tone, least))
    return np.mean(sharp | ends) >= LEAST_SHARP


def shaded_side(grid, level):
    """Which side has squares in a shadow behind it (`side_named`), or ''.

    level: `saddles.Level`. The fields of the next row are looked at, over their mean.
    """
    lattice = np.pad(grid.points, ((1, 1), (1, 1), (0, 0)), constant_values=np.nan)
    lattice = np.where(np.isfinite(lattice), lattice, predicted(lattice))
    patches, i, j = patches_of(lattice)
    high, wide = lattice.shape[:2]
    for axis, at, across, count, other in (
        (0, i, j, high, wide),
        (1, j, i, wide, high),
    ):
        steps, inside = steps_across(patches, level, axis)
        steps = steps * np.where((i + j) % 2 == 0, 1.0, -1.0)[:, None]
        for end, outer in ((0, 0), (count - 1, 1)):
            row = (at == end) & (across > 0) & (across < other - 1) & inside
            if np.count_nonzero(row) < LEAST_SIDE:
                continue
            usual = np.median(steps[row, 1 - outer])
            share = -steps[row, outer] / usual if usual else np.zeros(1)
            sd = share.std(ddof=1) / np.sqrt(len(share))
            if share.mean() - CHANCE * sd > MIDDLE:
                return side_named(patches.p[row], grid.points[grid.known])
    return ""
