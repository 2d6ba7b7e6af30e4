"""Is a grid of corners a board of equal squares, and whole on all sides?"""

import numpy as np

from raxel.features.chessboard.grids import patches_of, predicted
from raxel.features.chessboard.saddles import remapped

# Whether a board's pattern goes on where its outermost squares should end. From each
# outer corner an edge runs outward between two squares. At the end of the board the
# step across it dies away. Where another row of squares follows, however narrow, the
# step turns round at once: dark and bright change sides.


# How far along the edge, in squares, and how far from it the step is taken.
ALONG, ACROSS = 1.2, (0.1, 0.2)
# Where along it the step is surely that of the outermost squares.
RIM_NEAR = (0.1, 0.3)
# The step has ended below this share of itself, and has turned below its negative.
RIM_ENDED = 0.3
# A step that turns does so within so many px; beyond, something else may stand.
AT_ONCE_PX = 4.0
MOST_SAMPLES = 400
# Behind so many edges of a side, that many more squares may stand. A patterned ground
# turns every second step, three of a side's four by chance; squares turn all of them.
SHARE_OF_EDGES, SURE_SHARE_OF_EDGES = 0.6, 0.8


def runs_on_beyond(grid, image, share):
    """Which side of a complete grid more squares stand beyond (`side_named`), or ''.

    share: of a side's edges, how many must be followed by the turn of a next square.
    """
    patches, _, _ = patches_of(grid.points)
    for on_side, outward in sides_of(grid):
        side = patches.of(on_side)
        if _turned(image, side, outward).mean() > share:
            return side_named(side.p, grid.points)
    return ""


def sides_of(grid):
    """[(which corners of `patches_of` lie on a side, (s, t) outward of it)]: first and
    last row, first and last column."""
    _, i, j = patches_of(grid.points)
    high, wide = grid.points.shape[:2]
    return [
        (i == 0, (0, -1)),
        (i == high - 1, (0, 1)),
        (j == 0, (-1, 0)),
        (j == wide - 1, (1, 0)),
    ]


def side_named(side, points):
    """Where in the image a side's corners (n, 2) lie, from the middle of all."""
    off = side.mean(axis=0) - points.reshape(-1, 2).mean(axis=0)
    if abs(off[0]) > abs(off[1]):
        return "right side" if off[0] > 0 else "left side"
    return "bottom" if off[1] > 0 else "top"


def line_named(grid, axis, k):
    """Line k of a grid's rows (axis 0) or columns (1), as the image shows it: 'row 3
    from its top'. Counted from its nearer end, 1 for the outermost."""
    last = grid.known.shape[axis] - 1
    end, number = (0, k) if 2 * k <= last else (last, last - k)
    points = predicted(grid.points)
    points = np.where(grid.known[..., None], grid.points, points)
    side = points.take(end, axis=axis)
    side, points = (a[np.isfinite(a).all(axis=-1)] for a in (side, points))
    if not len(side):
        side = points[:1]
    name = side_named(side, points)
    line = "row" if name in ("top", "bottom") else "column"
    return f"{line} {number + 1} from its {name}"


def _turned(image, patches, outward):
    """Whether the step (N,) across the edges outward of corners turns round."""
    length = np.linalg.norm(patches.u if outward[0] else patches.v, axis=1)
    count = int(np.clip(ALONG * length.max(), 20, MOST_SAMPLES))
    along = np.linspace(0, ALONG, count)
    step = steps_outward(image, patches, outward, along)
    near = (along > RIM_NEAR[0]) & (along < RIM_NEAR[1])
    usual = np.median(step[:, near], axis=1, keepdims=True)
    share = np.divide(step, usual, out=np.ones_like(step), where=usual != 0)
    ended = (share < RIM_ENDED) & (along > RIM_NEAR[0])
    first = np.where(ended.any(axis=1), ended.argmax(axis=1), count)
    px = (along[1] * length)[:, None]
    after = (np.arange(count) - first[:, None]) * px
    at_once = (after >= 0) & (after <= AT_ONCE_PX)
    return np.where(at_once, share, 1.0).min(axis=1) < -RIM_ENDED


def steps_outward(image, patches, outward, along):
    """Grey step (N, M) across the edges that go outward, at shares `along` (M,)."""
    count = len(patches.p)
    sides = np.array([side * k for k in ACROSS for side in (1, -1)])
    axis = 0 if outward[0] else 1
    forth = np.broadcast_to(along[:, None] * outward[axis], (len(along), len(sides)))
    aside = np.broadcast_to(sides, forth.shape)
    s, t = (forth, aside) if axis == 0 else (aside, forth)
    pixels = patches.at(s.ravel(), t.ravel()).astype(np.float32)
    grey = grey_at(image, pixels).reshape(count, len(along), len(ACROSS), 2)
    return (grey[..., 0] - grey[..., 1]).mean(axis=2)


def grey_at(image, pixels):
    """Grey (N, M) float32 of an image (height, width) at px (N, M, 2) float32.

    Linear between pixels; beyond the image that of its rim.
    """
    import cv2

    u, v = (np.ascontiguousarray(pixels[..., k]) for k in (0, 1))
    return remapped(image, u, v, cv2.BORDER_REPLICATE).astype(np.float32)


# Steps of a lattice, as logarithms: a row's own may differ by so much from what the
# rows beside it say, at the end of a lattice by so much. The strongest lenses that were
# tried reach a third of it; a row of double height is at 0.69.
MOST_UNEQUAL, MOST_UNEQUAL_END = 0.3, 0.5
# Edges outward of corners are followed so far, in squares. An edge has ended where the
# step across it is below half of what it is near the corner.
REACH, SAMPLES, ENDED = 1.6, 160, 0.5
NEAR = (0.1, 0.3)
# Squares of which most end before this share were cut by something, if most of those on
# the opposite side are whole to WHOLE: only then does the lattice tell their length.
SHORT, WHOLE, MOST = 0.85, 0.12, 2 / 3
# What covers a few of them leaves this much: two or more, and a quarter of the side.
VERY_SHORT, LEAST_VERY_SHORT, SHARE_VERY_SHORT = 0.7, 2, 0.25
# What cuts them aslant makes them shorter along the side by a quarter of a square, and
# by so many times what single ones are off that line. It was an eighth, but strong
# lenses, whose bend nobody sees beyond a side, make whole squares seem to change by
# 0.16: two photographs of whole boards had been refused.
ASLANT, OFF_ASLANT = 0.25, 4.0

# So far behind the squares' end, but no farther out than from MARGIN_FROM, and so far
# aside of an edge, is looked for paper; DARK and WHITE on the scale of the squares.
MARGIN_AT, MARGIN_FROM = 0.15, 1.3
ASIDE = np.array([-0.25, -0.15, 0.15, 0.25])
DARK, WHITE = 0.1, 0.8
# Of a side's corners, so many must have these places inside the image.
LEAST_INSIDE = 1 / 3


def unequal_pitch(grid):
    """Why the squares of a grid are not equal, or ''.

    However a lens bends a board, its steps change from row to row as those before and
    after them say, in all columns alike.
    """
    for axis in (0, 1):
        lattice = grid.points if axis else grid.points.swapaxes(0, 1)
        length = np.log(np.linalg.norm(np.diff(lattice, axis=1), axis=2))
        if length.shape[1] < 3:
            continue
        inner = length[:, 1:-1] - (length[:, :-2] + length[:, 2:]) / 2
        ends = length[:, [0, -1]] - 2 * length[:, [1, -2]] + length[:, [2, -3]]
        off = np.concatenate([_medians(inner), _medians(ends)])
        share = off / np.repeat([MOST_UNEQUAL, MOST_UNEQUAL_END], [inner.shape[1], 2])
        worst = int(np.abs(share).argmax())
        if abs(share[worst]) > 1:
            what = "longer" if off[worst] > 0 else "shorter"
            k = [*range(1, inner.shape[1] + 1), 0, inner.shape[1] + 1][worst]
            lines = " and ".join(line_named(grid, axis, n) for n in (k, k + 1))
            return (
                f"its squares are not equal: those between {lines} are "
                f"{np.exp(abs(off[worst])):.1f} times {what} than those beside let "
                "expect; give a board of equal squares"
            )
    return ""


def _medians(off):
    """Medians (M,) of the columns of off (N, M), 0 where nothing is known."""
    known = np.isfinite(off).any(axis=0)
    return np.where(known, np.nanmedian(np.where(known, off, 0), axis=0), 0)


def cut_side(grid, image):
    """Which side's outer squares were cut short (`side_named`), or ''.

    A shadow or what covers part of a board cuts the squares of one side somewhere. A
    board may be printed with narrower squares at its end, but then on both sides, and
    equally narrow along each of them.
    """
    lengths = [lengths_outward(grid, image, *side) for side in sides_of(grid)]
    for here, opposite in ((0, 1), (1, 0), (2, 3), (3, 2)):
        whole = np.abs(lengths[opposite] - 1) < WHOLE
        cut = np.mean(lengths[here] < SHORT) >= MOST or _some_cut(lengths[here])
        if (cut and whole.mean() >= MOST) or _cut_aslant(lengths[here]):
            side = _corners_of(grid)[here]
            return side_named(side[np.isfinite(side[:, 0])], grid.points)
    return ""


def _some_cut(lengths):
    """Whether a few squares of a side (n,) end far before the others."""
    count = np.count_nonzero(lengths < VERY_SHORT)
    return count >= max(LEAST_VERY_SHORT, SHARE_VERY_SHORT * len(lengths))


def _cut_aslant(lengths):
    """Whether squares of a side (n,) become shorter from one to the next."""
    short, k = np.minimum(lengths, 1), np.arange(len(lengths))
    slope, first = np.polyfit(k, short, 1)
    off = np.abs(short - first - slope * k).max()
    change = abs(slope) * k[-1]
    return short.min() < VERY_SHORT and change > max(ASLANT, OFF_ASLANT * off)


def dark_side(grid, image):
    """Which side of a board has a shadow behind it where others have paper, or ''.

    The edge of a shadow may lie where squares end. Behind it is then as dark as a dark
    square, while behind two other sides lies white paper.
    """
    lengths = [lengths_outward(grid, image, *side) for side in sides_of(grid)]
    behind = np.array(
        [
            _white_behind(grid, image, *side, min(np.median(length), MARGIN_FROM))
            for side, length in zip(sides_of(grid), lengths, strict=True)
        ]
    )
    if np.any(behind < DARK) and np.count_nonzero(behind > WHITE) >= 2:
        side = _corners_of(grid)[np.nanargmin(behind)]
        return side_named(side[np.isfinite(side[:, 0])], grid.points)
    return ""


def _white_behind(grid, image, on_side, outward, length):
    """How white it is behind the squares of a side: 0 as a dark square, 1 as a bright
    one; the median over its corners of the darkest place. NaN where of fewer than a
    third of its corners all places lie inside the image."""
    patches, _, _ = patches_of(grid.points)
    patches = patches.of(on_side)

    def places(along):
        axis = 0 if outward[0] else 1
        s, t = np.full(len(ASIDE), along * outward[axis]), ASIDE
        s, t = (s, t) if axis == 0 else (t, s)
        return patches.at(s, t).astype(np.float32)

    near, far = places(np.mean(NEAR)), places(length + MARGIN_AT)
    most = np.array(image.shape[::-1]) - 1
    inside = np.all((far >= 0) & (far <= most), axis=(1, 2))
    if inside.mean() < LEAST_INSIDE:
        return np.nan
    squares, behind = (grey_at(image, at[inside]) for at in (near, far))
    dark, bright = squares.min(axis=1), squares.max(axis=1)
    share = (behind.min(axis=1) - dark) / np.maximum(bright - dark, 1.0)
    return np.median(share)


def _corners_of(grid):
    """Corners (n, 2) of the sides, in the order of `sides_of`."""
    points = grid.points
    return points[0], points[-1], points[:, 0], points[:, -1]


def lengths_outward(grid, image, on_side, outward):
    """Lengths (n,) of the edges that run outward of a side's corners, in squares."""
    patches, _, _ = patches_of(grid.points)
    along = np.linspace(0, REACH, SAMPLES)
    step = steps_outward(image, patches.of(on_side), outward, along)
    near = (along > NEAR[0]) & (along < NEAR[1])
    usual = np.median(step[:, near], axis=1, keepdims=True)
    share = np.divide(step, usual, out=np.ones_like(step), where=usual != 0)
    ended = (share < ENDED) & (along > NEAR[0])
    return np.where(ended.any(axis=1), along[ended.argmax(axis=1)], REACH)
