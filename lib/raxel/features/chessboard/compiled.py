"""The detector's loops over pixels, rings and edges, compiled.

Arithmetic is in float32 where images are, with one rounding for each operation, so that
an image gives the same numbers on every machine. All functions and constants that these
functions use are in this file: compiled code is cached between runs and recompiled when
this file changes, not when another one does.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

_MIN_LENGTH, _MAX_PEAK_CURVATURE = np.float32(1e-9), np.float32(-1e-6)
_ZERO, _QUARTER, _HALF = np.float32(0), np.float32(0.25), np.float32(0.5)
_ONE, _TWO = np.float32(1), np.float32(2)

# Trace: step in px of its level; pitch in px and number of samples to each side.
TRACE_STEP_PX = np.float32(2.0)
SAMPLE_PITCH_PX, N_SIDE_SAMPLES = 0.6, 3
SAMPLE_OFFSETS_PX = (
    SAMPLE_PITCH_PX * np.arange(-N_SIDE_SAMPLES - 1, N_SIDE_SAMPLES + 2)
).astype(np.float32)
# After so many steps a trace continues in the next halved copy.
STEPS_PER_LEVEL = 30
# An edge is lost after so many steps below this fraction of its usual slope.
MIN_SLOPE_RATIO, MAX_WEAK_STEPS = np.float32(0.22), 5
OLD_SLOPE_WEIGHT, NEW_SLOPE_WEIGHT = np.float32(0.9), np.float32(0.1)
# Memory of the direction of a trace, in steps, and weights of its old and its new
# direction.
N_PAST_POINTS = 4
OLD_DIRECTION_WEIGHT, NEW_DIRECTION_WEIGHT = np.float32(0.7), np.float32(0.3)


@njit(cache=True, error_model="numpy")
def grey_at(grey, u, v):
    """Grey float32 at (u, v) float32 px of an image (h, w), bilinear.

    Outside the image its border continues. Rounded as in `cv2.remap`: each of the three
    interpolations between two values once, as a fused multiply-add.
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
def _clipped(index, size):
    return min(max(index, 0), size - 1)


@njit(cache=True, error_model="numpy")
def _between(first, second, share):
    """first + share (second - first); a product of two float32 is exact in float64."""
    step = np.float64(share) * np.float64(second - first)
    return np.float32(step + np.float64(first))


@njit(cache=True, error_model="numpy")
def strongest_saddles(grey, min_strength):
    """Saddles of an image (h, w) float32: (index into it (N,), strength (N,)).

    These are the pixels, two from the border or more, where xy^2 - xx yy is above
    `min_strength` (float32) and not below that of the eight neighbours; row by row.
    """
    height, width = grey.shape
    index = np.empty(height * width, np.int64)
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
            is_row_top = (here[x] >= highest[x - 1]) & (here[x] >= highest[x + 1])
            is_top[x] = (here[x] > min_strength) & (here[x] >= highest[x]) & is_row_top
        # Maxima are sparse: eight pixels are tested at a time.
        for k in range(len(eight)):
            if eight[k]:
                for x in range(8 * k, 8 * k + 8):
                    if is_top[x]:
                        index[count], strength[count] = (y - 1) * width + x, here[x]
                        count += 1
    return index[:count].copy(), strength[:count].copy()


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
    """Which points (N, 2) px have four changes or more on a ring of integer pixels.

    circle: (M, 2) px offsets, in order; a change is a transition across the mid-level
    of the ring's grey levels.
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
    """Whether four sectors alternate on a ring; where and how they change.

    ring: (M,) grey levels, less `low` + `span` / 2 on return. angles, signs: (4,), set
    to the angles at which the ring crosses that level, increasing, and +1 where it
    rises, -1 where it falls. Every sector must depart from the level by `least_field`
    of the span, and crossings must be opposite each other within `opposite` rad.
    """
    count = len(ring)
    middle = low + span * _HALF
    for k in range(count):
        ring[k] -= middle
    reach = np.zeros(4, np.float32)
    found = 0
    for k in range(count):
        reach[found % 4] = max(reach[found % 4], abs(ring[k]))
        value, after = ring[k], ring[(k + 1) % count]
        if (value < 0) != (after < 0):
            if found < 4:
                angles[found] = (k + value / (value - after)) * (2 * np.pi / count)
                signs[found] = 1 if after > value else -1
            found += 1
    if found != 4:
        return False
    for k in range(2):
        if not abs(angles[k + 2] - angles[k] - np.pi) < opposite:
            return False
    return reach.min() > least_field * span


@njit(cache=True, error_model="numpy")
def rings_of_four(grey, points, root, rings, limits, opposite):
    """The test of `saddles.ring_test` on given rings: found, angles, signs, contrast.

    rings: (R, M, 2) px offsets of R rings, of which the first that succeeds counts.
    limits (4,) float32: smallest span of a ring; factor of `root` and the smallest
    fraction of the span for it; smallest fraction of a sector. opposite: rad.
    """
    min_span, factor, share, field = limits
    count = len(points)
    found = np.zeros(count, np.bool_)
    angles, signs = np.zeros((count, 4)), np.zeros((count, 4), np.int8)
    contrast = np.zeros(count)
    ring, crossings = np.empty(rings.shape[1], np.float32), np.empty(4)
    sense = np.empty(4, np.int8)
    for i in range(count):
        for offsets in rings:
            _smooth_ring(grey, points[i, 0], points[i, 1], offsets, ring)
            low = ring.min()
            span = ring.max() - low
            if not (span >= min_span and root[i] * factor > share * span):
                continue
            if _crossings(ring, low, span, field, opposite, crossings, sense):
                found[i], contrast[i] = True, span
                for k in range(4):
                    angles[i, k], signs[i, k] = crossings[k], sense[k]
                break
    return found, angles, signs, contrast


@njit(cache=True, error_model="numpy")
def discs(image, pixels, values, offsets):
    """Set discs of offsets (M, 2) around pixels (2, N) to values (N,).

    Offset by offset, so that of two discs the later one is on top at each offset.
    """
    height, width = image.shape
    for k in range(len(offsets)):
        for i in range(len(values)):
            u = min(max(pixels[0, i] + offsets[k, 0], 0), width - 1)
            v = min(max(pixels[1, i] + offsets[k, 1], 0), height - 1)
            image[v, u] = values[i]


@njit(cache=True, error_model="numpy")
def followed(atlas, points, directions, signs, usual, levels, own):
    """(corner reached (N,) or -1, direction there (N, 2)) of edges in a `links.Atlas`.

    points (N, 2): px of their level; directions (N, 2); signs (N,): +1 where the grey
    level rises clockwise, else -1; usual (N,): slope across the edge, grey levels over
    2 SAMPLE_PITCH_PX; all float32. levels (N,), own (N,): the corner that each leaves.
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
    past = np.empty((N_PAST_POINTS, 2), np.float32)
    for k in range(N_PAST_POINTS):
        past[k, 0], past[k, 1] = u, v
    rise = np.empty(2 * N_SIDE_SAMPLES + 1, np.float32)
    weak = 0
    for step in range(1, STEPS_PER_LEVEL * len(atlas.scale) + 1):
        u += TRACE_STEP_PX * d[0]
        v += TRACE_STEP_PX * d[1]
        _slopes(atlas, level, u, v, d, sign, rise)
        where, strength = _peak(rise)
        min_strength = MIN_SLOPE_RATIO * usual
        strong = strength > min_strength
        if strong:
            offset = SAMPLE_PITCH_PX * where
            u, v = np.float32(u - d[1] * offset), np.float32(v + d[0] * offset)  # type: ignore[assignment]
            usual = OLD_SLOPE_WEIGHT * usual + NEW_SLOPE_WEIGHT * strength
            weak = 0
        else:
            weak += 1
        before = past[step % N_PAST_POINTS]
        if step > N_PAST_POINTS:
            _turn(d, u - before[0], v - before[1], strong)
        before[0], before[1] = u, v
        inside, corner = _looked_up(atlas, level, u, v)
        if inside and corner >= 0 and corner != own:
            return corner
        flipped = not strong and -rise[1:-1].min() > _TWO * min_strength
        if not inside or flipped or weak >= MAX_WEAK_STEPS:
            return -1
        if step % STEPS_PER_LEVEL == 0:
            if level == len(atlas.scale) - 1:
                return -1
            ratio = atlas.scale[level + 1] / atlas.scale[level]
            level += 1
            u, v = u / ratio, v / ratio
            for k in range(N_PAST_POINTS):
                past[k, 0] /= ratio
                past[k, 1] /= ratio
    return -1


@njit(cache=True, error_model="numpy")
def _slopes(atlas, level, u, v, d, sign, rise):
    """Slopes of the grey values across a direction, one at each inner offset."""
    # The atlas continues outside the level: stay inside the level.
    u = min(max(u, _ZERO), atlas.width[level] - _ONE) + atlas.left[level]
    v = min(max(v, _ZERO), atlas.height[level] - _ONE) + atlas.top[level]
    before_previous = previous = _ZERO
    for k in range(len(SAMPLE_OFFSETS_PX)):
        grey = grey_at(
            atlas.grey, u - d[1] * SAMPLE_OFFSETS_PX[k], v + d[0] * SAMPLE_OFFSETS_PX[k]
        )
        if k > 1:
            rise[k - 2] = (grey - before_previous) * sign
        before_previous, previous = previous, grey


@njit(cache=True, error_model="numpy")
def _peak(rise):
    """(offset in samples from the middle, height) of the largest of some slopes."""
    k = rise.argmax()
    where = np.float64(k)
    if 0 < k < len(rise) - 1:
        a, b, c = rise[k - 1], rise[k], rise[k + 1]
        bend = min(a - _TWO * b + c, _MAX_PEAK_CURVATURE)
        where += min(max((a - c) / (_TWO * bend), -_ONE), _ONE)
    return where - len(rise) // 2, rise[k]


@njit(cache=True, error_model="numpy")
def _turn(d, du, dv, strong):
    """Turn a direction a little towards the recent direction of the trace."""
    if strong:
        length = np.sqrt(du * du + dv * dv) + _MIN_LENGTH
        d[0] = OLD_DIRECTION_WEIGHT * d[0] + NEW_DIRECTION_WEIGHT * (du / length)
        d[1] = OLD_DIRECTION_WEIGHT * d[1] + NEW_DIRECTION_WEIGHT * (dv / length)
    length = np.sqrt(d[0] * d[0] + d[1] * d[1])
    d[0] /= length
    d[1] /= length


@njit(cache=True, error_model="numpy")
def _looked_up(atlas, level, u, v):
    """(whether (u, v) is inside the level, the corner known there or -1)."""
    x, y = int(np.rint(u)), int(np.rint(v))
    width, height = int(atlas.width[level]), int(atlas.height[level])
    if not (0 < x < width - 1 and 0 < y < height - 1):
        return False, -1
    left, top = int(atlas.left[level]), int(atlas.top[level])
    return True, atlas.known[top + y, left + x] - 1


@njit(cache=True, error_model="numpy")
def slopes_in_windows(grey, scale, patches, half, samples):
    """Gradients (N, (2 samples + 1)^2, 2) float32 along s and t, per half window.

    In a level's image, at `scale` image px to one of its own, in the windows of
    `grids.Patches` of N corners: half (N, 2) their half sizes in s and t, and the
    number of samples from the centre to a side.
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
    """Grey at (u, v) px of an image (h, w), by cubic B-splines.

    Outside the image its border continues.
    """
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
    """Weights of four pixels at f px behind the second: those of a cubic B-spline."""
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
        min_square = np.inf
        for m in range(len(others)):
            u, v = points[n, 0] - others[m, 0], points[n, 1] - others[m, 1]
            square = u * u + v * v
            if square < min_square:
                min_square, index[n] = square, m
        distance[n] = np.sqrt(min_square)
    return index, distance
