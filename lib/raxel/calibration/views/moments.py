"""Second moments of the points that a pixel sees, summed over millions of pairs.

About the camera's centre a pixel's points (x, y, z) leave nine sums: of xx, yy, zz, xy,
xz, yz, x, y and z. Inside a cell of a board the points are a homography of the pixel,
so about the centre they are three linear forms in (u, v, 1) over a fourth; along a row
these change by one number alone.
"""

import numba
import numpy as np


@numba.njit(cache=True)
def add_runs(sums, rows, first, stop, cell, forms, weight):
    """Add the points of runs of pixels, times weight, to sums (H, W, 9); forms
    (cells, 4, 3), the fourth is what the other three are divided by."""
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

    location, sigma: (H, W, 2), NaN where nothing was seen; plane: (3, 3), from (x, y,
    1) of the grid to the base frame about the centre.
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
