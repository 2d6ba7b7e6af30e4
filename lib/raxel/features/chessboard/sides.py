"""Is a grid of corners a board of equal squares, complete on all sides?"""

import numpy as np

from raxel.features.chessboard.grids import patches_of, predicted
from raxel.features.chessboard.saddles import remapped

# Continuation of the pattern beyond the outermost squares. From each outer corner an
# edge extends outward between two squares. At the end of the board the contrast across
# it vanishes. Where another row of squares follows, however narrow, the contrast
# reverses at once: dark and bright swap.


# Distance along the edge, in squares, and offsets from it at which the contrast is
# measured.
TURN_REACH_SQUARES, EDGE_OFFSETS_SQUARES = 1.2, (0.1, 0.2)
# Where along the edge the contrast is certainly that of the outermost squares.
TURN_NEAR_SQUARES = (0.1, 0.3)
# The contrast has ended below this fraction, and has reversed below its negative.
TURN_RATIO = 0.3
# A reversal occurs within this many px; beyond, another object may follow.
MAX_TURN_PX = 4.0
MAX_N_SAMPLES = 400
# Fraction of the edges of a side with a reversal above which squares follow. A
# patterned background reverses every second edge, three of a side's four by chance;
# squares reverse all of them.
MIN_TURNED_FRACTION, MIN_TURNED_FRACTION_KNOWN_SIZE = 0.6, 0.8


def runs_on_beyond(grid, image, share):
    """The side of a complete grid beyond which squares continue (`side_named`), or ''.

    share: fraction of a side's edges that must show the reversal of a next square.
    """
    patches, _, _ = patches_of(grid.points)
    for on_side, outward in sides_of(grid):
        side = patches.of(on_side)
        if _has_contrast_reversal(image, side, outward).mean() > share:
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
    """Name of a side in the image, from its corners (n, 2) and those of the board."""
    offset = side.mean(axis=0) - points.reshape(-1, 2).mean(axis=0)
    if abs(offset[0]) > abs(offset[1]):
        return "right side" if offset[0] > 0 else "left side"
    return "bottom" if offset[1] > 0 else "top"


def line_named(grid, axis, k):
    """Name of line k of a grid's rows (axis 0) or columns (1): 'row 3 from its top'.

    As in the image; counted from its nearer end, 1 for the outermost.
    """
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


def _has_contrast_reversal(image, patches, outward):
    """Whether the contrast (N,) across the edges outward of corners reverses."""
    length = np.linalg.norm(patches.u if outward[0] else patches.v, axis=1)
    count = int(np.clip(TURN_REACH_SQUARES * length.max(), 20, MAX_N_SAMPLES))
    along = np.linspace(0, TURN_REACH_SQUARES, count)
    step = steps_outward(image, patches, outward, along)
    near = (along > TURN_NEAR_SQUARES[0]) & (along < TURN_NEAR_SQUARES[1])
    usual = np.median(step[:, near], axis=1, keepdims=True)
    share = np.divide(step, usual, out=np.ones_like(step), where=usual != 0)
    ended = (share < TURN_RATIO) & (along > TURN_NEAR_SQUARES[0])
    first = np.where(ended.any(axis=1), ended.argmax(axis=1), count)
    px = (along[1] * length)[:, None]
    after = (np.arange(count) - first[:, None]) * px
    at_once = (after >= 0) & (after <= MAX_TURN_PX)
    return np.where(at_once, share, 1.0).min(axis=1) < -TURN_RATIO


def steps_outward(image, patches, outward, along):
    """Contrast (N, M) across edges outward of corners, at distances `along` (M,)."""
    count = len(patches.p)
    sides = np.array([side * k for k in EDGE_OFFSETS_SQUARES for side in (1, -1)])
    axis = 0 if outward[0] else 1
    forth = np.broadcast_to(along[:, None] * outward[axis], (len(along), len(sides)))
    sideways = np.broadcast_to(sides, forth.shape)
    s, t = (forth, sideways) if axis == 0 else (sideways, forth)
    pixels = patches.at(s.ravel(), t.ravel()).astype(np.float32)
    grey = grey_at(image, pixels).reshape(
        count, len(along), len(EDGE_OFFSETS_SQUARES), 2
    )
    return (grey[..., 0] - grey[..., 1]).mean(axis=2)


def grey_at(image, pixels):
    """Grey (N, M) float32 of an image (height, width) at px (N, M, 2) float32.

    Bilinear between pixels; outside the image that of its border.
    """
    import cv2

    u, v = (np.ascontiguousarray(pixels[..., k]) for k in (0, 1))
    return remapped(image, u, v, cv2.BORDER_REPLICATE).astype(np.float32)


# Steps of a lattice, as logarithms: largest deviation of a row from the prediction of
# its neighbours, inside and at the end of a lattice. The strongest distortion tested
# reaches a third of it; a row of double height is at 0.69.
MAX_LOG_STEP_CHANGE, MAX_LOG_STEP_CHANGE_END = 0.3, 0.5
# Largest length in squares at which outward edges are followed. An edge has ended where
# the contrast across it is below half of that near the corner.
LENGTH_REACH_SQUARES, N_LENGTH_SAMPLES, EDGE_END_RATIO = 1.6, 160, 0.5
NEAR_SQUARES = (0.1, 0.3)
# Truncated squares: most squares of a side end before this fraction, and most on the
# opposite side are complete to the tolerance. Only then does the lattice predict their
# length.
MAX_CUT_LENGTH, WHOLE_LENGTH_TOL, MIN_SIDE_FRACTION = 0.85, 0.12, 2 / 3
# A local occluder truncates at least two squares to this length, and a quarter of the
# side.
MAX_SHORT_LENGTH, MIN_N_SHORT, MIN_SHORT_FRACTION = 0.7, 2, 0.25
# An oblique occluder shortens squares along the side by a quarter of a square, and by
# this multiple of their deviation from a line. The first limit was an eighth. But
# distortion beyond a side is not observed, and strong lenses make complete squares seem
# to change by 0.16: two images of complete boards were rejected.
MIN_OBLIQUE_CHANGE, MIN_OBLIQUE_RATIO = 0.25, 4.0

# The margin is searched for white paper at this distance behind the end of the squares,
# but no farther out than from MAX_MARGIN_START_SQUARES, and at these lateral offsets
# from an edge. MAX_DARK_LEVEL and MIN_WHITE_LEVEL are relative to dark (0) and bright
# (1) squares.
MARGIN_DISTANCE_SQUARES, MAX_MARGIN_START_SQUARES = 0.15, 1.3
MARGIN_OFFSETS_SQUARES = np.array([-0.25, -0.15, 0.15, 0.25])
MAX_DARK_LEVEL, MIN_WHITE_LEVEL = 0.1, 0.8
# Smallest fraction of a side's corners with these positions inside the image.
MIN_MARGIN_INSIDE_FRACTION = 1 / 3


def unequal_pitch(grid):
    """Why the squares of a grid are not equal, or ''.

    Under any lens distortion, steps change from row to row as their neighbours predict,
    in all columns alike.
    """
    for axis in (0, 1):
        lattice = grid.points if axis else grid.points.swapaxes(0, 1)
        length = np.log(np.linalg.norm(np.diff(lattice, axis=1), axis=2))
        if length.shape[1] < 3:
            continue
        inner = length[:, 1:-1] - (length[:, :-2] + length[:, 2:]) / 2
        ends = length[:, [0, -1]] - 2 * length[:, [1, -2]] + length[:, [2, -3]]
        change = np.concatenate([_medians(inner), _medians(ends)])
        share = change / np.repeat(
            [MAX_LOG_STEP_CHANGE, MAX_LOG_STEP_CHANGE_END], [inner.shape[1], 2]
        )
        worst = int(np.abs(share).argmax())
        if abs(share[worst]) > 1:
            what = "longer" if change[worst] > 0 else "shorter"
            k = [*range(1, inner.shape[1] + 1), 0, inner.shape[1] + 1][worst]
            lines = " and ".join(line_named(grid, axis, n) for n in (k, k + 1))
            return (
                f"its squares are unequal: those between {lines} are "
                f"{np.exp(abs(change[worst])):.1f} times {what} than their "
                "neighbours predict; use a board of equal squares"
            )
    return ""


def _medians(values):
    """Medians (M,) of the columns of values (N, M), 0 where none is known."""
    known = np.isfinite(values).any(axis=0)
    return np.where(known, np.nanmedian(np.where(known, values, 0), axis=0), 0)


def truncated_side(grid, image):
    """The side whose outer squares are truncated (`side_named`), or ''.

    A shadow or an occluder truncates the squares of one side. A board may be printed
    with narrower squares at its ends, but then on both sides, and equally narrow along
    each of them.
    """
    lengths = [lengths_outward(grid, image, *side) for side in sides_of(grid)]
    for side_index, opposite in ((0, 1), (1, 0), (2, 3), (3, 2)):
        whole = np.abs(lengths[opposite] - 1) < WHOLE_LENGTH_TOL
        cut = np.mean(
            lengths[side_index] < MAX_CUT_LENGTH
        ) >= MIN_SIDE_FRACTION or _few_truncated(lengths[side_index])
        if (cut and whole.mean() >= MIN_SIDE_FRACTION) or _obliquely_truncated(
            lengths[side_index]
        ):
            side = _corners_of(grid)[side_index]
            return side_named(side[np.isfinite(side[:, 0])], grid.points)
    return ""


def _few_truncated(lengths):
    """Whether a few squares of a side (n,) end far before the others."""
    count = np.count_nonzero(lengths < MAX_SHORT_LENGTH)
    return count >= max(MIN_N_SHORT, MIN_SHORT_FRACTION * len(lengths))


def _obliquely_truncated(lengths):
    """Whether the squares of a side (n,) become shorter from one to the next."""
    short, k = np.minimum(lengths, 1), np.arange(len(lengths))
    slope, first = np.polyfit(k, short, 1)
    deviation = np.abs(short - first - slope * k).max()
    change = abs(slope) * k[-1]
    return short.min() < MAX_SHORT_LENGTH and change > max(
        MIN_OBLIQUE_CHANGE, MIN_OBLIQUE_RATIO * deviation
    )


def dark_side(grid, image):
    """The side of a board with a shadow where other sides have white paper, or ''.

    The edge of a shadow may coincide with the end of squares. The margin is then as
    dark as a dark square, while two other sides have a white margin.
    """
    lengths = [lengths_outward(grid, image, *side) for side in sides_of(grid)]
    behind = np.array(
        [
            _margin_brightness(
                grid, image, *side, min(np.median(length), MAX_MARGIN_START_SQUARES)
            )
            for side, length in zip(sides_of(grid), lengths, strict=True)
        ]
    )
    if (
        np.any(behind < MAX_DARK_LEVEL)
        and np.count_nonzero(behind > MIN_WHITE_LEVEL) >= 2
    ):
        side = _corners_of(grid)[np.nanargmin(behind)]
        return side_named(side[np.isfinite(side[:, 0])], grid.points)
    return ""


def _margin_brightness(grid, image, on_side, outward, length):
    """Brightness of the margin of a side: 0 as a dark square, 1 as a bright one.

    The median over its corners of the darkest position. NaN where fewer than
    MIN_MARGIN_INSIDE_FRACTION of its corners have all positions inside the image.
    """
    patches, _, _ = patches_of(grid.points)
    patches = patches.of(on_side)

    def positions(along):
        axis = 0 if outward[0] else 1
        s, t = (
            np.full(len(MARGIN_OFFSETS_SQUARES), along * outward[axis]),
            MARGIN_OFFSETS_SQUARES,
        )
        s, t = (s, t) if axis == 0 else (t, s)
        return patches.at(s, t).astype(np.float32)

    near, far = map(
        positions, (np.mean(NEAR_SQUARES), length + MARGIN_DISTANCE_SQUARES)
    )
    upper = np.array(image.shape[::-1]) - 1
    inside = np.all((far >= 0) & (far <= upper), axis=(1, 2))
    if inside.mean() < MIN_MARGIN_INSIDE_FRACTION:
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
    """Lengths (n,) in squares of the edges outward of a side's corners."""
    patches, _, _ = patches_of(grid.points)
    along = np.linspace(0, LENGTH_REACH_SQUARES, N_LENGTH_SAMPLES)
    step = steps_outward(image, patches.of(on_side), outward, along)
    near = (along > NEAR_SQUARES[0]) & (along < NEAR_SQUARES[1])
    usual = np.median(step[:, near], axis=1, keepdims=True)
    share = np.divide(step, usual, out=np.ones_like(step), where=usual != 0)
    ended = (share < EDGE_END_RATIO) & (along > NEAR_SQUARES[0])
    return np.where(
        ended.any(axis=1), along[ended.argmax(axis=1)], LENGTH_REACH_SQUARES
    )
