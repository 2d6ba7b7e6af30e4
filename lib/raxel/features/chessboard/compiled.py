"""The detector's loops over pixels, rings and edges, compiled.

Arithmetic is in float32 where the pictures are, one rounding for each operation, so
that the same picture gives the same numbers on every machine. What these functions
call, and their constants, stand in this file: compiled code is kept from run to run,
and made again when this file changes, not when another one does.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

_LITTLE, _FLATTEST = np.float32(1e-9), np.float32(-1e-6)
_ZERO, _QUARTER, _HALF = np.float32(0), np.float32(0.25), np.float32(0.5)
_ONE, _TWO = np.float32(1), np.float32(2)

# Of a trace: px of its level for each step; samples across it.
STEP = np.float32(2.0)
ACROSS, REACH = 0.6, 3
OFFSETS = (ACROSS * np.arange(-REACH - 1, REACH + 2)).astype(np.float32)
# After so many steps a trace goes on in the next halved copy.
STEPS_PER_LEVEL = 30
# An edge is lost after so many steps below this share of its usual slope.
WEAK, WEAK_STEPS = np.float32(0.22), 5
KEPT, NEW = np.float32(0.9), np.float32(0.1)
# How fast a trace turns to where its last steps have led.
MEMORY = 4
STRAIGHT, TURNING = np.float32(0.7), np.float32(0.3)


@njit(cache=True, error_model="numpy")
def grey_at(grey, u, v):
    """Grey float32 at (u, v) float32 px of a picture (h, w), bilinear.

    Beyond the picture its border goes on. Rounded as `cv2.remap` does: each of the
    three steps between two values once, as a fused multiply and add.
    """
    height, width = grey.shape
    left, top = np.floor(u), np.floor(v)
    x, y = int(left), int(top)
    right, below = x + 1, y + 1
    if x < 0 or y < 0 or right >= width or below >= height:
        x, right = _clipped(x, width), _clipped(right, width)
        y, below = _clipped(y, height), _clipped(below, height)
    a, b = u - left, v - top
    above = _between(grey[y, x], grey[y, right], a)
    under = _between(grey[below, x], grey[below, right], a)
    return _between(above, under, b)


@njit(cache=True, error_model="numpy")
def _clipped(place, size):
    return min(max(place, 0), size - 1)


@njit(cache=True, error_model="numpy")
def _between(first, second, share):
    """first + share (second - first); a product of two float32 is exact in float64."""
    step = np.float64(share) * np.float64(second - first)
    return np.float32(step + np.float64(first))


@njit(cache=True, error_model="numpy")
def strongest_saddles(grey, least):
    """Saddles of a picture (h, w) float32: (index into it (N,), strength (N,)).

    They are the pixels, two from the border or more, where xy^2 - xx yy is above
    `least` (float32) and not below that of the eight around; row by row.
    """
    height, width = grey.shape
    place = np.empty(height * width, np.int64)
    strength = np.empty(height * width, np.float32)
    three, highest = np.zeros((3, width), np.float32), np.zeros(width, np.float32)
    is_top = np.zeros(-(-width // 8) * 8, np.uint8)
    eight = is_top.view(np.uint64)
    count = 0
    for y in range(1, height - 1):
        _strength_of_row(grey[y - 1], grey[y], grey[y + 1], three[y % 3])
        if y < 3:
            continue
        here = three[(y - 1) % 3]
        for x in range(width):
            highest[x] = max(max(three[0, x], three[1, x]), three[2, x])
        for x in range(2, width - 2):
            beside = (here[x] >= highest[x - 1]) & (here[x] >= highest[x + 1])
            is_top[x] = (here[x] > least) & (here[x] >= highest[x]) & beside
        # Tops are few: eight pixels at a time are passed over.
        for k in range(len(eight)):
            if eight[k]:
                for x in range(8 * k, 8 * k + 8):
                    if is_top[x]:
                        place[count], strength[count] = (y - 1) * width + x, here[x]
                        count += 1
    return place[:count].copy(), strength[:count].copy()


@njit(cache=True, error_model="numpy")
def _strength_of_row(above, here, below, out):
    for x in range(1, len(here) - 1):
        twice = _TWO * here[x]
        xx = (here[x - 1] + here[x + 1]) - twice
        yy = (above[x] + below[x]) - twice
        xy = (below[x + 1] - below[x - 1]) - (above[x + 1] - above[x - 1])
        xy *= _QUARTER
        out[x] = xy * xy - xx * yy


@njit(cache=True, error_model="numpy")
def four_changes(grey, points, circle):
    """Which points (N, 2) px have four changes or more on a ring of whole pixels.

    circle: (M, 2) px offsets, in order; a change is one from below to above the middle
    of the ring's grey values, or back.
    """
    height, width = grey.shape
    reach = circle.max()
    changed = np.zeros(len(points), np.bool_)
    ring = np.empty(len(circle), np.float32)
    for i in range(len(points)):
        u = min(max(int(np.rint(points[i, 0])), reach), width - 1 - reach)
        v = min(max(int(np.rint(points[i, 1])), reach), height - 1 - reach)
        for k in range(len(circle)):
            ring[k] = grey[v + circle[k, 1], u + circle[k, 0]]
        middle = (ring.min() + ring.max()) * _HALF
        changes = 0
        for k in range(len(circle)):
            changes += (ring[k] > middle) != (ring[k - 1] > middle)
        changed[i] = changes >= 4
    return changed


@njit(cache=True, error_model="numpy")
def _smooth_ring(grey, u, v, offsets, out):
    """Grey values of a ring of offsets (M, 2) about (u, v) px, lightly smoothed."""
    count = len(offsets)
    raw = np.empty(count, np.float32)
    for k in range(count):
        raw[k] = grey_at(
            grey, np.float32(u + offsets[k, 0]), np.float32(v + offsets[k, 1])
        )
    for k in range(count):
        around = (_TWO * raw[k] + raw[k - 1]) + raw[(k + 1) % count]
        out[k] = around * _QUARTER


@njit(cache=True, error_model="numpy")
def _crossings(ring, low, span, least_field, opposite, angles, signs):
    """Whether four fields alternate on a ring; where and how they change.

    ring: (M,) grey values, less `low` + `span` / 2 on return. angles, signs: (4,), set
    to where the ring passes that middle, rising, and +1 where it rises, -1 where it
    falls. Every field must depart from the middle by `least_field` of the span, and
    crossings lie opposite each other within `opposite` rad.
    """
    count = len(ring)
    middle = low + span * _HALF
    for k in range(count):
        ring[k] -= middle
    reach = np.zeros(4, np.float32)
    found = 0
    for k in range(count):
        reach[found % 4] = max(reach[found % 4], abs(ring[k]))
        here, after = ring[k], ring[(k + 1) % count]
        if (here < 0) != (after < 0):
            if found < 4:
                angles[found] = (k + here / (here - after)) * (2 * np.pi / count)
                signs[found] = 1 if after > here else -1
            found += 1
    if found != 4:
        return False
    for k in range(2):
        if not abs(angles[k + 2] - angles[k] - np.pi) < opposite:
            return False
    return reach.min() > least_field * span


@njit(cache=True, error_model="numpy")
def rings_of_four(grey, points, root, rings, limits, opposite):
    """The test of `ring.ring_test`, (found, angles, signs, contrast), on given rings.

    rings: (R, M, 2) px offsets of R rings, of which the first that holds counts.
    limits (4,) float32: least span of a ring; factor of `root` and the least share of
    the span that it then has; least share of a field. opposite: rad.
    """
    least, factor, share, field = limits
    count = len(points)
    found = np.zeros(count, np.bool_)
    angles, signs = np.zeros((count, 4)), np.zeros((count, 4), np.int8)
    contrast = np.zeros(count)
    ring, here = np.empty(rings.shape[1], np.float32), np.empty(4)
    sense = np.empty(4, np.int8)
    for i in range(count):
        for offsets in rings:
            _smooth_ring(grey, points[i, 0], points[i, 1], offsets, ring)
            low = ring.min()
            span = ring.max() - low
            if not (span >= least and root[i] * factor > share * span):
                continue
            if _crossings(ring, low, span, field, opposite, here, sense):
                found[i], contrast[i] = True, span
                for k in range(4):
                    angles[i, k], signs[i, k] = here[k], sense[k]
                break
    return found, angles, signs, contrast


@njit(cache=True, error_model="numpy")
def discs(picture, place, values, offsets):
    """Set discs of offsets (M, 2) around pixels place (2, N) to values (N,).

    Offset by offset, so that of two discs the last one is on top at each offset.
    """
    height, width = picture.shape
    for k in range(len(offsets)):
        for i in range(len(values)):
            u = min(max(place[0, i] + offsets[k, 0], 0), width - 1)
            v = min(max(place[1, i] + offsets[k, 1], 0), height - 1)
            picture[v, u] = values[i]


@njit(cache=True, error_model="numpy")
def followed(atlas, points, directions, signs, usual, levels, own):
    """(corner reached (N,) or -1, direction there (N, 2)) of edges in a `trace.Atlas`.

    points (N, 2): px of their level; directions (N, 2); signs (N,): +1 where the grey
    rises clockwise, else -1; usual (N,): slope across the edge, grey levels over
    2 ACROSS; all float32. levels (N,), own (N,): the corner that each leaves.
    """
    end = np.full(len(points), -1)
    heading = directions.copy()
    for i in range(len(points)):
        end[i] = follow_edge(
            atlas, points[i], heading[i], signs[i], usual[i], levels[i], own[i]
        )
    return end, heading


@njit(cache=True, error_model="numpy")
def follow_edge(
    atlas: Any,
    start: tuple[float, float],
    d: np.ndarray,
    sign: float,
    usual: float,
    level: int,
    own: int,
) -> int:
    """Return the corner to which an edge leads, or -1.

    Parameters
    ----------
    atlas : links.Atlas
        All levels of the image.
    start : tuple[float, float]
        (u, v) px of its level at which the trace starts.
    d : np.ndarray
        (2,) float32 direction of the trace, rotated in place as the edge turns.
    sign : float
        Sign of the slope across the edge.
    usual : float
        Usual slope of the edge.
    level : int
        Level of the atlas at which the trace starts.
    own : int
        Index of the corner at which the trace starts.

    Returns
    -------
    int
        Index of a corner.
    """
    u, v = start
    past = np.empty((MEMORY, 2), np.float32)
    for k in range(MEMORY):
        past[k, 0], past[k, 1] = u, v
    rise = np.empty(2 * REACH + 1, np.float32)
    weak = 0
    for step in range(1, STEPS_PER_LEVEL * len(atlas.scale) + 1):
        u += STEP * d[0]
        v += STEP * d[1]
        _slopes(atlas, level, u, v, d, sign, rise)
        where, strength = _peak(rise)
        least = WEAK * usual
        strong = strength > least
        if strong:
            aside = ACROSS * where
            u, v = np.float32(u - d[1] * aside), np.float32(v + d[0] * aside)  # type: ignore[assignment]
            usual = KEPT * usual + NEW * strength
            weak = 0
        else:
            weak += 1
        before = past[step % MEMORY]
        if step > MEMORY:
            _turn(d, u - before[0], v - before[1], strong)
        before[0], before[1] = u, v
        inside, here = _looked_up(atlas, level, u, v)
        if inside and here >= 0 and here != own:
            return here
        flipped = not strong and -rise[1:-1].min() > _TWO * least
        if not inside or flipped or weak >= WEAK_STEPS:
            return -1
        if step % STEPS_PER_LEVEL == 0:
            if level == len(atlas.scale) - 1:
                return -1
            ratio = atlas.scale[level + 1] / atlas.scale[level]
            level += 1
            u, v = u / ratio, v / ratio
            for k in range(MEMORY):
                past[k, 0] /= ratio
                past[k, 1] /= ratio
    return -1


@njit(cache=True, error_model="numpy")
def _slopes(atlas, level, u, v, d, sign, rise):
    """Slopes of the grey values across a direction, one at each inner offset."""
    # The atlas goes on beyond the level: stay inside it.
    u = min(max(u, _ZERO), atlas.width[level] - _ONE) + atlas.left[level]
    v = min(max(v, _ZERO), atlas.height[level] - _ONE) + atlas.top[level]
    last = here = _ZERO
    for k in range(len(OFFSETS)):
        grey = grey_at(atlas.grey, u - d[1] * OFFSETS[k], v + d[0] * OFFSETS[k])
        if k > 1:
            rise[k - 2] = (grey - last) * sign
        last, here = here, grey


@njit(cache=True, error_model="numpy")
def _peak(rise):
    """(offset in samples from the middle, height) of the largest of some slopes."""
    k = rise.argmax()
    where = np.float64(k)
    if 0 < k < len(rise) - 1:
        a, b, c = rise[k - 1], rise[k], rise[k + 1]
        bend = min(a - _TWO * b + c, _FLATTEST)
        where += min(max((a - c) / (_TWO * bend), -_ONE), _ONE)
    return where - len(rise) // 2, rise[k]


@njit(cache=True, error_model="numpy")
def _turn(d, du, dv, strong):
    """Turn a direction a little towards where the trace has gone."""
    if strong:
        length = np.sqrt(du * du + dv * dv) + _LITTLE
        d[0] = STRAIGHT * d[0] + TURNING * (du / length)
        d[1] = STRAIGHT * d[1] + TURNING * (dv / length)
    length = np.sqrt(d[0] * d[0] + d[1] * d[1])
    d[0] /= length
    d[1] /= length


@njit(cache=True, error_model="numpy")
def _looked_up(atlas, level, u, v):
    """(whether (u, v) lies inside the level, the corner known there or -1)."""
    x, y = int(np.rint(u)), int(np.rint(v))
    width, height = int(atlas.width[level]), int(atlas.height[level])
    if not (0 < x < width - 1 and 0 < y < height - 1):
        return False, -1
    left, top = int(atlas.left[level]), int(atlas.top[level])
    return True, atlas.known[top + y, left + x] - 1


@njit(cache=True, error_model="numpy")
def slopes_in_windows(grey, scale, patches, half, samples):
    """Slopes (N, (2 samples + 1)^2, 2) float32 along s and t, per half window.

    Of a level's picture, at `scale` image px to one of its own, in the windows of
    `patches.Patches` of N corners: half (N, 2) their half sizes in s and t, and so many
    samples from the middle to a side.
    """
    count, side = len(half), 2 * samples + 3
    slopes = np.empty((count, (side - 2) ** 2, 2), np.float32)
    window = np.empty((side, side), np.float32)
    per_half = np.float32(samples / 2)
    for n in range(count):
        for i in range(side):
            t = half[n, 1] * ((i - samples - 1) / samples)
            for j in range(side):
                s = half[n, 0] * ((j - samples - 1) / samples)
                u = _bent(patches, n, 0, s, t) / scale
                v = _bent(patches, n, 1, s, t) / scale
                window[i, j] = _smooth_at(grey, u, v)
        for i in range(1, side - 1):
            for j in range(1, side - 1):
                k = (i - 1) * (side - 2) + j - 1
                slopes[n, k, 0] = (window[i, j + 1] - window[i, j - 1]) * per_half
                slopes[n, k, 1] = (window[i + 1, j] - window[i - 1, j]) * per_half
    return slopes


@njit(cache=True, error_model="numpy")
def _smooth_at(grey, u, v):
    """Grey at (u, v) px of a picture (h, w): its pixels, each spread as a cubic
    B-spline; beyond the picture its border goes on."""
    height, width = grey.shape
    left, top = np.floor(u), np.floor(v)
    x, y = int(left) - 1, int(top) - 1
    across, down = _spread(u - left), _spread(v - top)
    total = 0.0
    for i in range(4):
        row = _clipped(y + i, height)
        for j in range(4):
            total += down[i] * across[j] * grey[row, _clipped(x + j, width)]
    return np.float32(total)


@njit(cache=True, error_model="numpy")
def _spread(f):
    """What four pixels give to a place f px behind the second: a cubic B-spline's."""
    g = 1 - f
    inner = 2 / 3 - f * f * (1 - f / 2), 2 / 3 - g * g * (1 - g / 2)
    return g**3 / 6, inner[0], inner[1], f**3 / 6


@njit(cache=True, error_model="numpy")
def _bent(of, n, axis, s, t):
    """One coordinate of (s, t) in the patch of corner n, px of the image."""
    flat = of.p[n, axis] + s * of.u[n, axis] + t * of.v[n, axis]
    bent = flat + s * s * of.uu[n, axis] + t * t * of.vv[n, axis]
    return bent + s * t * of.w[n, axis]


@njit(cache=True, error_model="numpy")
def nearest(points, others):
    """(index of the nearest of others (M, 2), distance to it) of points (N, 2)."""
    index = np.zeros(len(points), np.int64)
    distance = np.empty(len(points))
    for n in range(len(points)):
        least = np.inf
        for m in range(len(others)):
            u, v = points[n, 0] - others[m, 0], points[n, 1] - others[m, 1]
            square = u * u + v * v
            if square < least:
                least, index[n] = square, m
        distance[n] = np.sqrt(least)
    return index, distance
