"""Where on a chessboard does a pixel look? Homographic interpolation between corners.

Corners are few and a general camera wants a point for every pixel. Inside one cell of
the detected lattice the image is nearly a homography of the board, fixed by the four
corners (step 2 of the thesis's Algorithm 1 for chessboards, section 3.2). Cells are
quadrilaterals of any shape, as a lens bends the lattice. Where they are bent too much
for that, `raxel.calibration.views.interpolation` gives a view with smaller ones.

A view of an active grid knows the point of every pixel. It is a
`raxel.calibration.views.dense.DenseView`, which answers the same questions as a
BoardView; whatever takes views takes either.
"""

from typing import NamedTuple

import numpy as np

from raxel.calibration.views.moments import add_runs
from raxel.errors import InputError
from raxel.sets.uncertainty import check_sd

BLOCK = 1 << 15  # pixels handled at once
FEW = 1 << 10  # of them tested against every cell at once
TOUCH = 1e-9  # px: a pixel this close to an edge counts as inside
NEAREST_FIRST = sorted(
    ((u, v) for u in (-1, 0, 1) for v in (-1, 0, 1)),
    key=lambda s: s[0] ** 2 + s[1] ** 2,
)


class BoardView(NamedTuple):
    """One picture of a chessboard: corners in the image and on the board.

    pixels: (N, 2) (u, v), row by row, NaN for a corner that was not found; points:
    (N, 2) on the board, in mm or units of the pitch; N = columns * rows; name: for
    messages; sd: (N,) px, standard deviation of each corner along each axis, by the
    rule of `raxel.sets.uncertainty`, None where nobody states any. No calibration
    weights by it yet. Seen in the image, x should turn clockwise into y.
    """

    pixels: np.ndarray
    points: np.ndarray
    columns: int
    rows: int
    name: str = ""
    sd: np.ndarray | None = None

    # Whether every pixel was read by itself; if not, it is located between corners.
    every_pixel = False

    def locate(self, pixels):
        """Points (M, 2) that pixels (M, 2) look at, and inside (M,) bool, as
        `locate_pixels` says."""
        pixels = np.asarray(pixels, float)
        cells = board_cells(self)
        points = np.full(pixels.shape, np.nan)
        inside = np.zeros(len(pixels), bool)
        if len(cells.corners) == 0:
            return points, inside
        raster = _label_image(cells)
        for start in range(0, len(pixels), BLOCK):
            block = slice(start, start + BLOCK)
            cell = _enclosing_cells(pixels[block], cells, *raster)
            inside[block] = cell >= 0
            points[block][cell >= 0] = _map(
                cells.board_from_pixel[cell[cell >= 0]], pixels[block][cell >= 0]
            )
        return points, inside

    def whole_pixels(self, width, height, step=1):
        """Pixels (M, 2) int and their points (M, 2), as `pixels_on_board` says."""
        cells = board_cells(self)
        runs = pixel_runs(cells, width, height, step)
        count = (runs.stop - runs.first) // step
        skipped = np.cumsum(count) - count
        u = np.repeat(runs.first - step * skipped, count) + step * np.arange(sum(count))
        pixels = np.column_stack([u, np.repeat(runs.v, count)])
        cell = np.repeat(runs.cell, count)
        points = np.empty(pixels.shape)
        for start in range(0, len(pixels), BLOCK):
            block = slice(start, start + BLOCK)
            points[block] = _map(cells.board_from_pixel[cell[block]], pixels[block])
        return pixels, points

    def area(self):
        """Its area in the image, px^2, by the shoelace formula over its cells."""
        corners = cell_corners(self)
        ahead = np.roll(corners, -1, axis=1)
        turn = corners[..., 0] * ahead[..., 1] - corners[..., 1] * ahead[..., 0]
        return np.sum(np.abs(np.sum(turn, axis=1))) / 2

    def covered(self, width, height):
        """(height, width) uint8: 1 in the cells whose four corners were found."""
        import cv2

        covered = np.zeros((height, width), np.uint8)
        for corners in board_cells(self).corners:
            cv2.fillConvexPoly(covered, np.rint(corners).astype(np.int32), 1)
        return covered

    def add_moments(self, sums, T_base_grid, centre, weight=1.0):
        """Add to sums (height, width, 9) those of every pixel's point about the centre,
        times weight, as `raxel.calibration.views.moments` lays them out."""
        height, width, _ = sums.shape
        cells = board_cells(self)
        if len(cells.corners) == 0:
            return
        runs = pixel_runs(cells, width, height)
        plane = T_base_grid[:3, [0, 1, 3]] - np.outer(centre, [0.0, 0.0, 1.0])
        forms = np.concatenate(
            [plane @ cells.board_from_pixel, cells.board_from_pixel[:, 2:]], axis=1
        )
        add_runs(sums, runs.v, runs.first, runs.stop, runs.cell, forms, weight)


class CellTable(NamedTuple):
    """The usable cells of a lattice: (K, 4, 2) corners in px in order of going round,
    (K, 4, 3) edges as lines, not negative inside, and (K, 3, 3) pixel to board."""

    corners: np.ndarray
    edges: np.ndarray
    board_from_pixel: np.ndarray


def check_view(view):
    """The view with float arrays, sd among them: NaN where nobody states it.

    Raises InputError for counts that do not fit and numbers that cannot be.
    """
    pixels, points = np.asarray(view.pixels, float), np.asarray(view.points, float)
    count = view.columns * view.rows
    if pixels.shape != (count, 2) or points.shape != (count, 2):
        raise InputError(
            f"{view.name or 'board'}: corners: found {pixels.shape} pixels and"
            f" {points.shape} points; {view.columns} x {view.rows} corners need"
            f" ({count}, 2) each"
        )
    bad = np.isinf(pixels).any(axis=1) | (np.isnan(pixels).sum(axis=1) == 1)
    if bad.any() or not np.isfinite(points).all():
        raise InputError(
            f"{view.name or 'board'}: corners: found numbers that are not finite; a"
            " corner that was not found is NaN in u and in v"
        )
    sd = check_sd(view.name or "board", view.sd, count)
    return view._replace(pixels=pixels, points=points, sd=sd)


def board_cells(view):
    """CellTable of the convex cells with four found corners."""
    view = check_view(view)
    ring, ahead, turn = _rings(view)
    convex = _convex(turn)
    corners, points = view.pixels[ring[convex]], view.points[ring[convex]]
    ahead = ahead[convex]
    sign = np.sign(turn[convex, :1])
    length = np.linalg.norm(ahead, axis=2)
    normal = np.stack([-ahead[..., 1], ahead[..., 0]], axis=2)
    normal = normal * (sign / length)[..., None]
    offset = -np.sum(normal * corners, axis=2, keepdims=True)
    edges = np.concatenate([normal, offset], axis=2)
    return CellTable(corners, edges, cell_maps(corners, points))


def cell_turns(view):
    """(rows - 1, columns - 1) int: the sense in which convex cells with four found
    corners are gone round in the image, 1 if x turns clockwise into y, else -1; 0 for
    other cells."""
    turn = _rings(view)[2]
    sense = np.where(_convex(turn), np.sign(turn[:, 0]), 0)
    return sense.astype(int).reshape(view.rows - 1, view.columns - 1)


def cell_corners(view):
    """(K, 4, 2) px: corners of the convex cells with four found corners."""
    ring, _, turn = _rings(view)
    return view.pixels[ring[_convex(turn)]]


def _rings(view):
    """Corners of all cells in order of going round: numbers (K, 4), steps to the next
    (K, 4, 2) px, and the turn from each step to the one after it (K, 4)."""
    grid = np.arange(view.columns * view.rows).reshape(view.rows, view.columns)
    ring = np.stack(
        [grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]], axis=-1
    ).reshape(-1, 4)
    corners = view.pixels[ring]
    ahead = np.roll(corners, -1, axis=1) - corners
    after = np.roll(ahead, -1, axis=1)
    return ring, ahead, ahead[..., 0] * after[..., 1] - ahead[..., 1] * after[..., 0]


def _convex(turn):
    return np.all(turn > 0, axis=1) | np.all(turn < 0, axis=1)


def cell_maps(corners, points):
    """Exact homographies (K, 3, 3) pixel to board, each through four corners.

    corners, points: (K, 4, 2), in any order. About the middle of a convex cell the last
    entry of the homography cannot vanish, so it may be set to 1: eight equations for
    eight numbers.
    """
    middle = corners.mean(axis=1, keepdims=True)
    size = np.max(np.abs(corners - middle), axis=(1, 2))
    x, y = np.moveaxis((corners - middle) / size[:, None, None], 2, 0)
    one, zero = np.ones_like(x), np.zeros_like(x)
    a, b = np.moveaxis(points, 2, 0)
    rows = [
        np.stack([x, y, one, zero, zero, zero, -a * x, -a * y], axis=2),
        np.stack([zero, zero, zero, x, y, one, -b * x, -b * y], axis=2),
    ]
    system = np.concatenate(rows, axis=1)
    values = np.concatenate([a, b], axis=1)[..., None]
    h = np.linalg.solve(system, values)[..., 0]
    maps = np.concatenate([h, np.ones((len(h), 1))], axis=1).reshape(-1, 3, 3)
    # From pixels to the normalised frame of each cell.
    scaling = np.zeros((len(h), 3, 3))
    scaling[:, [0, 1], [0, 1]] = 1 / size[:, None]
    scaling[:, :2, 2] = -middle[:, 0] / size[:, None]
    scaling[:, 2, 2] = 1.0
    return maps @ scaling


def locate_pixels(pixels, view):
    """Points of the target that pixels look at.

    pixels: (M, 2) (u, v), any sub-pixel positions; view: BoardView or DenseView.
    Returns points (M, 2), NaN where the view does not reach, and inside (M,) bool. On a
    board the homography is that of the enclosing cell of corners. Raises InputError as
    `check_view`.
    """
    return view.locate(pixels)


def pixels_on_board(view, width, height, step=1):
    """All whole pixels (multiples of step) of an image that look at the target.

    view: BoardView or DenseView. Returns pixels (M, 2) int, row by row, and points
    (M, 2), as `locate_pixels` finds them; where cells overlap, a pixel is of the
    leftmost.
    """
    return view.whole_pixels(width, height, step)


class PixelRuns(NamedTuple):
    """Pixels beside each other in a row that lie in one cell, row by row.

    v: (R,) rows; first, stop: (R,) columns, `stop` is not in the run; cell: (R,) its
    number. All int. No pixel is in two runs.
    """

    v: np.ndarray
    first: np.ndarray
    stop: np.ndarray
    cell: np.ndarray


def pixel_runs(cells, width, height, step=1):
    """PixelRuns of a CellTable: the pixels of an image that are multiples of step.

    A row crosses a convex cell in one interval, whose ends are where it meets edges.
    """
    low = np.ceil((cells.corners[..., 1].min(axis=1) - TOUCH) / step)
    high = np.floor((cells.corners[..., 1].max(axis=1) + TOUCH) / step)
    low = np.clip(low, 0, height).astype(int)
    count = np.clip(high, -1, (height - 1) // step).astype(int) - low + 1
    count = np.maximum(count, 0)
    cell = np.repeat(np.arange(len(count)), count)
    row = np.arange(len(cell)) + np.repeat(low - np.cumsum(count) + count, count)
    a, b, c = np.moveaxis(cells.edges[cell], 2, 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = -(b * (step * row)[:, None] + c + TOUCH) / a
    # An edge along the row (0 / 0 at worst) bounds nothing in the rows of its cell.
    left = np.nanmax(np.where(a > 0, ends, -np.inf), axis=1, initial=-1)
    right = np.nanmin(np.where(a < 0, ends, np.inf), axis=1, initial=width)
    first = step * np.ceil(np.clip(left, 0, width) / step).astype(int)
    stop = step * (np.floor(np.clip(right, -1, width - 1) / step).astype(int) + 1)
    order = np.lexsort([first, row])
    v, first, stop, cell = step * row[order], first[order], stop[order], cell[order]
    # Flat places, in which what an earlier run has taken can be cut off at once.
    base = v * (width + step)
    taken = np.maximum.accumulate(base + stop)
    first = np.maximum(first, np.concatenate([[0], taken[:-1]])[: len(v)] - base)
    some = first < stop
    return PixelRuns(v[some], first[some], stop[some], cell[some])


def _label_image(cells):
    """Cell numbers per whole pixel (h, w), -1 elsewhere, right to a pixel; the pixel of
    element [0, 0]; and a mask of what is no further than a pixel from any cell.

    The border of the image is free, so neighbours of labelled pixels exist.
    """
    import cv2

    low = np.floor(cells.corners.min(axis=(0, 1))).astype(int) - 3
    high = np.ceil(cells.corners.max(axis=(0, 1))).astype(int) + 3
    labels = np.full((high - low + 1)[::-1], -1, np.int32)
    for number, corners in enumerate(np.rint(cells.corners - low).astype(np.int32)):
        cv2.fillConvexPoly(labels, corners, number)
    near = cv2.dilate((labels >= 0).astype(np.uint8), np.ones((3, 3), np.uint8))
    return labels, low, near.astype(bool)


def _enclosing_cells(pixels, cells, labels, origin, near):
    """Number of the cell that holds each pixel, -1 for none."""
    size = np.array(labels.shape[::-1])
    whole = np.rint(np.nan_to_num(pixels, nan=-1e6)).astype(int) - origin
    framed = np.all((whole >= 0) & (whole < size), axis=1)
    whole[~framed] = 0
    found = np.full(len(pixels), -1)
    pending = np.flatnonzero(framed & near[whole[:, 1], whole[:, 0]])
    # The label at hand is right but at borders of cells, where a neighbour's is.
    for shift in NEAREST_FIRST:
        u, v = (whole[pending] + shift).T
        label = labels[v, u]
        edges = cells.edges[label]
        gap = np.einsum("mek,mk->me", edges[..., :2], pixels[pending]) + edges[..., 2]
        holds = (label >= 0) & np.all(gap >= -TOUCH, axis=1)
        found[pending[holds]] = label[holds]
        pending = pending[~holds]
        if len(pending) == 0:
            return found
    # At a sharp corner its neighbours may have painted over a cell altogether.
    for start in range(0, len(pending), FEW):
        few = pending[start : start + FEW]
        gap = cells.edges[..., :2] @ pixels[few].T + cells.edges[..., 2:]
        holds = np.all(gap >= -TOUCH, axis=1)
        found[few] = np.where(holds.any(axis=0), holds.argmax(axis=0), -1)
    return found


def _map(homographies, points):
    mapped = np.einsum("mij,mj->mi", homographies[..., :2], points)
    mapped += homographies[..., 2]
    return mapped[:, :2] / mapped[:, 2:]
