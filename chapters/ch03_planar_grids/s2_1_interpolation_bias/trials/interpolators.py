"""Interpolation of the grid point of a pixel from nearby corners."""

import numpy as np

from raxel.calibration.views.correspondence import cell_maps, locate_pixels

# Number of nearest corners from which four are chosen.
CANDIDATES = 24


def places_of(view):
    """Column and row (N, 2) of each corner of a BoardView."""
    row, column = np.divmod(np.arange(len(view.pixels)), view.columns)
    return np.column_stack([column, row])


def nearest_four(pixels, corners, places):
    """The four nearest corners of each pixel, no three on one line of the grid.

    pixels: (M, 2); corners: (N, 2) px; places: (N, 2) int, column and row. Nearer
    corners come first, and a corner collinear with two others is skipped.
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
    """Step 2 of Algorithm 1 as described in section 3.2.1."""
    four = nearest_four(pixels, view.pixels, places_of(view))
    return through_four(pixels, view.pixels[four], view.points[four])


def by_enclosing_cell(pixels, view):
    """The same with the corners of the square that contains the pixel."""
    return locate_pixels(pixels, view)[0]


FOUR = {"nearest four": by_nearest_four, "enclosing cell": by_enclosing_cell}
