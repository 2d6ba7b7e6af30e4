"""From cells and phases to places, row by row, in compiled loops.

Written as `reading`; what is compiled in from `phases` is `turn_row`.
"""

from __future__ import annotations

import numba
import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from raxel.errors import InputError
from raxel.features.active_grid.coding import (
    ALONE,
    BAD,
    BELOW,
    BESIDE,
    COSINE,
    DECODED,
    DOUBT,
    HIGHEST,
    KEPT,
    LOST,
    LOWEST,
    OFF,
    OWN,
    PERIOD,
    PLACE,
    RIGHT,
    SIGMA,
    SINE,
    SPREAD,
    SQUARE,
    STATUS,
    STRIP,
    TURN,
    UNREADABLE,
)
from raxel.features.active_grid.phases import turn_row
from raxel.geometry.homography import apply_homography, homography_dlt

# Looking up a decoded active grid: the point at a place of the image, and back.


ANYWHERE = 1e9  # side of a cell that holds all there is
REACH = 2  # px about the nearest pixel, where the four are looked for


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
    asked = np.flatnonzero(np.isfinite(points).all(axis=1))
    if len(asked):
        single = np.ascontiguousarray(location, np.float32)
        nearest = nearest_pixels(single, points[asked])
        for k, pixel in zip(asked, nearest, strict=True):
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
    side = extent / np.sqrt(len(points)) or ANYWHERE
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
    """Where `point` is seen between the four pixels that see nearest to it."""
    low = np.maximum(pixel - REACH, 0)
    high = pixel + REACH + 1
    part = location[low[1] : high[1], low[0] : high[0]]
    v, u = np.nonzero(np.isfinite(part).all(axis=2))
    seen = part[v, u].astype(float)
    around = np.column_stack([u, v]) + low
    order = np.argsort(np.sum((seen - point) ** 2, axis=1), kind="stable")
    four = []
    for k in order:
        if all(_triangle(around[i], around[j], around[k]) for i, j in _pairs(four)):
            four.append(k)
        if len(four) == 4:
            break
    else:
        return np.full(2, np.nan)
    try:
        H = homography_dlt(seen[four], around[four].astype(float))
    except InputError:  # their places are in a row, or one
        return np.full(2, np.nan)
    found = apply_homography(H, point[None])[0]
    return found if np.abs(found - pixel).max() <= 1 else np.full(2, np.nan)


def _pairs(members):
    return [(i, j) for n, i in enumerate(members) for j in members[n + 1 :]]


def _triangle(a, b, c):
    """Whether three pixels are not on one line."""
    return (b[0] - a[0]) * (c[1] - a[1]) != (b[1] - a[1]) * (c[0] - a[0])


# Near the next period by less than this share of one; what a response shifts phases
# by is less.
CLOSE = np.float32(0.02)
# The cosine of phases on one surface is above this: as for breaks, `reading.OPPOSED`.
SAME = np.float32(-1e-6)
# So far from a cell, in cells, its code may be read when an edge is blurred.
BLURRED = np.float32(0.3)
# Beyond the monitor's border by four standard deviations there is no light; this is
# squared.
FAR = np.float32(16.0)
_ZERO, _HALF, _ONE = np.float32(0), np.float32(0.5), np.float32(1)
_NOWHERE = np.float32(np.nan)


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_seen(axis, y, height, n, rows):
    """DOUBT beside an edge: one of four neighbours is elsewhere, or a bit is weak."""
    codes, greys, flags = rows.codes, rows.greys, rows.flags
    k, above, under = y % KEPT, max(y - 1, 0) % KEPT, min(y + 1, height - 1) % KEPT
    for x in range(n):
        own, least = codes[axis, k, x], greys[axis, k, LOWEST + x]
        weak = 2 * np.int32(least) < np.int32(greys[0, k, HIGHEST + x])
        upright = (own != codes[axis, above, x]) | (own != codes[axis, under, x])
        flags[axis, DOUBT + x] = weak | upright
    # Indices that are seen to be no less than 0 run on many pixels at once.
    for x in range(n - 1):
        flags[axis, DOUBT + x] |= codes[axis, k, x] != codes[axis, k, x + 1]
    for x in range(n - 1):
        flags[axis, DOUBT + x + 1] |= codes[axis, k, x] != codes[axis, k, x + 1]


@njit(cache=True, nogil=True, error_model="numpy")
def _nearest_period(axis, k, n, ratio, rows):
    """The period whose place with this phase is nearest to the middle of the cell.

    OFF: by how much it is beyond the middle, in periods. DOUBT from where an edge is
    seen to where it leaves the period in doubt: near the next one, and where noise
    could turn one into the other (even). LOST if no edge is seen there: nothing says
    which one it is.
    """
    codes, work, flags, marks = rows.codes, rows.work, rows.flags, rows.marks
    farthest, reach = _ONE - _HALF * ratio, BLURRED * ratio
    for x in range(n):
        turn = work[axis, TURN + x]
        middle = (np.float32(codes[axis, k, x]) + _HALF) * ratio
        nearest = np.ceil(middle - turn - _HALF)
        off = nearest + turn - middle
        work[axis, PERIOD + x] = nearest
        work[axis, OFF + x] = off
        gap = farthest - abs(off)
        even = gap * abs(gap) < FAR * work[axis, SPREAD + x]
        seen, asked = flags[axis, DOUBT + x] != 0, marks[k, BAD + x] == DECODED
        flags[axis, DOUBT + x] = asked & seen & ((gap < reach) | even)
        flags[axis, LOST + x] = asked & even & (not seen)


@njit(cache=True, nogil=True, error_model="numpy")
def _which(axis, flags, out):
    """How many pixels are in doubt; out: which, eight bytes looked at together."""
    count, doubt = 0, flags[axis, DOUBT : DOUBT + STRIP]
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
    """Which bit changes between cells edge - 1 and edge; bit 0 is the coarsest."""
    bit = bits - 1
    while edge % 2 == 0:
        edge //= 2
        bit -= 1
    return bit


@njit(cache=True, nogil=True, error_model="numpy")
def _is_seen(edge, contrast, most, cell, around, by_others):
    """Whether the edge between cells edge - 1 and edge is seen at a pixel.

    Its bit has lost contrast there, or (by_others) one of the four neighbours around is
    read beyond it.
    """
    above, under, left, right = around
    behind = cell >= edge
    seen = ((above >= edge) != behind) | ((under >= edge) != behind)
    seen |= ((left >= edge) != behind) | ((right >= edge) != behind)
    return (4 * contrast < 3 * most) | (seen & by_others)


@njit(cache=True, nogil=True, error_model="numpy")
def _difference(images, y, x, pairs, edge):
    """Picture less inverse of the bit that changes at an edge of cells."""
    bit = _bit_of_edge(edge, len(pairs))
    light, dark = images[pairs[bit, 0], y, x], images[pairs[bit, 1], y, x]
    return np.int64(light) - np.int64(dark)


@njit(cache=True, nogil=True, error_model="numpy")
def _sum_around(images, y, x, start, width, pairs, edge, axis, waves, codes, marks):
    """How many of 3 x 3 pixels see the same surface, and the sum of `_difference`.

    Not those that are bad, outside, or on the other side of a break. The sum is
    positive where it agrees with the pixel in the middle. start, width: of the strip.
    """
    total, count, k = 0, 0, y % KEPT
    for v in range(max(y - 1, 0), min(y + 2, images.shape[1])):
        i = v % KEPT
        for u in range(max(x - 1, 0), min(x + 2, width)):
            along = waves[axis, k, SINE + x] * waves[axis, i, SINE + u]
            along += waves[axis, k, COSINE + x] * waves[axis, i, COSINE + u]
            apart = np.int64(codes[axis, i, u]) - np.int64(codes[axis, k, x])
            if abs(apart) <= 1 and marks[i, BAD + u] == DECODED and along >= SAME:
                count += 1
                total += _difference(images, v, start + u, pairs, edge)
    agrees = _difference(images, y, start + x, pairs, edge) > 0
    return count, total if agrees else -total


@njit(cache=True, nogil=True, error_model="numpy")
def _settle(images, y, axis, strip, plan, rows, asked):
    """The wrap rule: at an edge of cells the phase says on which side a pixel is.

    A pixel whose phase is near the start or end of its period is at one edge of its
    cell, or beyond the other one, with that edge's bit misread: then the bit has lost
    contrast. Where noise could turn the phase around (even), one of the two must be
    seen. If the edge across is, the bits of both decide, each as a mean of the 3 x 3
    pixels that see the same surface.

    asked: the pixels in doubt. Their period moves by one, or lost is set. Before the
    first edge and from plan.edges on there is nothing to be seen.
    """
    pairs, edges = plan.pairs[axis, : plan.bits[axis]], plan.edges[axis]
    height, last = images.shape[1], strip.width - 1
    surface = axis, rows.waves, rows.codes, rows.marks
    k, above, under = y % KEPT, max(y - 1, 0) % KEPT, min(y + 1, height - 1) % KEPT
    code, work, lost = rows.codes[axis], rows.work[axis], rows.flags[axis, LOST:]
    greys, columns = rows.greys, (strip.start, strip.width)
    farthest = _ONE - _HALF * plan.ratio[axis]
    for x in asked:
        u, off = strip.start + x, work[OFF + x]
        gap = farthest - abs(off)
        even = gap * abs(gap) < FAR * work[SPREAD + x]
        cell, most, below = (
            np.int64(code[k, x]),
            np.int64(greys[0, k, HIGHEST + x]),
            off < 0,
        )
        near, across = (cell, cell + 1) if below else (cell + 1, cell)
        around = code[above, x], code[under, x], code[k, max(x - 1, 0)]
        seen_by = most, cell, (*around, code[k, min(x + 1, last)])
        near_is_seen = across_is_seen = False
        if 0 < near < edges:
            contrast = abs(_difference(images, y, u, pairs, near))
            near_is_seen = _is_seen(near, contrast, *seen_by, True)
        if 0 < across < edges:
            contrast = abs(_difference(images, y, u, pairs, across))
            close = even | (gap < CLOSE)
            across_is_seen = _is_seen(across, contrast, *seen_by, close)
        if not across_is_seen:
            lost[x] |= even & (not near_is_seen)
            continue
        count, at_across = _sum_around(images, y, x, *columns, pairs, across, *surface)
        half = at_near = count * most
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
    """The period of each pixel of a row, from its code, and settled where in doubt."""
    n, ratio = strip.width, plan.ratio[axis]
    if plan.bits[axis]:
        _mark_seen(axis, y, images.shape[1], n, rows)
    _nearest_period(axis, y % KEPT, n, ratio, rows)
    if plan.bits[axis]:
        asked = rows.asked[: _which(axis, rows.flags, rows.asked)]
        _settle(images, y, axis, strip, plan, rows, asked)
    else:
        rows.flags[axis, LOST : LOST + n] = 0


@njit(cache=True, nogil=True, error_model="numpy")
def _cell_as_period(axis, k, n, rows):
    for x in range(n):
        rows.work[axis, PERIOD + x] = np.float32(rows.codes[axis, k, x])


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_alone(k, before, n, rows):
    """STATUS: what is bad, and pixels that break with all four neighbours."""
    marks, common = rows.marks, rows.common
    for x in range(n):
        apart = (marks[k, BELOW + x] != 0) & (marks[before, BELOW + x] != 0)
        apart &= (marks[k, RIGHT + x] != 0) & (marks[k, BAD + x] == DECODED)
        common[STATUS + x] = ALONE if apart else marks[k, BAD + x]
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
def _find_place(axis, n, length, extent, rows):
    """Places, and where they are beyond the monitor's border by more than noise."""
    work, common = rows.work, rows.common
    slack = FAR * length * length
    for x in range(n):
        place = length * (work[axis, PERIOD + x] + work[axis, TURN + x])
        work[axis, PLACE + x] = place
        beyond = max(-place, place - extent)
        off = (beyond > _ZERO) & (beyond * beyond > slack * work[axis, SPREAD + x])
        status = common[STATUS + x]
        common[STATUS + x] = BESIDE if (status == DECODED) & off else status


@njit(cache=True, nogil=True, error_model="numpy")
def _find_sigma(axis, bias, length, rows):
    """Standard deviations, and NaN where nothing is decoded; bias: squared turns."""
    work, common = rows.work, rows.common
    for x in range(len(bias)):
        known = common[STATUS + x] == DECODED
        spread = length * np.sqrt(work[axis, SPREAD + x] + bias[x])
        work[axis, SIGMA + x] = spread if known else _NOWHERE
        work[axis, PLACE + x] = work[axis, PLACE + x] if known else _NOWHERE


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_own(axis, n, rows):
    """Sigma becomes negative where a phase is that of one pixel."""
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
        _copy(work[PLACE : PLACE + n], location[axis, i, columns])
        _copy(work[SIGMA : SIGMA + n], sigma[axis, i, columns])
        _copy_whole(work[PERIOD : PERIOD + n], cells[axis, i, columns])
    at = STATUS + first
    _copy(rows.common[at : at + n], status[i, columns])


@njit(cache=True, nogil=True, error_model="numpy")
def place_rows(images, part, strip, plan, smooth, mark, bias, rows, out):
    """Give rows their places.

    images: (n, H, W) uint8 or uint16; part: (first, stop, place): the rows to decode,
    and the row of `out` at which the first one goes; with REACH rows before and AHEAD
    behind, or all there are, they were read (`reading.read_rows`). strip: Strip; plan:
    CodePlan; smooth, mark: average over windows, and negative sigma where a phase is
    that of one pixel; bias: `bias.squared_bias`; rows: Rows. out: location (A, h, W)
    float32, sigma alike, cells (A, h, W) int16 and status (h, W) uint8.
    """
    first, stop, place = part
    count, n, height = len(plan.bits), strip.width, images.shape[1]
    columns = slice(strip.start, strip.start + n)
    for y in range(first, stop):
        i, k = y - first + place, y % KEPT
        turn_row(y, y == first, height, smooth, strip, plan, rows)
        for axis in range(count):
            if plan.used[axis]:
                _find_period(images, y, axis, strip, plan, rows)
            else:
                _cell_as_period(axis, k, n, rows)
        _mark_alone(k, (y - 1) % KEPT, n, rows)
        for axis in range(count):
            _mark_lost(axis, n, rows)
        for axis in range(count):
            _find_place(axis, n, plan.length[axis], plan.extent[axis], rows)
        for axis in range(count):
            _find_sigma(axis, bias[axis, i // SQUARE, columns], plan.length[axis], rows)
            if mark:
                _mark_own(axis, n, rows)
        _hand_over(i, strip, rows, out)
