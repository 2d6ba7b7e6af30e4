"""Smooth fields over an image: uniform tensor-product cubic B-splines.

Cells of `spacing` px each way start at the image's corner (-0.5, -0.5). A position in
cell (i, j), at the share s and t of it, has of each of 4 x 4 control values the share
b_k(t) b_l(s), with control value (j + k, i + l):

    b(t) = (1 - t)^3 / 6, (3 t^3 - 6 t^2 + 4) / 6,
           (-3 t^3 + 3 t^2 + 3 t + 1) / 6, t^3 / 6.

Beyond the control values the field is zero, and reaches it smoothly.
"""

import math

import numba
import numpy as np

# Newton's steps end here: relative to the position, px, and at most so many.
ROUNDING, MAX_STEPS = 4e-16, 100


def control_shape(width, height, spacing):
    """(rows, columns) of the control values over an image, cells of spacing px."""
    return tuple(math.ceil(size / spacing) + 3 for size in (height, width))


def field_at(pixels, control, spacing):
    """Values (N, 2) at pixels (N, 2), and their slopes (N, 2, 2), columns by u, v.

    control: (rows, columns, 2). NaN at pixels that are not finite.
    """
    return _field_at(np.ascontiguousarray(pixels), control, float(spacing))


def undisplaced(targets, control, spacing):
    """Pixels p (N, 2) with p + field(p) = target, for targets (N, 2).

    There is one, and it is found to rounding, where `steepest` is below 1. NaN for
    targets that are not finite.
    """
    return _undisplaced(np.ascontiguousarray(targets), control, float(spacing))


def shares(pixels, shape, spacing):
    """What part each control value has in the field at pixels (N, 2).

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
    """A bound on how fast the field changes, px per px, in any direction."""
    framed = np.pad(control, ((1, 1), (1, 1), (0, 0)))
    by_axis = [np.diff(framed, axis=axis) / spacing for axis in (1, 0)]
    # A slope is a mean of differences of neighbours, weighted with shares.
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
    # Far outside there is nothing, and no whole number for the cell.
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
    """Newton's steps; one that does not halve the miss gives way to a plain step,
    p = target - field(p), which always comes nearer where slopes are below 1."""
    pixels = np.empty(targets.shape)
    b, out = np.empty((4, 4)), np.empty(6)
    for n in range(len(targets)):
        x, y = targets[n, 0], targets[n, 1]
        u, v, before = x, y, np.inf
        enough = ROUNDING * (1 + abs(x) + abs(y))
        for _ in range(MAX_STEPS):
            _one(u, v, control, spacing, b, out)
            du, dv = u + out[0] - x, v + out[1] - y
            miss = abs(du) + abs(dv)
            if not miss > enough:
                break
            xx, xy, yx, yy = 1 + out[2], out[4], out[3], 1 + out[5]
            det = xx * yy - xy * yx
            if miss < before / 2 and det > 0:
                u -= (yy * du - xy * dv) / det
                v -= (xx * dv - yx * du) / det
            else:
                u, v = u - du, v - dv
                if miss >= before and miss < 100 * enough:
                    break
            before = miss
        pixels[n, 0], pixels[n, 1] = u, v
    return pixels
