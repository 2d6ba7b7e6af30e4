"""Are the fields between a lattice's corners squares: of one tone, with straight edges?

Seen in the lattice's own coordinates the border between two squares of a chessboard is
the line from corner to corner, however a lens bends it. The border of a disc is an arc:
it bulges out of every disc, so out of the fields of one tone, where a bend of the lens
goes the same way on both sides of a line. At the corners' own grey the border between
squares stays where it is, however they are blurred and whatever the response of the
camera. Only where ink or light leaves a gap at the corners is their grey that of the
gap; the border then stays at the middle between dark and bright.
"""

import numpy as np

from raxel.features.find.corners import sampled
from raxel.features.find.grids import LEAST_SIDE
from raxel.features.find.patches import AXES, patches_of, shifted

# Of a lattice, for something to be said of its fields.
LEAST_SEEN = 0.5
# Places along an edge at which its border is looked for, in squares: near its ends and
# in its middle; and places across it.
PLACES = np.array([0.2, 0.5, 0.8])
ACROSS = np.linspace(-0.35, 0.35, 29)
# How far the arc through the four corners of a square bulges between these places.
ARC = float(np.sqrt(0.5) - np.sqrt(0.5 - (PLACES[1] - PLACES[0]) ** 2))
# Half of it lies between a square and a disc.
MOST_BULGE = ARC / 2
# The part of a field that is looked at, and of it what may be of the other tone: a hole
# of a third of its side can be seen.
FILLED, FILLED_SAMPLES = (0.2, 0.8), 9
MOST_OTHER = 1 / 9


def shape_fault(grid, level):
    """Why the fields of a grid are no squares, or ''. level: `saddles.Level`.

    Nothing is said of a lattice of which less than half is seen.
    """
    known = grid.known
    if min(known.shape) < LEAST_SIDE or known.mean() < LEAST_SEEN:
        return ""
    if abs(bulge_of(grid, level)) > MOST_BULGE:
        return (
            "its fields are round, not square: this looks like a grid of circles; show "
            "a chessboard"
        )
    if other_tone(grid, level) > MOST_OTHER:
        return (
            "its fields are not filled evenly: there is something in the dark or the "
            "bright ones; a chessboard has plain squares, a ChArUco board "
            "(target.kind: charuco) markers in the bright ones"
        )
    return ""


def bulge_of(grid, level):
    """How far borders bulge out of dark fields (below 0: bright ones) between their
    ends and their middle, in squares.

    The mean of all edges between neighbours; 0 where none tells. At the grey of the
    corners, if it differs from edge to edge by less than squares differ from discs:
    where that is the grey of the fields, noise crosses it anywhere. Then at the middle.
    """
    edges = np.concatenate([_edges(axis, grid, level) for axis in (0, 1)], axis=1)
    at_corners, in_middle = (row[np.isfinite(row)] for row in edges)
    if len(at_corners) and at_corners.std() < MOST_BULGE:
        return at_corners.mean()
    return in_middle.mean() if len(in_middle) else 0.0


def _edges(axis, grid, level):
    """Bulges (2, N) of the edges along columns (axis 0) or rows (1): at the grey of the
    corners, and at the middle of dark and bright."""
    patches, i, j = patches_of(grid.points)
    number = np.full(grid.known.shape, -1)
    number[i, j] = np.arange(len(i))
    number = number if axis == 1 else number.T
    first, last = number[:, :-1].ravel(), number[:, 1:].ravel()
    both = (first >= 0) & (last >= 0)
    first, last = patches.of(first[both]), patches.of(last[both])
    along, across = np.meshgrid(PLACES, ACROSS, indexing="ij")
    a, b = along.ravel(), across.ravel()
    here = first.at(a, b) if axis == 1 else first.at(b, a)
    there = last.at(a - 1, b) if axis == 1 else last.at(b, a - 1)
    pixels = (1 - a[:, None]) * here + a[:, None] * there
    grey = sampled(level, pixels).reshape(-1, *along.shape)
    corners = sampled(level, np.stack([first.p, last.p], axis=1)).mean(axis=1)
    sides = grey[..., [0, -1]]
    brighter = np.sign((sides[..., 1] - sides[..., 0]).mean(axis=1))
    greys = corners, sides.mean(axis=(1, 2))
    return np.array([_arch(grey, at) * brighter for at in greys])


def _arch(grey, border_grey):
    """How far across the middle of edges (N, PLACES, ACROSS) the border at a grey (N,)
    lies from where it lies at their ends, (N,); NaN where there is no such border."""
    above = grey > border_grey[:, None, None]
    change = above[..., 1:] != above[..., :-1]
    nearest = np.where(change, np.abs(ACROSS[1:] + ACROSS[:-1]), np.inf)
    k = nearest.argmin(axis=-1)[..., None]
    low, high = (np.take_along_axis(grey, k + n, axis=-1)[..., 0] for n in (0, 1))
    rise = np.where(high != low, high - low, 1.0)
    share = (border_grey[:, None] - low) / rise
    border = ACROSS[k[..., 0]] + share * (ACROSS[1] - ACROSS[0])
    border = np.where(change.any(axis=-1), border, np.nan)
    return border[:, 1] - (border[:, 0] + border[:, 2]) / 2


def other_tone(grid, level):
    """The share of fields that is of the other tone: of the dark or of the bright ones,
    whichever is more, the median field.

    Which fields are bright is told at the corners. The tone of a field is that of its
    brightest tenth, or darkest: most of it may be covered.
    """
    grey = _fields(grid, level)
    odd = np.add.outer(*map(np.arange, grid.known.shape)) % 2 == 1
    even_bright = np.nansum(np.where(odd, -grid.sign, grid.sign)) > 0
    bright = odd[:-1, :-1] != even_bright
    low, high = np.percentile(grey, (10, 90), axis=2)
    tone = np.where(bright, high, low)
    beside = _mean([shifted(tone, *d) for d in AXES])
    above = grey > ((tone + beside) / 2)[..., None]
    other = (above != bright[..., None]).mean(axis=2)
    told = np.isfinite(tone + beside)
    each = [other[told & (bright == one)] for one in (True, False)]
    return max((np.median(some) for some in each if len(some)), default=0.0)


def _fields(grid, level):
    """Grey (rows - 1, columns - 1, N) of the inner part of fields, NaN where a corner
    is missing."""
    p = grid.points
    ring = p[:-1, :-1], p[:-1, 1:], p[1:, :-1], p[1:, 1:]
    k = np.linspace(*FILLED, FILLED_SAMPLES)
    t, s = (a.ravel() for a in np.meshgrid(k, k, indexing="ij"))
    weights = (1 - s) * (1 - t), s * (1 - t), (1 - s) * t, s * t
    pixels = sum(
        q[..., None, :] * w[:, None] for q, w in zip(ring, weights, strict=True)
    )
    known = np.isfinite(pixels[..., 0, 0])
    grey = np.full(pixels.shape[:-1], np.nan)
    if known.any():
        grey[known] = sampled(level, pixels[known])
    return grey


def _mean(arrays):
    """The mean of those that are known, NaN where none is."""
    stack = np.stack(arrays)
    known = np.isfinite(stack)
    count = np.where(known.any(axis=0), known.sum(axis=0), np.nan)
    return np.where(known, stack, 0).sum(axis=0) / count
