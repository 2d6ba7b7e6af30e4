"""Rays between the pixel centres of a table, and Newton's method on them, compiled.

A table comes as its directions (H * W, 3), its origins (H * W, 3), or (1, 3) where all
rays begin at one point, and its width W. A cell is named by its upper left pixel (u, v)
and by how far it reaches right and down, 1 or 0: one that is 0 wide or 0 high is an
edge or a single pixel. At (s, t) in [0, 1]^2 of a cell, directions and origins are
bilinear.
"""

import numba
import numpy as np

ROUNDS = 20
# In pixels: a step this small ends the iteration, and a cell reaches this far over its
# border, so that rounding cannot lose a point between two cells.
STEP = 1e-10
# Sine of the angle by which a ray may miss its point. Rounding alone stays below it.
MISS = 1e-11
# How far outside a cell Newton's method may look, in cells.
ASTRAY = 1.0


@numba.njit(cache=True, error_model="numpy")
def rays_at(pixels, directions, origins, width, height):
    """Origins and unit directions (N, 3) at pixels (N, 2), NaN where there is no ray.

    A neighbour with no part in the sum is not looked at.
    """
    found_o = np.full((len(pixels), 3), np.nan)
    found_d = np.full((len(pixels), 3), np.nan)
    for i in range(len(pixels)):
        u, v = pixels[i]
        if not (0 <= u <= width - 1 and 0 <= v <= height - 1):
            continue
        left, top = int(u), int(v)
        s, t = u - left, v - top
        corners = _corners(left, top, int(s > 0), int(t > 0), width)
        d = _bilinear(directions, corners, s, t)[0]
        o = _bilinear(origins, corners, s, t)[0]
        length = np.sqrt((d[0] * d[0] + d[1] * d[1]) + d[2] * d[2])
        if length > 0:
            for k in range(3):
                found_o[i, k] = o[k]
                found_d[i, k] = d[k] / length
    return found_o, found_d


@numba.njit(cache=True, error_model="numpy")
def walked(points, places, directions, origins, width, height):
    """Pixels (N, 2) at which points (N, 3) are seen, by Newton's method across cells.

    places: (N, 2), where it starts. NaN where it does not arrive.
    """
    found = np.full(places.shape, np.nan)
    for i in range(len(points)):
        point = (points[i, 0], points[i, 1], points[i, 2])
        x, y = places[i]
        for _ in range(ROUNDS):
            u = min(max(int(np.floor(x)), 0), width - 2)
            v = min(max(int(np.floor(y)), 0), height - 2)
            corners = _corners(u, v, 1, 1, width)
            dx, dy, good = _newton(point, directions, origins, corners, x - u, y - v)
            x, y = x + dx, y + dy
            if abs(dx) < STEP and abs(dy) < STEP:
                reach = 0.5 + STEP
                if good and abs(x - u - 0.5) <= reach and abs(y - v - 0.5) <= reach:
                    found[i, 0] = min(max(x, u), u + 1)
                    found[i, 1] = min(max(y, v), v + 1)
                break
            if not (np.isfinite(dx) and np.isfinite(dy)):
                break
            x = min(max(x, 0.0), width - 1.0)
            y = min(max(y, 0.0), height - 1.0)
    return found


@numba.njit(cache=True, error_model="numpy")
def within_cells(points, cells, start, directions, origins, width):
    """Pixels (N, 2) at which each point (N, 3) is seen in a cell of its own.

    cells: (N, 4) int, u, v, right and below; start: where Newton's method begins, as a
    share of the cell. NaN where it leads out.
    """
    found = np.full((len(points), 2), np.nan)
    for i in range(len(points)):
        point = (points[i, 0], points[i, 1], points[i, 2])
        u, v, right, below = cells[i]
        corners = _corners(u, v, right, below, width)
        s, t = right * start[0], below * start[1]
        for _ in range(ROUNDS):
            ds, dt, good = _newton(point, directions, origins, corners, s, t)
            s = min(max(s + ds, -ASTRAY), 1.0 + ASTRAY)
            t = min(max(t + dt, -ASTRAY), 1.0 + ASTRAY)
            if abs(ds) < STEP and abs(dt) < STEP:
                inside = abs(s - right / 2) <= right / 2 + STEP
                if good and inside and abs(t - below / 2) <= below / 2 + STEP:
                    found[i, 0] = u + min(max(s, 0.0), float(right))
                    found[i, 1] = v + min(max(t, 0.0), float(below))
                break
            if not (np.isfinite(ds) and np.isfinite(dt)):
                break
    return found


@numba.njit(cache=True, error_model="numpy")
def _newton(point, directions, origins, corners, s, t):
    """Newton step towards the ray through a point; and whether the ray after a small
    step meets the point, ahead of its origin."""
    d, d_s, d_t = _bilinear(directions, corners, s, t)
    o, o_s, o_t = _bilinear(origins, corners, s, t)
    far = (point[0] - o[0], point[1] - o[1], point[2] - o[2])
    length = np.sqrt((far[0] * far[0] + far[1] * far[1]) + far[2] * far[2])
    if length == 0:
        length = np.nan
    far = _over(far, length)
    miss = _cross(far, d)
    miss_s = _less(_cross(far, d_s), _cross(_over(o_s, length), d))
    miss_t = _less(_cross(far, d_t), _cross(_over(o_t, length), d))
    ss, tt, st = _dot(miss_s, miss_s), _dot(miss_t, miss_t), _dot(miss_s, miss_t)
    gs, gt = _dot(miss_s, miss), _dot(miss_t, miss)
    # An edge has no extent one way, a single pixel neither way: no step there.
    if not ss > 0:
        ss = 1.0
    if not tt > 0:
        tt = 1.0
    own = ss * tt - st * st
    step_s = -(tt * gs - st * gt) / own
    step_t = -(ss * gt - st * gs) / own
    rest = (
        (miss[0] + step_s * miss_s[0]) + step_t * miss_t[0],
        (miss[1] + step_s * miss_s[1]) + step_t * miss_t[1],
        (miss[2] + step_s * miss_s[2]) + step_t * miss_t[2],
    )
    sine = np.sqrt(_dot(rest, rest) / _dot(d, d))
    return step_s, step_t, sine < MISS and _dot(far, d) > 0


@numba.njit(cache=True)
def _corners(u, v, right, below, width):
    """Rows of a cell's corners: upper left, upper right, lower left, lower right."""
    first = v * width + u
    down = below * width
    return first, first + right, first + down, first + right + down


@numba.njit(cache=True)
def _bilinear(values, corners, s, t):
    """Value at (s, t) and its derivatives d/ds and d/dt, three numbers each."""
    if len(values) == 1:
        none = (0.0, 0.0, 0.0)
        return (values[0, 0], values[0, 1], values[0, 2]), none, none
    x = _component(values, corners, 0, s, t)
    y = _component(values, corners, 1, s, t)
    z = _component(values, corners, 2, s, t)
    return (x[0], y[0], z[0]), (x[1], y[1], z[1]), (x[2], y[2], z[2])


@numba.njit(cache=True)
def _component(values, corners, k, s, t):
    base = values[corners[0], k]
    along, down = values[corners[1], k] - base, values[corners[2], k] - base
    twist = values[corners[3], k] - values[corners[1], k] - down
    slope_s, slope_t = along + t * twist, down + s * twist
    return base + s * slope_s + t * down, slope_s, slope_t


@numba.njit(cache=True)
def _dot(a, b):
    # In the order in which numpy sums three products.
    return a[0] * b[0] + a[2] * b[2] + a[1] * b[1]


@numba.njit(cache=True)
def _cross(a, b):
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


@numba.njit(cache=True)
def _less(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@numba.njit(cache=True, error_model="numpy")
def _over(a, number):
    return (a[0] / number, a[1] / number, a[2] / number)
