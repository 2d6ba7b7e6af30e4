"""Chessboard points seen by pixels: homographic interpolation between corners.

A general camera needs a point for every pixel, but corners are few. Inside one cell of
the detected lattice the image is nearly a homography of the board, given by the four
corners (step 2 of the thesis's Algorithm 1 for chessboards, section 3.2). Cells are
quadrilaterals of any shape, because a lens bends the lattice. For cells with a large
bend, `raxel.calibration.views.interpolation` gives a view with smaller cells.

A view of an active grid (phase-shift structured light) has a point for every pixel.
This is a `raxel.calibration.views.dense.DenseView`, with the same interface as a
BoardView.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import cv2
import numba
import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.errors import InputError
from raxel.geometry.planes import on_plane
from raxel.sets.model import check_sd

# Second moments of the points that a pixel sees, summed over millions of pairs. Nine
# sums over a pixel's points (x, y, z) about the camera's centre: of xx, yy, zz, xy, xz,
# yz, x, y and z. Inside a cell of a board the points are a homography of the pixel, so
# about the centre they are three linear forms in (u, v, 1) over a fourth. Along a row
# only one number changes.


@numba.njit(cache=True)
def add_runs(sums, rows, first, stop, cell, forms, weight):
    """Add the points of runs of pixels, times weight, to sums (H, W, 9); forms (cells,
    4, 3): three numerators and their common denominator."""
    rest = np.empty(4)
    for run in range(len(rows)):
        v = rows[run]
        form = forms[cell[run]]
        for k in range(4):
            rest[k] = form[k, 2] + form[k, 1] * v
        for u in range(first[run], stop[run]):
            w = form[3, 0] * u + rest[3]
            x = (form[0, 0] * u + rest[0]) / w
            y = (form[1, 0] * u + rest[1]) / w
            z = (form[2, 0] * u + rest[2]) / w
            _add(sums[v, u], x, y, z, weight)


@numba.njit(cache=True)
def add_points(sums, location, sigma, plane, weight):
    """Add the points of a dense view, times weight/sigma^2, to sums (H, W, 9).

    location, sigma: (H, W, 2), NaN where not decoded; plane: (3, 3), from (x, y, 1) of
    the grid to the base frame about the centre.
    """
    height, width, _ = location.shape
    for v in range(height):
        for u in range(width):
            a, b = float(location[v, u, 0]), float(location[v, u, 1])
            if not (np.isfinite(a) and np.isfinite(b)):
                continue
            x = plane[0, 0] * a + plane[0, 1] * b + plane[0, 2]
            y = plane[1, 0] * a + plane[1, 1] * b + plane[1, 2]
            z = plane[2, 0] * a + plane[2, 1] * b + plane[2, 2]
            variance = sigma[v, u, 0] ** 2 + sigma[v, u, 1] ** 2
            _add(sums[v, u], x, y, z, weight / variance)


@numba.njit(cache=True)
def _add(of_pixel, x, y, z, weight):
    of_pixel[0] += weight * (x * x)
    of_pixel[1] += weight * (y * y)
    of_pixel[2] += weight * (z * z)
    of_pixel[3] += weight * (x * y)
    of_pixel[4] += weight * (x * z)
    of_pixel[5] += weight * (y * z)
    of_pixel[6] += weight * x
    of_pixel[7] += weight * y
    of_pixel[8] += weight * z


# Images with the same view of the board, such as frames of a video. They share the
# effects of light, blur and pixel grid on the corners. So they contain hardly more
# information than one of them, and their common error resembles a board error or that
# of another camera. Fits that use all of them count them together in covariances and
# tests, as corners of one image.


# Over the board's radius in the image, of a stationary camera.
DUPLICATE_DISTANCE = 0.01


def near_copies(views: Sequence[Any]) -> NDArray[np.int_]:
    """Return for each view the first that shows the board in the same position.

    A view is its own first where no other does, or where every pixel was read
    independently.

    Parameters
    ----------
    views : sequence of BoardView or DenseView
        The n views.

    Returns
    -------
    ndarray of int, shape (n,)
        Indices of views.
    """
    first, retained = np.arange(len(views)), []  # type: ignore[var-annotated]
    for k, view in enumerate(views):
        if view.every_pixel:
            continue
        radius = np.sqrt(np.nanmean(np.nanvar(view.pixels, axis=0)))
        near = [
            j
            for j in retained
            if _corner_distance(views[j], view) <= DUPLICATE_DISTANCE * radius
        ]
        if near:
            first[k] = near[0]
        else:
            retained.append(k)
    return first


def _corner_distance(one, other):
    """RMS distance in px along an axis of common corners; infinite for different boards
    or fewer than half in common."""
    if one.pixels.shape != other.pixels.shape:
        return np.inf
    squares = (one.pixels - other.pixels) ** 2
    both = np.isfinite(squares[:, 0])
    most = max(np.isfinite(each.pixels[:, 0]).sum() for each in (one, other))
    return np.sqrt(squares[both].mean()) if both.sum() > most / 2 else np.inf


def once_each(pairs: Sequence[tuple[Any, Any]]) -> list[tuple[Any, Any]]:
    """Return the (ImageScore, BoardView) pairs without near copies of others."""
    first = near_copies([view for _, view in pairs])
    return [pair for k, pair in enumerate(pairs) if first[k] == k]


# Shape of a board that is not quite flat, or stretched along one axis. All images show
# one board, so they share one shape. To first order the deviation of a sheet from its
# plane is a quadratic: two bends and a twist. Paper on a bent support bends without
# stretch, so a rise shortens the distance to the middle. With r a point from the
# board's middle and H the curvatures, z = r . H r / 2 and shift in the plane = -z H r /
# 3, which for a cylinder keeps lengths along the sheet to the third order. A printer or
# monitor may also stretch a board along x against y. A common scale error of both axes
# is not observable.


BENDS = ("bend_x", "bend_y", "twist")
TERMS = (*BENDS, "stretch")


class BoardShape(NamedTuple):
    """Describe the shape of a board that is not quite flat, or stretched.

    Attributes
    ----------
    middle : ndarray, shape (2,)
        Middle of the board, in its unit.
    half : ndarray, shape (2,)
        Half of its sides, in its unit.
    values : ndarray, shape (4,)
        bend_x, bend_y: how far the ends of x and of y lie behind the middle, along z.
        twist: how much farther behind the corner at the ends of x and y is. These three
        are in the unit of the board. stretch: how much longer x is than y, 0.01 being 1
        %.
    corners : ndarray, shape (K, 2), or None
        Nominal positions of the corners that are displaced.
    offsets : ndarray, shape (K, 3)
        Displacements of these corners, in addition to the shape.
    """

    middle: np.ndarray
    half: np.ndarray
    values: np.ndarray
    corners: np.ndarray | None = None
    offsets: np.ndarray = np.zeros((0, 3))

    def points(self, flat: ArrayLike) -> NDArray[np.float64]:
        """Return the true points (..., 3) of the board for nominal ones (..., 2)."""
        placed = shaped(flat, self)[0]
        if self.corners is None:
            return placed
        away = np.asarray(flat, float)[..., None, :] - self.corners
        return placed + self.offsets[np.argmin(np.sum(away**2, axis=-1), axis=-1)]

    def seen_on_plane(
        self, flat: ArrayLike, directions: np.ndarray
    ) -> NDArray[np.float64]:
        """Return where rays that see points of the board meet the plane z = 0.

        Parameters
        ----------
        flat : array_like, shape (N, 2)
            Points on the board, as stated.
        directions : ndarray, shape (N, 3)
            Directions of the rays, in the frame of the board.

        Returns
        -------
        ndarray, shape (N, 2)
            Points on the plane.
        """
        placed = self.points(flat)
        return placed[:, :2] - placed[:, 2:] * directions[:, :2] / directions[:, 2:]


def board_points(flat: ArrayLike, shape: BoardShape | None) -> NDArray[np.float64]:
    """Return points (..., 3) of nominal ones (..., 2); on a plane for None."""
    return on_plane(flat) if shape is None else shape.points(flat)


def displaced(shape, corners, offsets):
    """The BoardShape with displaced corners; shape: None for a flat board."""
    if shape is None:
        shape = BoardShape(
            corners.mean(axis=0), np.ptp(corners, axis=0) / 2, np.zeros(4)
        )
    return shape._replace(corners=corners, offsets=offsets)


def shaped(flat, shape):
    """Points (..., 3) of a BoardShape for nominal ones (..., 2), and their derivatives
    by its values, (..., 3, 4)."""
    flat = np.asarray(flat, float)
    size = flat.shape[:-1]
    points, by_values = _shaped(
        flat.reshape(-1, 2), shape.middle, shape.half, tuple(shape.values)
    )
    return points.reshape(*size, 3), by_values.reshape(*size, 3, 4)


@numba.njit(cache=True)
def _shaped(flat, middle, half, values):
    bend_x, bend_y, twist, stretch = values
    points, by_values = np.empty((len(flat), 3)), np.zeros((len(flat), 3, 4))
    for n in range(len(flat)):
        r = flat[n, 0] - middle[0], flat[n, 1] - middle[1]
        x, y = r[0] / half[0], r[1] / half[1]
        z = points[n, 2] = bend_x * x**2 + bend_y * y**2 + twist * x * y
        z_by = x**2, y**2, x * y
        # Parts of H r: 2 / a^2, 1 / (a b) and 2 / b^2 of the bends and the twist.
        slope_by = (
            (2 * x / half[0], 0.0, y / half[0]),
            (0.0, 2 * y / half[1], x / half[1]),
        )
        for c in range(2):
            own, sign = slope_by[c], 1 - 2 * c
            slope = own[0] * bend_x + own[1] * bend_y + own[2] * twist
            points[n, c] = flat[n, c] + sign * r[c] * stretch / 2 - z * slope / 3
            by_values[n, c, 3] = sign * r[c] / 2
            for j in range(3):
                by_values[n, c, j] = -(z_by[j] * slope + z * own[j]) / 3
                by_values[n, 2, j] = z_by[j]
    return points, by_values


BLOCK = 1 << 15  # pixels handled at once
PENDING_BLOCK = 1 << 10  # pixels tested against every cell at once
EDGE_TOL_PX = 1e-9  # a pixel this close to an edge counts as inside
NEAREST_FIRST = sorted(
    ((u, v) for u in (-1, 0, 1) for v in (-1, 0, 1)),
    key=lambda s: s[0] ** 2 + s[1] ** 2,
)


class BoardView(NamedTuple):
    """Hold one image of a chessboard: corners in the image and on the board.

    In the image, x should turn clockwise into y. N = columns * rows.

    Attributes
    ----------
    pixels : ndarray, shape (N, 2)
        Corners (u, v), px, row by row; NaN for a corner that was not found.
    points : ndarray, shape (N, 2)
        Corners on the board, in mm or units of the pitch.
    columns, rows : int
        Number of interior corners along each direction.
    name : str
        Name for messages.
    sd : ndarray, shape (N,), or None
        Standard deviation of each corner along each axis, px, by the rule of
        `raxel.sets.model`; None where unknown. No calibration weights by it yet.

    Examples
    --------
    >>> from raxel.calibration import BoardView
    >>> from raxel.sets import Chessboard
    >>> points = Chessboard(3, 3, 20.0).points()
    >>> view = BoardView(pixels=2 * points + 100, points=points, columns=3, rows=3)
    >>> located, inside = view.locate([[110.0, 130.0], [0.0, 0.0]])
    >>> located[0].round(6).tolist(), inside.tolist()
    ([5.0, 15.0], [True, False])
    """

    pixels: np.ndarray
    points: np.ndarray
    columns: int
    rows: int
    name: str = ""
    sd: np.ndarray | None = None

    # Whether every pixel was decoded; if not, pixels are interpolated between corners.
    every_pixel = False  # type: ignore[misc]

    def locate(self, pixels: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Return the points of the target that pixels look at.

        Parameters
        ----------
        pixels : array_like, shape (M, 2)
            Pixels (u, v) at any sub-pixel position.

        Returns
        -------
        points : ndarray, shape (M, 2)
            Points on the target; NaN where the view does not reach.
        inside : ndarray of bool, shape (M,)
            Whether the view reaches the pixel.
        """
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

    def whole_pixels(
        self, width: int, height: int, step: int = 1
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the whole pixels that look at the target, and their points.

        Parameters
        ----------
        width, height : int
            Size of the image, px.
        step : int
            Only multiples of it count, px.

        Returns
        -------
        pixels : ndarray of int, shape (M, 2)
            Pixels (u, v), row by row.
        points : ndarray, shape (M, 2)
            Points on the target.
        """
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

    def area(self) -> float:
        """Return its area, px^2, by the shoelace formula over its cells."""
        corners = cell_corners(self)
        ahead = np.roll(corners, -1, axis=1)
        turn = corners[..., 0] * ahead[..., 1] - corners[..., 1] * ahead[..., 0]
        return np.sum(np.abs(np.sum(turn, axis=1))) / 2

    def covered(self, width: int, height: int) -> NDArray[np.uint8]:
        """Return (height, width) uint8: 1 in cells whose four corners were found."""
        covered = np.zeros((height, width), np.uint8)
        for corners in board_cells(self).corners:
            cv2.fillConvexPoly(covered, np.rint(corners).astype(np.int32), 1)
        return covered

    def add_moments(
        self,
        sums: np.ndarray,
        T_base_grid: np.ndarray,
        centre: np.ndarray,
        weight: float = 1.0,
    ) -> None:
        """Add the moments of the point of every pixel about the centre, times weight.

        Parameters
        ----------
        sums : ndarray, shape (height, width, 9)
            Sums to which the moments are added, as `correspondence` lays them out.
        T_base_grid : ndarray, shape (4, 4)
            Pose of the board.
        centre : ndarray, shape (3,)
            Centre, base frame.
        weight : float
            Weight of the view.
        """
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
    """Usable cells of a lattice: (K, 4, 2) corners in px in cyclic order, (K, 4, 3)
    edges as lines, not negative inside, and (K, 3, 3) pixel to board."""

    corners: np.ndarray
    edges: np.ndarray
    board_from_pixel: np.ndarray


def check_view(view: Any) -> Any:
    """Return the view with float arrays, `sd` among them: NaN where unknown.

    Parameters
    ----------
    view : BoardView or DenseView
        The view.

    Returns
    -------
    BoardView or DenseView
        The view.

    Raises
    ------
    InputError
        If counts do not fit or numbers are not valid.
    """
    pixels, points = np.asarray(view.pixels, float), np.asarray(view.points, float)
    count = view.columns * view.rows
    if pixels.shape != (count, 2) or points.shape != (count, 2):
        raise InputError(
            f"{view.name or 'board'}: corners: found {pixels.shape} pixels and "
            f"{points.shape} points; give ({count}, 2) each for {view.columns} x "
            f"{view.rows} corners"
        )
    bad = np.isinf(pixels).any(axis=1) | (np.isnan(pixels).sum(axis=1) == 1)
    if bad.any() or not np.isfinite(points).all():
        raise InputError(
            f"{view.name or 'board'}: corners: values must be finite; give NaN in both "
            "u and v for a missing corner"
        )
    sd = check_sd(view.name or "board", view.sd, count)
    return view._replace(pixels=pixels, points=points, sd=sd)


def board_cells(view):
    """CellTable of the convex cells with four detected corners."""
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
    """(rows - 1, columns - 1) int: orientation in the image of convex cells with four
    detected corners, 1 if x turns clockwise into y, else -1; 0 for other cells."""
    turn = _rings(view)[2]
    sense = np.where(_convex(turn), np.sign(turn[:, 0]), 0)
    return sense.astype(int).reshape(view.rows - 1, view.columns - 1)


def cell_corners(view):
    """(K, 4, 2) px: corners of the convex cells with four detected corners."""
    ring, _, turn = _rings(view)
    return view.pixels[ring[_convex(turn)]]


def _rings(view):
    """Corners of all cells in cyclic order: indices (K, 4), steps to the next (K, 4, 2)
    px, and the turn from each step to the next one (K, 4)."""
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


def cell_maps(corners: np.ndarray, points: np.ndarray) -> NDArray[np.float64]:
    """Return exact homographies from pixels to the board, each through four corners.

    About the middle of a convex cell the last entry of the homography cannot vanish, so
    it may be set to 1: eight equations for eight numbers.

    Parameters
    ----------
    corners : ndarray, shape (K, 4, 2)
        Corners of the cells, px, in any order.
    points : ndarray, shape (K, 4, 2)
        The same corners on the board.

    Returns
    -------
    ndarray, shape (K, 3, 3)
        Homographies.

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.calibration import cell_maps
    >>> square = np.array([[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]])
    >>> H = cell_maps(10 * square, square)[0]
    >>> (H @ [5.0, 5.0, 1.0]).round(6).tolist()
    [0.5, 0.5, 1.0]
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


def locate_pixels(pixels: ArrayLike, view: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return the points of the target that pixels look at.

    On a board the homography is that of the enclosing cell of corners.

    Parameters
    ----------
    pixels : array_like, shape (M, 2)
        Pixels (u, v) at any sub-pixel position.
    view : BoardView or DenseView
        The view.

    Returns
    -------
    points : ndarray, shape (M, 2)
        Points on the target; NaN where the view does not reach.
    inside : ndarray of bool, shape (M,)
        Whether the view reaches the pixel.

    Raises
    ------
    InputError
        As `check_view`.

    References
    ----------
    Thesis 3.2, Algorithm 1, step 2.
    """
    return view.locate(pixels)


def pixels_on_board(
    view: Any, width: int, height: int, step: int = 1
) -> tuple[np.ndarray, np.ndarray]:
    """Return all whole pixels of an image that look at the target, and their points.

    Where cells overlap, a pixel belongs to the leftmost.

    Parameters
    ----------
    view : BoardView or DenseView
        The view.
    width, height : int
        Size of the image, px.
    step : int
        Only multiples of it count, px.

    Returns
    -------
    pixels : ndarray of int, shape (M, 2)
        Pixels (u, v), row by row.
    points : ndarray, shape (M, 2)
        Points on the target, as `locate_pixels` finds them.
    """
    return view.whole_pixels(width, height, step)


class PixelRuns(NamedTuple):
    """Runs of adjacent pixels of a row in one cell, row by row.

    v: (R,) rows; first, stop: (R,) columns, `stop` excluded; cell: (R,) its index. All
    int. No pixel is in two runs.
    """

    v: np.ndarray
    first: np.ndarray
    stop: np.ndarray
    cell: np.ndarray


def pixel_runs(cells, width, height, step=1):
    """PixelRuns of a CellTable: the pixels of an image that are multiples of step.

    A row crosses a convex cell in one interval, which ends at its edges.
    """
    low = np.ceil((cells.corners[..., 1].min(axis=1) - EDGE_TOL_PX) / step)
    high = np.floor((cells.corners[..., 1].max(axis=1) + EDGE_TOL_PX) / step)
    low = np.clip(low, 0, height).astype(int)
    count = np.clip(high, -1, (height - 1) // step).astype(int) - low + 1
    count = np.maximum(count, 0)
    cell = np.repeat(np.arange(len(count)), count)
    row = np.arange(len(cell)) + np.repeat(low - np.cumsum(count) + count, count)
    a, b, c = np.moveaxis(cells.edges[cell], 2, 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = -(b * (step * row)[:, None] + c + EDGE_TOL_PX) / a
    # An edge along the row (0 / 0 at worst) is no bound in the rows of its cell.
    left = np.nanmax(np.where(a > 0, ends, -np.inf), axis=1, initial=-1)
    right = np.nanmin(np.where(a < 0, ends, np.inf), axis=1, initial=width)
    first = step * np.ceil(np.clip(left, 0, width) / step).astype(int)
    stop = step * (np.floor(np.clip(right, -1, width - 1) / step).astype(int) + 1)
    order = np.lexsort([first, row])
    v, first, stop, cell = step * row[order], first[order], stop[order], cell[order]
    # Flat indices, to cut off pixels of earlier runs at once.
    base = v * (width + step)
    taken = np.maximum.accumulate(base + stop)
    first = np.maximum(first, np.concatenate([[0], taken[:-1]])[: len(v)] - base)
    some = first < stop
    return PixelRuns(v[some], first[some], stop[some], cell[some])


def _label_image(cells):
    """Cell indices per whole pixel (h, w), -1 elsewhere, exact to a pixel; the pixel of
    element [0, 0]; and a mask of pixels within one pixel of a cell.

    The border of the image is free, so neighbours of labelled pixels exist.
    """
    low = np.floor(cells.corners.min(axis=(0, 1))).astype(int) - 3
    high = np.ceil(cells.corners.max(axis=(0, 1))).astype(int) + 3
    labels = np.full((high - low + 1)[::-1], -1, np.int32)
    for number, corners in enumerate(np.rint(cells.corners - low).astype(np.int32)):
        cv2.fillConvexPoly(labels, corners, number)
    near = cv2.dilate((labels >= 0).astype(np.uint8), np.ones((3, 3), np.uint8))
    return labels, low, near.astype(bool)


def _enclosing_cells(pixels, cells, labels, origin, near):
    """Index of the cell that contains each pixel, -1 for none."""
    size = np.array(labels.shape[::-1])
    whole = np.rint(np.nan_to_num(pixels, nan=-1e6)).astype(int) - origin
    framed = np.all((whole >= 0) & (whole < size), axis=1)
    whole[~framed] = 0
    found = np.full(len(pixels), -1)
    pending = np.flatnonzero(framed & near[whole[:, 1], whole[:, 0]])
    # The label is correct except at borders of cells, where a neighbour's is.
    for shift in NEAREST_FIRST:
        u, v = (whole[pending] + shift).T
        label = labels[v, u]
        edges = cells.edges[label]
        gap = np.einsum("mek,mk->me", edges[..., :2], pixels[pending]) + edges[..., 2]
        holds = (label >= 0) & np.all(gap >= -EDGE_TOL_PX, axis=1)
        found[pending[holds]] = label[holds]
        pending = pending[~holds]
        if len(pending) == 0:
            return found
    # At a sharp corner neighbours may have overwritten a whole cell.
    for start in range(0, len(pending), PENDING_BLOCK):
        few = pending[start : start + PENDING_BLOCK]
        gap = cells.edges[..., :2] @ pixels[few].T + cells.edges[..., 2:]
        holds = np.all(gap >= -EDGE_TOL_PX, axis=1)
        found[few] = np.where(holds.any(axis=0), holds.argmax(axis=0), -1)
    return found


def _map(homographies, points):
    mapped = np.einsum("mij,mj->mi", homographies[..., :2], points)
    mapped += homographies[..., 2]
    return mapped[:, :2] / mapped[:, 2:]
