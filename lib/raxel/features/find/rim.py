"""Whether a board's pattern goes on where its outermost squares should end.

From each outer corner an edge runs outward between two squares. At the end of the board
the step across it dies away. Where another row of squares follows, however narrow, the
step turns round at once: dark and bright change sides.
"""

import numpy as np

from raxel.features.find.patches import patches_of, predicted
from raxel.features.find.ring import remapped

# How far along the edge, in squares, and how far from it the step is taken.
ALONG, ACROSS = 1.2, (0.1, 0.2)
# Where along it the step is surely that of the outermost squares.
NEAR = (0.1, 0.3)
# The step has ended below this share of itself, and has turned below its negative.
ENDED = 0.3
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
    near = (along > NEAR[0]) & (along < NEAR[1])
    usual = np.median(step[:, near], axis=1, keepdims=True)
    share = np.divide(step, usual, out=np.ones_like(step), where=usual != 0)
    ended = (share < ENDED) & (along > NEAR[0])
    first = np.where(ended.any(axis=1), ended.argmax(axis=1), count)
    px = (along[1] * length)[:, None]
    after = (np.arange(count) - first[:, None]) * px
    at_once = (after >= 0) & (after <= AT_ONCE_PX)
    return np.where(at_once, share, 1.0).min(axis=1) < -ENDED


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
