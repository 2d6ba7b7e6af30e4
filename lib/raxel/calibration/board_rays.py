"""A ray for every pixel that a board covers: the table at the end of Algorithm 1.

Millions of pairs of a pixel and a board are summed up here, and nothing is kept of
them but nine numbers a pixel. Inside a cell the points of a board are a homography of
the pixel, so about the camera's centre they are three linear forms in (u, v, 1) over a
fourth; along a row these change by one number alone.
"""

import numba
import numpy as np

from raxel.calibration.correspondence import board_cells, pixel_runs

ROWS = 16  # of the table, handled at once


def ray_table(views, T_base_grid, centre, width, height):
    """Directions (height, width, 3) in base axes, NaN where no board covers a pixel.

    views: BoardViews; T_base_grid: (n, 4, 4), their poses; centre: (3,). Least squares
    of the ray-point distances (4.18): the dominant eigenvector of the second moments of
    a pixel's points about the centre, which are summed board by board. Memory: nine
    numbers per pixel.
    """
    sums = np.zeros((height, width, 9))
    for view, T in zip(views, T_base_grid, strict=True):
        _add_board(sums, view, T, centre)
    table = np.empty((height, width, 3))
    for start in range(0, height, ROWS):
        rows = slice(start, start + ROWS)
        of_rows = np.ascontiguousarray(np.moveaxis(sums[rows], -1, 0))
        table[rows] = np.moveaxis(_main_axes(*of_rows), 0, -1)
    return table


def _add_board(sums, view, T_base_grid, centre):
    """Add the moments of a board's points, and the points, to those of its pixels."""
    height, width, _ = sums.shape
    cells = board_cells(view)
    if len(cells.corners) == 0:
        return
    runs = pixel_runs(cells, width, height)
    plane = T_base_grid[:3, [0, 1, 3]] - np.outer(centre, [0.0, 0.0, 1.0])
    forms = np.concatenate(
        [plane @ cells.board_from_pixel, cells.board_from_pixel[:, 2:]], axis=1
    )
    _add_runs(sums, runs.v, runs.first, runs.stop, runs.cell, forms)


@numba.njit(cache=True)
def _add_runs(sums, rows, first, stop, cell, forms):
    """The moments and points of runs of pixels; forms (cells, 4, 3), the fourth is
    what the other three are divided by."""
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
            of_pixel = sums[v, u]
            of_pixel[0] += x * x
            of_pixel[1] += y * y
            of_pixel[2] += z * z
            of_pixel[3] += x * y
            of_pixel[4] += x * z
            of_pixel[5] += y * z
            of_pixel[6] += x
            of_pixel[7] += y
            of_pixel[8] += z


def _main_axes(xx, yy, zz, xy, xz, yz, x, y, z):
    """Dominant eigenvectors (3, ...) of symmetric matrices, NaN where all is zero.

    Power iteration from (x, y, z); the points of a ray are nearly on one line already.
    """
    for _ in range(2):
        x, y, z = (
            xx * x + xy * y + xz * z,
            xy * x + yy * y + yz * z,
            xz * x + yz * y + zz * z,
        )
        length = np.sqrt(x * x + y * y + z * z)
        length = np.where(length > 0, length, np.nan)
        x, y, z = x / length, y / length, z / length
    return np.stack([x, y, z])
