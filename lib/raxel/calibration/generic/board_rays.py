"""A ray for every pixel that a board covers: the table at the end of Algorithm 1.

Millions of pairs of a pixel and a board are summed up here, and nothing is kept of
them but nine numbers a pixel.
"""

import numpy as np

ROWS = 16  # of the table, handled at once


def ray_table(views, T_base_grid, centre, width, height, weights=None):
    """Directions (height, width, 3) in base axes, NaN where no board covers a pixel.

    views: BoardViews or DenseViews; T_base_grid: (n, 4, 4), their poses; centre: (3,).
    Least squares of the ray-point distances (4.18): the dominant eigenvector of the
    second moments of a pixel's points about the centre, which are summed view by view;
    DenseViews weight their points with 1/sigma^2, and all points of a view count with
    its weight (n,), where given (4.1.3). Memory: nine numbers per pixel.
    """
    sums = np.zeros((height, width, 9))
    weights = np.ones(len(views)) if weights is None else weights
    for view, T, weight in zip(views, T_base_grid, weights, strict=True):
        view.add_moments(sums, T, centre, weight)
    table = np.empty((height, width, 3))
    for start in range(0, height, ROWS):
        rows = slice(start, start + ROWS)
        of_rows = np.ascontiguousarray(np.moveaxis(sums[rows], -1, 0))
        table[rows] = np.moveaxis(_main_axes(*of_rows), 0, -1)
    return table


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
