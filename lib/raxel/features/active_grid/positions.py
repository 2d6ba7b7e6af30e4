"""Positions from cells and phases, row by row, in compiled loops; and look-up.

Loops are written as in `reading`; only `turn_row` is compiled in from `phases`.
"""

from __future__ import annotations

from itertools import combinations

import numba
import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from raxel.errors import InputError
from raxel.features.active_grid.coding import (
    ALONE,
    BAD,
    BELOW,
    BLOCK_PX,
    CELL_OFFSET,
    COSINE,
    DECODED,
    DOUBT,
    HIGHEST,
    LOST,
    LOWEST,
    MAX_STRIP_COLUMNS,
    OUTSIDE,
    OWN,
    PERIOD,
    POSITION,
    RIGHT,
    RING_ROWS,
    SIGMA,
    SINE,
    SPREAD,
    STATUS,
    TURN,
    UNREADABLE,
)
from raxel.features.active_grid.phases import turn_row
from raxel.geometry.homography import apply_homography, homography_dlt

# Look-up in a decoded active grid: the point at a pixel, and the pixel of a point.


UNBOUNDED_CELL = 1e9  # side of a cell that contains all points
SEARCH_RADIUS_PX = 2  # around the nearest pixel, for the four nearest ones


def points_at(location: np.ndarray, pixels: ArrayLike) -> NDArray[np.float64]:
    """Return the points that are visible at pixels, by bilinear interpolation.

    Parameters
    ----------
    location : np.ndarray
        (H, W, 2), as `Decoded.location`.
    pixels : ArrayLike
        (N, 2) pixels (u, v).

    Returns
    -------
    NDArray[np.float64]
        (N, 2) points in the unit of `location`. NaN where one of the four pixels around
        has no location, or is outside the image.

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.features.active_grid import points_at
    >>> v, u = np.mgrid[:3, :4]
    >>> location = np.stack([0.5 * u, 0.5 * v], axis=2)
    >>> points_at(location, [[1.5, 0.5], [3.5, 0.5]]).tolist()
    [[0.75, 0.25], [nan, nan]]
    """
    pixels = np.asarray(pixels, float)
    first = np.floor(pixels)
    height, width = location.shape[:2]
    with np.errstate(invalid="ignore"):
        inside = np.all((first >= 0) & (first + 1 < [width, height]), axis=1)
    points = np.full(pixels.shape, np.nan)
    u, v = first[inside].astype(int).T
    right, down = (pixels[inside] - first[inside]).T[..., None]
    points[inside] = (1 - down) * (
        (1 - right) * location[v, u] + right * location[v, u + 1]
    ) + down * ((1 - right) * location[v + 1, u] + right * location[v + 1, u + 1])
    return points


def pixels_of(location: np.ndarray, points: ArrayLike) -> NDArray[np.float64]:
    """Return the pixels at which points of the grid are visible.

    `location` is searched for the pixel that is nearest to a point on the grid. The
    four nearest ones there, no three of them on a line, determine a homography from
    their points to their pixels. It maps the point, too.

    Parameters
    ----------
    location : np.ndarray
        (H, W, 2), as `Decoded.location`.
    points : ArrayLike
        (N, 2) points in the unit of `location`.

    Returns
    -------
    NDArray[np.float64]
        (N, 2) pixels (u, v). NaN for points that are not finite, where no four pixels
        about a point have a location, or where all are on one side of it.

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.features.active_grid import pixels_of
    >>> v, u = np.mgrid[:6, :8]
    >>> location = np.stack([0.5 * u, 0.5 * v], axis=2)
    >>> np.round(pixels_of(location, [[1.6, 1.3]]), 3).tolist()
    [[3.2, 2.6]]
    """
    points = np.asarray(points, float)
    pixels = np.full((len(points), 2), np.nan)
    selected = np.flatnonzero(np.isfinite(points).all(axis=1))
    if len(selected):
        single = np.ascontiguousarray(location, np.float32)
        nearest = nearest_pixels(single, points[selected])
        for k, pixel in zip(selected, nearest, strict=True):
            if pixel[0] >= 0:
                pixels[k] = _between(location, pixel, points[k])
    return pixels


def nearest_pixels(
    location: NDArray[np.float32], points: NDArray[np.float64]
) -> NDArray[np.int64]:
    """Return the pixel whose location is nearest to each point.

    The points are sorted into as many square cells as there are points. A pixel is
    compared with those in its own cell and the eight around it.

    Parameters
    ----------
    location : NDArray[np.float32]
        (H, W, 2), contiguous, NaN where there is no location.
    points : NDArray[np.float64]
        (N, 2) finite points, N >= 1.

    Returns
    -------
    NDArray[np.int64]
        (N, 2) pixels u and v; -1 for none.
    """
    low, extent = points.min(axis=0), np.ptp(points, axis=0).max()
    side = extent / np.sqrt(len(points)) or UNBOUNDED_CELL
    cells = ((points - low) / side).astype(int) + 1
    shape = cells.max(axis=0) + 2
    number = cells @ [1, shape[0]]
    order = np.argsort(number, kind="stable")
    starts = np.searchsorted(number[order], np.arange(shape.prod() + 1))
    return _search(location, points, low, side, shape, order, starts)


@numba.njit(cache=True)
def _search(location, points, low, side, shape, order, starts):
    best = np.full(len(points), np.inf)
    pixels = np.full((len(points), 2), -1)
    for v in range(location.shape[0]):
        for u in range(location.shape[1]):
            x, y = location[v, u, 0], location[v, u, 1]
            if np.isnan(x) or np.isnan(y):
                continue
            column = int(np.floor((x - low[0]) / side)) + 1
            row = int(np.floor((y - low[1]) / side)) + 1
            if not (0 <= column < shape[0] and 0 <= row < shape[1]):
                continue
            first, last = max(column - 1, 0), min(column + 1, shape[0] - 1)
            for near in range(max(row - 1, 0), min(row + 1, shape[1] - 1) + 1):
                start = starts[near * shape[0] + first]
                for k in range(start, starts[near * shape[0] + last + 1]):
                    n = order[k]
                    distance = (x - points[n, 0]) ** 2 + (y - points[n, 1]) ** 2
                    if distance < best[n]:
                        best[n] = distance
                        pixels[n, 0], pixels[n, 1] = u, v
    return pixels


def _between(location, pixel, point):
    """Return the pixel of `point` between the four nearest pixels."""
    low = np.maximum(pixel - SEARCH_RADIUS_PX, 0)
    high = pixel + SEARCH_RADIUS_PX + 1
    part = location[low[1] : high[1], low[0] : high[0]]
    v, u = np.nonzero(np.isfinite(part).all(axis=2))
    visible = part[v, u].astype(float)
    around = np.column_stack([u, v]) + low
    order = np.argsort(np.sum((visible - point) ** 2, axis=1), kind="stable")
    four = []
    for k in order:
        sides = (around[list(pair)] - around[k] for pair in combinations(four, 2))
        if all(a[0] * b[1] != b[0] * a[1] for a, b in sides):  # not collinear
            four.append(k)
        if len(four) == 4:
            break
    else:
        return np.full(2, np.nan)
    try:
        H = homography_dlt(visible[four], around[four].astype(float))
    except InputError:  # collinear or equal points
        return np.full(2, np.nan)
    found = apply_homography(H, point[None])[0]
    return found if np.abs(found - pixel).max() <= 1 else np.full(2, np.nan)


# Share of a period: pixels this close to the next period may belong to it; the shift by
# a response is smaller.
PERIOD_TOL = np.float32(0.02)
# Minimal cosine between phases on one surface, as for breaks (`OPPOSITE_COSINE`).
MIN_SURFACE_COSINE = np.float32(-1e-6)
# Distance from a cell, in cells, at which its code may be read at a blurred edge.
BLURRED_CELLS = np.float32(0.3)
# Squared number of standard deviations beyond the monitor's border with any light.
BORDER_VARIANCES = np.float32(16.0)
_ZERO, _HALF, _ONE = np.float32(0), np.float32(0.5), np.float32(1)
_NOWHERE = np.float32(np.nan)


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_doubt(axis, y, height, n, rows):
    """Set DOUBT next to an edge: a neighbour has another cell, or a bit is weak."""
    codes, greys, flags = rows.codes, rows.greys, rows.flags
    k, above, under = (
        y % RING_ROWS,
        max(y - 1, 0) % RING_ROWS,
        min(y + 1, height - 1) % RING_ROWS,
    )
    for x in range(n):
        own, lowest = codes[axis, k, x], greys[axis, k, LOWEST + x]
        weak = 2 * np.int32(lowest) < np.int32(greys[0, k, HIGHEST + x])
        upright = (own != codes[axis, above, x]) | (own != codes[axis, under, x])
        flags[axis, DOUBT + x] = weak | upright
    # Loops with indices that are known to be nonnegative are vectorised.
    for x in range(n - 1):
        flags[axis, DOUBT + x] |= codes[axis, k, x] != codes[axis, k, x + 1]
    for x in range(n - 1):
        flags[axis, DOUBT + x + 1] |= codes[axis, k, x] != codes[axis, k, x + 1]


@njit(cache=True, nogil=True, error_model="numpy")
def _nearest_period(axis, k, n, ratio, rows):
    """Set the period whose position with this phase is nearest to the cell's centre.

    CELL_OFFSET: distance from the centre, in periods. DOUBT: an edge is visible, and
    the period is uncertain, because the next period is near or noise could exchange the
    two (even). LOST: as DOUBT by noise, but without a visible edge that decides.
    """
    codes, work, flags, marks = rows.codes, rows.work, rows.flags, rows.marks
    farthest, reach = _ONE - _HALF * ratio, BLURRED_CELLS * ratio
    for x in range(n):
        turn = work[axis, TURN + x]
        middle = (np.float32(codes[axis, k, x]) + _HALF) * ratio
        nearest = np.ceil(middle - turn - _HALF)
        offset = nearest + turn - middle
        work[axis, PERIOD + x] = nearest
        work[axis, CELL_OFFSET + x] = offset
        gap = farthest - abs(offset)
        even = gap * abs(gap) < BORDER_VARIANCES * work[axis, SPREAD + x]
        visible, selected = flags[axis, DOUBT + x] != 0, marks[k, BAD + x] == DECODED
        flags[axis, DOUBT + x] = selected & visible & ((gap < reach) | even)
        flags[axis, LOST + x] = selected & even & (not visible)


@njit(cache=True, nogil=True, error_model="numpy")
def _which(axis, flags, out):
    """Return the number of pixels in doubt; out: which; tests eight bytes at a time."""
    count, doubt = 0, flags[axis, DOUBT : DOUBT + MAX_STRIP_COLUMNS]
    eight = doubt.view(np.uint64)
    for k in range(len(eight)):
        if eight[k]:
            for x in range(8 * k, 8 * k + 8):
                if doubt[x]:
                    out[count] = x
                    count += 1
    return count


@njit(cache=True, nogil=True, error_model="numpy")
def _bit_of_edge(edge, bits):
    """Return the bit that changes between cells edge - 1 and edge; 0: coarsest."""
    bit = bits - 1
    while edge % 2 == 0:
        edge //= 2
        bit -= 1
    return bit


@njit(cache=True, nogil=True, error_model="numpy")
def _is_visible(edge, contrast, contrast_limit, cell, around, by_others):
    """Whether the edge between cells edge - 1 and edge is visible at a pixel.

    Its bit has little contrast there, or (by_others) one of the four neighbours is on
    the other side of it.
    """
    above, under, left, right = around
    past = cell >= edge
    visible = ((above >= edge) != past) | ((under >= edge) != past)
    visible |= ((left >= edge) != past) | ((right >= edge) != past)
    return (4 * contrast < 3 * contrast_limit) | (visible & by_others)


@njit(cache=True, nogil=True, error_model="numpy")
def _difference(images, y, x, pairs, edge):
    """Return image minus inverse of the bit that changes at an edge of cells."""
    bit = _bit_of_edge(edge, len(pairs))
    light, dark = images[pairs[bit, 0], y, x], images[pairs[bit, 1], y, x]
    return np.int64(light) - np.int64(dark)


@njit(cache=True, nogil=True, error_model="numpy")
def _sum_around(images, y, x, start, width, pairs, edge, axis, waves, codes, marks):
    """Return the number of 3 x 3 pixels on the same surface, and sum of `_difference`.

    Excludes bad pixels, those outside, and those across a break. The sum is positive
    where it agrees with the central pixel. start, width: of the strip.
    """
    total, count, k = 0, 0, y % RING_ROWS
    for v in range(max(y - 1, 0), min(y + 2, images.shape[1])):
        i = v % RING_ROWS
        for u in range(max(x - 1, 0), min(x + 2, width)):
            along = waves[axis, k, SINE + x] * waves[axis, i, SINE + u]
            along += waves[axis, k, COSINE + x] * waves[axis, i, COSINE + u]
            difference = np.int64(codes[axis, i, u]) - np.int64(codes[axis, k, x])
            if (
                abs(difference) <= 1
                and marks[i, BAD + u] == DECODED
                and along >= MIN_SURFACE_COSINE
            ):
                count += 1
                total += _difference(images, v, start + u, pairs, edge)
    agrees = _difference(images, y, start + x, pairs, edge) > 0
    return count, total if agrees else -total


@njit(cache=True, nogil=True, error_model="numpy")
def _settle(images, y, axis, strip, plan, rows, selected):
    """Apply the wrap rule: at an edge of cells the phase decides on the side.

    A pixel whose phase is near the start or end of its period is at one edge of its
    cell, or beyond the other one with the bit of that edge misread. A misread bit has
    little contrast. Where noise could wrap the phase (even), one of the two edges must
    be visible. If the edge across is visible, the bits of both edges decide, each as a
    mean of the 3 x 3 pixels on the same surface.

    selected: the pixels in doubt. Their period changes by one, or lost is set. There
    are no edges before the first one and from plan.edges on.
    """
    pairs, edges = plan.pairs[axis, : plan.bits[axis]], plan.edges[axis]
    height, last = images.shape[1], strip.width - 1
    surface = axis, rows.waves, rows.codes, rows.marks
    k, above, under = (
        y % RING_ROWS,
        max(y - 1, 0) % RING_ROWS,
        min(y + 1, height - 1) % RING_ROWS,
    )
    code, work, lost = rows.codes[axis], rows.work[axis], rows.flags[axis, LOST:]
    greys, columns = rows.greys, (strip.start, strip.width)
    farthest = _ONE - _HALF * plan.ratio[axis]
    for x in selected:
        u, offset = strip.start + x, work[CELL_OFFSET + x]
        gap = farthest - abs(offset)
        even = gap * abs(gap) < BORDER_VARIANCES * work[SPREAD + x]
        cell, contrast_limit, below = (
            np.int64(code[k, x]),
            np.int64(greys[0, k, HIGHEST + x]),
            offset < 0,
        )
        near, across = (cell, cell + 1) if below else (cell + 1, cell)
        around = code[above, x], code[under, x], code[k, max(x - 1, 0)]
        visibility = contrast_limit, cell, (*around, code[k, min(x + 1, last)])
        near_is_visible = across_is_visible = False
        if 0 < near < edges:
            contrast = abs(_difference(images, y, u, pairs, near))
            near_is_visible = _is_visible(near, contrast, *visibility, True)
        if 0 < across < edges:
            contrast = abs(_difference(images, y, u, pairs, across))
            close = even | (gap < PERIOD_TOL)
            across_is_visible = _is_visible(across, contrast, *visibility, close)
        if not across_is_visible:
            lost[x] |= even & (not near_is_visible)
            continue
        count, at_across = _sum_around(images, y, x, *columns, pairs, across, *surface)
        half = at_near = count * contrast_limit
        if 0 < near < edges:
            at_near = 2 * abs(
                _sum_around(images, y, x, *columns, pairs, near, *surface)[1]
            )
        if 2 * at_across < min(half, at_near):
            work[PERIOD + x] += _ONE if below else -_ONE
        else:
            lost[x] |= even & (at_near >= half)


@njit(cache=True, nogil=True, error_model="numpy")
def _find_period(images, y, axis, strip, plan, rows):
    """Set the period of each pixel of a row from its code, and resolve doubts."""
    n, ratio = strip.width, plan.ratio[axis]
    if plan.bits[axis]:
        _mark_doubt(axis, y, images.shape[1], n, rows)
    _nearest_period(axis, y % RING_ROWS, n, ratio, rows)
    if plan.bits[axis]:
        selected = rows.selected[: _which(axis, rows.flags, rows.selected)]
        _settle(images, y, axis, strip, plan, rows, selected)
    else:
        rows.flags[axis, LOST : LOST + n] = 0


@njit(cache=True, nogil=True, error_model="numpy")
def _cell_as_period(axis, k, n, rows):
    for x in range(n):
        rows.work[axis, PERIOD + x] = np.float32(rows.codes[axis, k, x])


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_alone(k, before, n, rows):
    """Set STATUS: bad pixels, and pixels with breaks to all four neighbours."""
    marks, common = rows.marks, rows.common
    for x in range(n):
        difference = (marks[k, BELOW + x] != 0) & (marks[before, BELOW + x] != 0)
        difference &= (marks[k, RIGHT + x] != 0) & (marks[k, BAD + x] == DECODED)
        common[STATUS + x] = ALONE if difference else marks[k, BAD + x]
    for x in range(n - 1):
        status, own = common[STATUS + x + 1], marks[k, BAD + x + 1]
        joined = marks[k, RIGHT + x] == 0
        common[STATUS + x + 1] = own if joined else status


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_lost(axis, n, rows):
    flags, common = rows.flags, rows.common
    for x in range(n):
        status = common[STATUS + x]
        lost = (flags[axis, LOST + x] != 0) & (status == DECODED)
        common[STATUS + x] = UNREADABLE if lost else status


@njit(cache=True, nogil=True, error_model="numpy")
def _find_position(axis, n, length, extent, rows):
    """Set positions, and mark those outside the monitor by more than noise."""
    work, common = rows.work, rows.common
    slack = BORDER_VARIANCES * length * length
    for x in range(n):
        position = length * (work[axis, PERIOD + x] + work[axis, TURN + x])
        work[axis, POSITION + x] = position
        excess = max(-position, position - extent)
        offset = (excess > _ZERO) & (excess * excess > slack * work[axis, SPREAD + x])
        status = common[STATUS + x]
        common[STATUS + x] = OUTSIDE if (status == DECODED) & offset else status


@njit(cache=True, nogil=True, error_model="numpy")
def _find_sigma(axis, bias, length, rows):
    """Set standard deviations, NaN where not decoded; bias: squared turns."""
    work, common = rows.work, rows.common
    for x in range(len(bias)):
        known = common[STATUS + x] == DECODED
        spread = length * np.sqrt(work[axis, SPREAD + x] + bias[x])
        work[axis, SIGMA + x] = spread if known else _NOWHERE
        work[axis, POSITION + x] = work[axis, POSITION + x] if known else _NOWHERE


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_own(axis, n, rows):
    """Make sigma negative where a phase is that of one pixel."""
    work, flags = rows.work, rows.flags
    for x in range(n):
        sigma = work[axis, SIGMA + x]
        work[axis, SIGMA + x] = -sigma if flags[axis, OWN + x] else sigma


@njit(cache=True, nogil=True, error_model="numpy")
def _copy(values, out):
    for x in range(len(out)):
        out[x] = values[x]


@njit(cache=True, nogil=True, error_model="numpy")
def _copy_whole(values, out):
    for x in range(len(out)):
        out[x] = np.int16(np.int32(values[x]))


@njit(cache=True, nogil=True, error_model="numpy")
def _hand_over(i, strip, rows, out):
    """Write a row's own columns to row i of out."""
    location, sigma, cells, status = out
    columns, n = slice(strip.first, strip.stop), strip.stop - strip.first
    first = strip.first - strip.start
    for axis in range(len(location)):
        work = rows.work[axis, first:]
        _copy(work[POSITION : POSITION + n], location[axis, i, columns])
        _copy(work[SIGMA : SIGMA + n], sigma[axis, i, columns])
        _copy_whole(work[PERIOD : PERIOD + n], cells[axis, i, columns])
    at = STATUS + first
    _copy(rows.common[at : at + n], status[i, columns])


@njit(cache=True, nogil=True, error_model="numpy")
def locate_rows(images, part, strip, plan, smooth, mark, bias, rows, out):
    """Set the positions of rows.

    images: (n, H, W) uint8 or uint16; part: (first, stop, position): the rows to
    decode, and the row of `out` for the first one; they were read (`read_rows`), with
    WINDOW_RADIUS rows before and ROWS_AROUND after them, as far as these exist. strip:
    Strip; plan: CodePlan; smooth, mark: average over windows, and make sigma negative
    where a phase is that of one pixel; bias: `squared_bias`; rows: Rows. out: location
    (A, h, W) float32, sigma alike, cells (A, h, W) int16 and status (h, W) uint8.
    """

    first, stop, position = part
    count, n, height = len(plan.bits), strip.width, images.shape[1]
    columns = slice(strip.start, strip.start + n)
    for y in range(first, stop):
        i, k = y - first + position, y % RING_ROWS
        turn_row(y, y == first, height, smooth, strip, plan, rows)
        for axis in range(count):
            if plan.used[axis]:
                _find_period(images, y, axis, strip, plan, rows)
            else:
                _cell_as_period(axis, k, n, rows)
        _mark_alone(k, (y - 1) % RING_ROWS, n, rows)
        for axis in range(count):
            _mark_lost(axis, n, rows)
        for axis in range(count):
            _find_position(axis, n, plan.length[axis], plan.extent[axis], rows)
        for axis in range(count):
            _find_sigma(
                axis, bias[axis, i // BLOCK_PX, columns], plan.length[axis], rows
            )
            if mark:
                _mark_own(axis, n, rows)
        _hand_over(i, strip, rows, out)
