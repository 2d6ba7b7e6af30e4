"""Ways to find the point of a grid that a pixel sees, from corners about it."""

import numpy as np

from raxel.calibration.views.correspondence import cell_maps, locate_pixels
from raxel.calibration.views.interpolation import interpolated_view

# The nearest corners of which four are taken.
CANDIDATES = 24
WINDOW = 4  # corners each way about a cell
STEPS = 3  # of Gauss and Newton


def places_of(view):
    """Column and row (N, 2) of each corner of a BoardView."""
    row, column = np.divmod(np.arange(len(view.pixels)), view.columns)
    return np.column_stack([column, row])


def nearest_four(pixels, corners, places):
    """The four nearest corners of each pixel, no three on one line of the grid.

    pixels: (M, 2); corners: (N, 2) px; places: (N, 2) int, column and row. Nearer
    corners come first, and one that stands in line with two others is passed over.
    Returns (M, 4) int, -1 where too few are left.
    """
    from scipy.spatial import cKDTree

    count = min(CANDIDATES, len(corners))
    candidates = cKDTree(corners).query(pixels, count)[1]
    taken = np.full((len(pixels), 4), -1)
    number = np.zeros(len(pixels), int)
    for candidate in candidates.T:
        good = number < 4
        for a, b in zip(*np.triu_indices(4, 1), strict=True):
            u = places[taken[:, a]] - places[candidate]
            v = places[taken[:, b]] - places[candidate]
            in_line = u[:, 0] * v[:, 1] == u[:, 1] * v[:, 0]
            good &= ~(in_line & (number > b))
        rows = np.flatnonzero(good)
        taken[rows, number[rows]] = candidate[rows]
        number[rows] += 1
    taken[number < 4] = -1
    return taken


def through_four(pixels, corners, points):
    """Points (M, 2) by the homography through four corners (M, 4, 2) of each pixel."""
    maps = cell_maps(corners, points)
    mapped = np.einsum("mij,mj->mi", maps[..., :2], pixels) + maps[..., 2]
    return mapped[:, :2] / mapped[:, 2:]


def by_nearest_four(pixels, view):
    """Step 2 of Algorithm 1 as 3.2.1 describes it."""
    four = nearest_four(pixels, view.pixels, places_of(view))
    return through_four(pixels, view.pixels[four], view.points[four])


def by_enclosing_cell(pixels, view):
    """The same with the corners of the square that the pixel is in."""
    return locate_pixels(pixels, view)[0]


def by_surface(pixels, view):
    """A surface through all corners (`raxel.calibration.views.interpolation`)."""
    return locate_pixels(pixels, interpolated_view(view, "smooth")[0])[0]


def by_need(pixels, view):
    """Whichever of cell and surface errs less, as far as the corners tell."""
    return locate_pixels(pixels, interpolated_view(view, "by need")[0])[0]


def by_straight_lines(pixels, view):
    """The enclosing cell, in a picture bent until lines of the grid are straight.

    Rows, columns and diagonals of the 4 x 4 corners about a cell are straight on the
    grid. A bend u + q1 u^2 + q2 v^2, v + q3 u^2 + q4 v^2 of the picture about the cell
    is found that makes them straight there; a homography leaves them so, and does the
    rest. Only that they are straight is used, not where on a line a corner stands.
    """
    rough = by_enclosing_cell(pixels, view)
    inside = np.flatnonzero(np.isfinite(rough[:, 0]))
    first, pitch = view.points[0], view.points[1, 0] - view.points[0, 0]
    most = np.array([view.columns, view.rows]) - 2
    cell = np.clip((rough[inside] - first) // pitch, 0, most).astype(int)
    number, of_pixel = np.unique(cell @ [1, view.columns], return_inverse=True)
    row, column = np.divmod(number, view.columns)
    corners, middle, size = _windows(view, row, column)
    bend = _straightening(corners)
    ring = number[:, None] + [0, 1, view.columns + 1, view.columns]
    four = _bent((view.pixels[ring] - middle) / size, bend)
    own = (pixels[inside, None] - middle[of_pixel]) / size[of_pixel]
    own = _bent(own, bend[of_pixel])[:, 0]
    found = np.full(pixels.shape, np.nan)
    found[inside] = through_four(own, four[of_pixel], view.points[ring][of_pixel])
    return found


FOUR = {"nearest four": by_nearest_four, "enclosing cell": by_enclosing_cell}
METHODS = FOUR | {"straight lines": by_straight_lines, "smooth": by_surface}


def _windows(view, row, column):
    """Corners (K, 16, 2) about cells, in units of their spread; middle; that unit."""
    top = np.clip(row - 1, 0, view.rows - WINDOW)
    left = np.clip(column - 1, 0, view.columns - WINDOW)
    down, along = np.divmod(np.arange(WINDOW**2), WINDOW)
    inside = (top[:, None] + down) * view.columns + left[:, None] + along
    corners = view.pixels[inside]
    middle = corners.mean(axis=1, keepdims=True)
    size = np.abs(corners - middle).max(axis=(1, 2), keepdims=True)
    return (corners - middle) / size, middle, size


def lines_of_three():
    """Neighbours (L, 3) of a window of 4 x 4 on a row, a column or a diagonal."""
    grid = np.arange(WINDOW**2).reshape(WINDOW, WINDOW)
    straight = [
        line[k : k + 3] for one in (grid, grid.T) for line in one for k in range(2)
    ]
    diagonal = [
        one[i : i + 3, j : j + 3].diagonal()
        for one in (grid, grid[:, ::-1])
        for i, j in np.ndindex(2, 2)
    ]
    return np.array(straight + diagonal)


def _bent(places, bend):
    """Places (K, n, 2) moved by bends (K, 4)."""
    return places + np.einsum("knij,kj->kni", _moves(places), bend)


def _moves(places):
    """What each number of a bend moves: (K, n, 2, 4)."""
    squares, zeros = places**2, np.zeros_like(places)
    return np.stack(
        [
            np.concatenate([squares, zeros], axis=-1),
            np.concatenate([zeros, squares], axis=-1),
        ],
        axis=-2,
    )


def _straightening(corners):
    """Bends (K, 4) after which the lines of windows (K, 16, 2) are straight.

    Least squares of twice the triangles' areas over their bases, which is how far the
    middle corner of a line is off it, doubled.
    """
    a, b, c = lines_of_three().T
    moves = _moves(corners)
    moves_b, moves_c = moves[:, b] - moves[:, a], moves[:, c] - moves[:, a]
    bend = np.zeros((len(corners), 4))
    for _ in range(STEPS):
        now = _bent(corners, bend)
        u, v = now[:, b] - now[:, a], now[:, c] - now[:, a]
        base = np.linalg.norm(v, axis=2)
        off = (u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]) / base
        slope = (
            moves_b[..., 0, :] * v[..., 1:]
            - moves_b[..., 1, :] * v[..., :1]
            + u[..., :1] * moves_c[..., 1, :]
            - u[..., 1:] * moves_c[..., 0, :]
        ) / base[..., None]
        bend -= (np.linalg.pinv(slope) @ off[..., None])[..., 0]
    return bend
