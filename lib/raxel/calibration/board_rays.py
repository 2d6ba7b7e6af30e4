"""A ray for every pixel that a board covers: the table at the end of Algorithm 1.

Millions of pairs of a pixel and a board are summed up here, and nothing is kept of
them but nine numbers a pixel. Inside a cell the points of a board are a homography of
the pixel, so about the camera's centre they are three linear forms in (u, v, 1) over a
fourth; along a row these change by one number alone.
"""

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
    sums = np.zeros((9, height, width))
    for view, T in zip(views, T_base_grid, strict=True):
        _add_board(sums, view, T, centre)
    table = np.empty((height, width, 3))
    for start in range(0, height, ROWS):
        rows = slice(start, start + ROWS)
        table[rows] = np.moveaxis(_main_axes(*sums[:, rows]), 0, -1)
    return table


def _add_board(sums, view, T_base_grid, centre):
    """Add the moments of a board's points, and the points, to those of its pixels."""
    _, height, width = sums.shape
    cells = board_cells(view)
    if len(cells.corners) == 0:
        return
    runs = pixel_runs(cells, width, height)
    plane = T_base_grid[:3, [0, 1, 3]] - np.outer(centre, [0.0, 0.0, 1.0])
    forms = np.concatenate(
        [plane @ cells.board_from_pixel, cells.board_from_pixel[:, 2:]], axis=1
    )
    # (4, 2, R): what multiplies u, and what is left, in the row of each run.
    along, rest = forms[runs.cell, :, 0], forms[runs.cell, :, 2]
    rest = rest + forms[runs.cell, :, 1] * runs.v[:, None]
    for top in range(0, height, ROWS):
        some = slice(*np.searchsorted(runs.v, [top, top + ROWS]))
        if some.start == some.stop:
            continue
        first, stop = runs.first[some], runs.stop[some]
        low, high = first.min(), stop.max()
        rows = min(ROWS, height - top)
        places = (runs.v[some] - top) * (high - low) - low + np.stack([first, stop])
        counts = np.diff(places.T.ravel(), prepend=0, append=rows * (high - low))
        shape = (4, rows, high - low)
        x, y, z, w = _spread(along[some].T, 0.0, counts).reshape(shape) * np.arange(
            low, high
        ) + _spread(rest[some].T, [[0], [0], [0], [1]], counts).reshape(shape)
        x, y, z = p = np.stack([x, y, z]) / w
        sums[:6, top : top + rows, low:high] += [
            x * x,
            y * y,
            z * z,
            x * y,
            x * z,
            y * z,
        ]
        sums[6:, top : top + rows, low:high] += p


def _spread(values, between, counts):
    """Values (k, R) of runs, `between` around them, each `counts` (2R + 1,) times."""
    spread = np.empty((len(values), len(counts)))
    spread[:, ::2], spread[:, 1::2] = between, values
    return np.repeat(spread, counts, axis=1)


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
