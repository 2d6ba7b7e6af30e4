"""Where a board ends: is a side row of corners one, or the edge of the paper?

About a corner dark and bright change places along the row on both of its sides. Where a
board ends, the edges between its outermost squares meet the edge of these squares or of
the paper, and what lies beyond has no part in the change: paper, table or cloth. A
chance pattern there makes a few corners pass one by one; all fields beyond the row
together do not change in step with the board.
"""

from typing import NamedTuple

import numpy as np

from raxel.features.find.agreement import CHANCE
from raxel.features.find.corners import QUADRANT, sampled, uneven
from raxel.features.find.grids import (
    FAKE_COUNT,
    FAKE_SHARE,
    LEAST_SIDE,
    MOST_UNEVEN,
    without,
)
from raxel.features.find.patches import patches_of, predicted
from raxel.features.find.rim import side_named

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
