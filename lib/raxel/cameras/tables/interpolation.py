"""Rays between the pixel centres of a table, and Newton's method on them, compiled.

A table comes as its directions (H * W, 3), its origins (H * W, 3), or (1, 3) where all
rays have one origin, and its width W. A cell is named by its upper left pixel (u, v)
and by its extent to the right and down, 1 or 0: one of width or height 0 is an edge or
a single pixel. At (s, t) in [0, 1]^2 of a cell, directions and origins are bilinear.
bilinear.
"""

from __future__ import annotations

import math

import numba
import numpy as np

# Smooth fields over an image: uniform tensor-product cubic B-splines. Cells of
# `spacing` px start at the image's corner (-0.5, -0.5). At a position in cell (i, j),
# at the fractions s and t of it, control value (j + k, i + l) of the 4 x 4 has the
# weight b_k(t) b_l(s): b(t) = (1 - t)^3 / 6, (3 t^3 - 6 t^2 + 4) / 6, (-3 t^3 + 3 t^2 +
# 3 t + 1) / 6, t^3 / 6. The field decreases smoothly to zero outside the control
# values.

# Relative tolerance of Newton's method, px, and maximum number of steps.
ROUNDING_TOL, MAX_N_STEPS = 4e-16, 100


def control_shape(width: int, height: int, spacing: float) -> tuple[int, ...]:
    """Return the shape of the control values over an image.

    Parameters
    ----------
    width, height : int
        Size of the image, px.
    spacing : float
        Side of the spline's cells, px.

    Returns
    -------
    tuple of int
        (rows, columns).
    """
    return tuple(math.ceil(size / spacing) + 3 for size in (height, width))


def field_at(pixels, control, spacing):
    """Values (N, 2) at pixels (N, 2), and their slopes (N, 2, 2), columns by u, v.

    control: (rows, columns, 2). NaN at pixels that are not finite.
    """
    return _field_at(np.ascontiguousarray(pixels), control, float(spacing))


def undisplaced(targets, control, spacing):
    """Pixels p (N, 2) with p + field(p) = target, for targets (N, 2).

    The solution is unique, and exact to rounding, where `steepest` is below 1. NaN for
    targets that are not finite.
    """
    return _undisplaced(np.ascontiguousarray(targets), control, float(spacing))


def shares(pixels, shape, spacing):
    """Weight of each control value in the field at pixels (N, 2).

    shape: (rows, columns). Returns indices (N, 16) of control values, row by row, and
    shares (N, 16), zero for those that do not exist.
    """
    place = (np.asarray(pixels, float) + 0.5) / spacing
    cell = np.floor(place)
    along = _four(place[:, 0] - cell[:, 0])
    down = _four(place[:, 1] - cell[:, 1])
    column = cell[:, 0, None].astype(int) + np.arange(4)
    row = cell[:, 1, None].astype(int) + np.arange(4)
    rows, columns = shape
    along = np.where((column >= 0) & (column < columns), along, 0.0)
    down = np.where((row >= 0) & (row < rows), down, 0.0)
    row, column = np.clip(row, 0, rows - 1), np.clip(column, 0, columns - 1)
    index = row[:, :, None] * columns + column[:, None]
    share = down[:, :, None] * along[:, None]
    return index.reshape(len(place), 16), share.reshape(len(place), 16)


def steepest(control, spacing):
    """Upper bound of the field's slope, px per px, in any direction."""
    framed = np.pad(control, ((1, 1), (1, 1), (0, 0)))
    by_axis = [np.diff(framed, axis=axis) / spacing for axis in (1, 0)]
    # A slope is a weighted mean of differences of neighbours.
    largest = [np.linalg.norm(d, axis=-1).max() for d in by_axis]
    return float(np.hypot(*largest))


def _four(t):
    """The four shares b(t) (N, 4)."""
    t = t[:, None]
    return (
        np.hstack(
            [(1 - t) ** 3, (3 * t - 6) * t**2 + 4, ((3 - 3 * t) * t + 3) * t + 1, t**3]
        )
        / 6
    )


@numba.njit(cache=True)
def cubic_shares(t, b, slope):
    """b(t) and b'(t) into b (4,) and slope (4,)."""
    s = 1.0 - t
    b[0] = s * s * s / 6
    b[1] = ((3 * t - 6) * t * t + 4) / 6
    b[2] = ((3 * s - 6) * s * s + 4) / 6
    b[3] = t * t * t / 6
    slope[0] = -s * s / 2
    slope[1] = (3 * t - 4) * t / 2
    slope[2] = -(3 * s - 4) * s / 2
    slope[3] = t * t / 2


@numba.njit(cache=True)
def _one(u, v, control, spacing, b, out):
    """Into out (6,): the field at (u, v), its slopes by u, by v."""
    out[:] = 0.0
    rows, columns, _ = control.shape
    x, y = (u + 0.5) / spacing, (v + 0.5) / spacing
    # Far outside the field is zero, and the cell index would overflow.
    if not (-4 < x < columns and -4 < y < rows):
        if not (np.isfinite(u) and np.isfinite(v)):
            out[:] = np.nan
        return
    i, j = int(np.floor(x)), int(np.floor(y))
    cubic_shares(x - i, b[0], b[1])
    cubic_shares(y - j, b[2], b[3])
    for k in range(4):
        if not 0 <= j + k < rows:
            continue
        for m in range(4):
            if not 0 <= i + m < columns:
                continue
            for c in range(2):
                value = control[j + k, i + m, c]
                out[c] += b[2, k] * b[0, m] * value
                out[2 + c] += b[2, k] * b[1, m] * value / spacing
                out[4 + c] += b[3, k] * b[0, m] * value / spacing


@numba.njit(cache=True)
def _field_at(pixels, control, spacing):
    values, slopes = np.empty((len(pixels), 2)), np.empty((len(pixels), 2, 2))
    b, out = np.empty((4, 4)), np.empty(6)
    for n in range(len(pixels)):
        _one(pixels[n, 0], pixels[n, 1], control, spacing, b, out)
        for c in range(2):
            values[n, c] = out[c]
            slopes[n, c, 0], slopes[n, c, 1] = out[2 + c], out[4 + c]
    return values, slopes


@numba.njit(cache=True)
def _undisplaced(targets, control, spacing):
    """Newton steps; one that does not halve the residual is replaced by a fixed-point
    step, p = target - field(p), which always converges for slopes below 1."""
    pixels = np.empty(targets.shape)
    b, out = np.empty((4, 4)), np.empty(6)
    for n in range(len(targets)):
        x, y = targets[n, 0], targets[n, 1]
        u, v, before = x, y, np.inf
        tolerance = ROUNDING_TOL * (1 + abs(x) + abs(y))
        for _ in range(MAX_N_STEPS):
            _one(u, v, control, spacing, b, out)
            du, dv = u + out[0] - x, v + out[1] - y
            miss = abs(du) + abs(dv)
            if not miss > tolerance:
                break
            xx, xy, yx, yy = 1 + out[2], out[4], out[3], 1 + out[5]
            det = xx * yy - xy * yx
            if miss < before / 2 and det > 0:
                u -= (yy * du - xy * dv) / det
                v -= (xx * dv - yx * du) / det
            else:
                u, v = u - du, v - dv
                if miss >= before and miss < 100 * tolerance:
                    break
            before = miss
        pixels[n, 0], pixels[n, 1] = u, v
    return pixels


MAX_N_ROUNDS = 20
# In pixels: step at convergence, and extension of a cell over its border, so that
# rounding cannot lose a point between two cells.
STEP_TOL_PX = 1e-10
# Sine of the angle by which a ray may miss its point; rounding alone is below it.
MAX_MISS_SINE = 1e-11
# Range of Newton's method outside a cell, in cells.
MAX_OUTSIDE_CELLS = 1.0


@numba.njit(cache=True, error_model="numpy")
def rays_at(pixels, directions, origins, width, height):
    """Origins and unit directions (N, 3) at pixels (N, 2), NaN where there is no ray.

    Neighbours with zero weight are not read.
    """
    found_o = np.full((len(pixels), 3), np.nan)
    found_d = np.full((len(pixels), 3), np.nan)
    for i in range(len(pixels)):
        u, v = pixels[i, 0], pixels[i, 1]
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

    places: (N, 2), initial values. NaN without convergence.
    """
    found = np.full(places.shape, np.nan)
    for i in range(len(points)):
        point = (points[i, 0], points[i, 1], points[i, 2])
        x, y = places[i, 0], places[i, 1]
        for _ in range(MAX_N_ROUNDS):
            u = min(max(int(np.floor(x)), 0), width - 2)
            v = min(max(int(np.floor(y)), 0), height - 2)
            corners = _corners(u, v, 1, 1, width)
            dx, dy, good = _newton(point, directions, origins, corners, x - u, y - v)
            x, y = x + dx, y + dy
            if abs(dx) < STEP_TOL_PX and abs(dy) < STEP_TOL_PX:
                reach = 0.5 + STEP_TOL_PX
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

    cells: (N, 4) int, u, v, right and below; start: initial value of Newton's method,
    as a fraction of the cell. NaN for results outside.
    """
    found = np.full((len(points), 2), np.nan)
    for i in range(len(points)):
        point = (points[i, 0], points[i, 1], points[i, 2])
        u, v, right, below = cells[i, 0], cells[i, 1], cells[i, 2], cells[i, 3]
        corners = _corners(u, v, right, below, width)
        s, t = right * start[0], below * start[1]
        for _ in range(MAX_N_ROUNDS):
            ds, dt, good = _newton(point, directions, origins, corners, s, t)
            s = min(max(s + ds, -MAX_OUTSIDE_CELLS), 1.0 + MAX_OUTSIDE_CELLS)
            t = min(max(t + dt, -MAX_OUTSIDE_CELLS), 1.0 + MAX_OUTSIDE_CELLS)
            if abs(ds) < STEP_TOL_PX and abs(dt) < STEP_TOL_PX:
                inside = abs(s - right / 2) <= right / 2 + STEP_TOL_PX
                if good and inside and abs(t - below / 2) <= below / 2 + STEP_TOL_PX:
                    found[i, 0] = u + min(max(s, 0.0), float(right))
                    found[i, 1] = v + min(max(t, 0.0), float(below))
                break
            if not (np.isfinite(ds) and np.isfinite(dt)):
                break
    return found


@numba.njit(cache=True, error_model="numpy")
def _newton(point, directions, origins, corners, s, t):
    """Newton step towards the ray through a point; and whether the ray after a small
    step meets the point, in front of its origin."""
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
    # An edge has no extent along one axis, a single pixel along both: no step there.
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
    return step_s, step_t, sine < MAX_MISS_SINE and _dot(far, d) > 0


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
