"""Does a side of a board end where something lies before it, or where a shadow falls?

The edge of a sheet, a book or a table top is straight and does not stop where the board
does: it runs on beyond both ends of the side, with the same tone behind it. The squares
in a shadow are as many times darker as the shadow is, dark and bright alike.
"""

import numpy as np

from raxel.features.find.agreement import CHANCE
from raxel.features.find.ends import MIDDLE, steps_across
from raxel.features.find.grids import LEAST_SIDE
from raxel.features.find.patches import patches_of, predicted
from raxel.features.find.rim import grey_at, side_named, sides_of
from raxel.features.find.sides import lengths_outward

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
