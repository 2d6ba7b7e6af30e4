"""The ring test: around a corner the grey goes dark, bright, dark, bright.

It says which saddles are corners of four fields, and in which directions the four edges
between them leave.
"""

from typing import NamedTuple

import numpy as np

from raxel.features.find.saddles import LEAST_CONTRAST, LEAST_STRENGTH, SIGMA

RADII = (3.0, 4.5)
SAMPLES = 32
LEAST_FIELD = 0.22
OPPOSITE = np.radians(35)
NOISE_SD = 4.0
# SD of white noise of 1 after smoothing by SIGMA.
SMOOTHED_NOISE = 0.24
# Two corners of one level are this many of its px apart, or more.
APART = 3.0
# Whole pixels about 3 from the middle, in order.
CIRCLE = np.array(
    [(3, 0), (3, 1), (2, 2), (1, 3), (0, 3), (-1, 3), (-2, 2), (-3, 1)]
    + [(-3, 0), (-3, -1), (-2, -2), (-1, -3), (0, -3), (1, -3), (2, -2), (3, -1)]
)


class Nodes(NamedTuple):
    """Corners of four fields, in image px.

    points (N, 2); angles (N, 4) at which the edges leave, rising, so clockwise as
    seen; signs (N, 4): +1 where the grey rises with the angle there; contrast (N,);
    level (N,) index of the level that shows them.
    """

    points: np.ndarray
    angles: np.ndarray
    signs: np.ndarray
    contrast: np.ndarray
    level: np.ndarray


def nodes_of(level, saddles, number):
    """The Nodes among the Saddles of a Level, which has this number."""
    some = _maybe(level.grey, saddles.points)
    points, root = saddles.points[some], saddles.root[some]
    found, angles, signs, contrast = ring_test(level, points, root, RADII)
    return Nodes(
        points[found] * level.scale,
        angles[found],
        signs[found],
        contrast[found],
        np.full(np.count_nonzero(found), number),
    )


def _maybe(grey, points):
    """Which points (N, 2) have four changes or more on a ring of whole pixels."""
    u, v = pixels_of(points, grey.shape)
    height, width = grey.shape
    u, v = np.clip(u, 3, width - 4), np.clip(v, 3, height - 4)
    ring = grey.ravel()[
        (v * width + u)[:, None] + (CIRCLE[:, 1] * width + CIRCLE[:, 0])
    ]
    middle = (ring.min(axis=1) + ring.max(axis=1)) / 2
    bright = ring > middle[:, None]
    return (bright != np.roll(bright, 1, axis=1)).sum(axis=1) >= 4


def ring_test(level, points, root, radii):
    """(found (N,), angles (N, 4), signs (N, 4), contrast (N,)).

    They are those of the first radius at which the test holds. points: (N, 2) px of the
    level; root: (N,) of the saddle's strength, see `saddles`.
    """
    count = len(points)
    found = np.zeros(count, bool)
    angles, signs = np.zeros((count, 4)), np.zeros((count, 4), np.int8)
    contrast = np.zeros(count)
    least = max(LEAST_CONTRAST, NOISE_SD * SMOOTHED_NOISE * level.noise)
    for radius in radii:
        left = np.flatnonzero(~found)
        if not len(left):
            break
        ring = _ring(level.grey, points[left], radius)
        low, high = ring.min(axis=1), ring.max(axis=1)
        span = high - low
        strong = root[left] * (np.pi * SIGMA**2) > LEAST_STRENGTH * span
        good = (span >= least) & strong
        left, ring, low, span = left[good], ring[good], low[good], span[good]
        ok, a, s = _crossings(ring - (low + span / 2)[:, None], span)
        chosen = left[ok]
        found[chosen] = True
        angles[chosen], signs[chosen] = a[ok], s[ok]
        contrast[chosen] = span[ok]
    return found, angles, signs, contrast


def _ring(grey, points, radius):
    """Grey (N, SAMPLES) around points, clockwise as seen; 0 beyond the image."""
    import cv2

    turn = 2 * np.pi * np.arange(SAMPLES) / SAMPLES
    u = (points[:, :1] + radius * np.cos(turn)).astype(np.float32)
    v = (points[:, 1:] + radius * np.sin(turn)).astype(np.float32)
    ring = remapped(grey, u, v, cv2.BORDER_REPLICATE)
    return (2 * ring + np.roll(ring, 1, axis=1) + np.roll(ring, -1, axis=1)) / 4


def remapped(grey, u, v, border):
    """Grey values at (u, v), of any shape with two axes, linear between pixels."""
    import cv2

    rows = 32_000
    if len(u) < rows:
        return cv2.remap(grey, u, v, cv2.INTER_LINEAR, borderMode=border)
    parts = [
        cv2.remap(
            grey, u[k : k + rows], v[k : k + rows], cv2.INTER_LINEAR, borderMode=border
        )
        for k in range(0, len(u), rows)
    ]
    return np.concatenate(parts)


def _crossings(ring, span):
    """(good (N,), angles (N, 4), signs (N, 4)) of rings less their middle level."""
    count = len(ring)
    after = np.roll(ring, -1, axis=1)
    crossed = (ring < 0) != (after < 0)
    good = crossed.sum(axis=1) == 4
    angles, signs = np.zeros((count, 4)), np.zeros((count, 4), np.int8)
    if not good.any():
        return good, angles, signs
    place = np.nonzero(crossed[good])[1].reshape(-1, 4)
    a = np.take_along_axis(ring[good], place, axis=1)
    b = np.take_along_axis(after[good], place, axis=1)
    where = (place + a / (a - b)) * (2 * np.pi / SAMPLES)
    angles[good], signs[good] = where, np.where(b > a, 1, -1)
    opposite = np.abs(where[:, 2:] - where[:, :2] - np.pi) < OPPOSITE
    reach = _field_extremes(ring[good], place) > LEAST_FIELD * span[good][:, None]
    good[good] = opposite.all(axis=1) & reach.all(axis=1)
    return good, angles, signs


def _field_extremes(ring, place):
    """How far each of the four fields between crossings departs from the middle."""
    index = np.arange(SAMPLES)
    field = (index[None, :, None] > place[:, None, :]).sum(axis=2) % 4
    size = np.abs(ring)
    return np.stack(
        [np.where(field == k, size, 0).max(axis=1) for k in range(4)], axis=1
    )


def joined(parts, levels):
    """Nodes of several levels as one, a corner seen at several kept as the finest.

    parts: list of Nodes, as `levels`, the finest first and the strongest of each first.
    """
    kept = parts[0]
    for number, (nodes, level) in enumerate(zip(parts, levels, strict=True)):
        shape = level.grey.shape
        taken = np.zeros(shape, np.int32)
        if number:
            paint(taken, pixels_of(kept.points / level.scale, shape), -1, APART)
        place = pixels_of(nodes.points / level.scale, shape)
        free = taken[place[1], place[0]] == 0
        rank = np.arange(1, len(free) + 1)
        paint(taken, place[:, free][:, ::-1], rank[free][::-1], APART)
        alone = free & (taken[place[1], place[0]] == rank)
        nodes = Nodes(*(array[alone] for array in nodes))
        both = zip(kept, nodes, strict=True)
        kept = Nodes(*map(np.concatenate, both)) if number else nodes
    return kept


def pixels_of(points, shape):
    """Nearest pixels (2, N) of points (N, 2) inside an image of this shape."""
    place = np.rint(points).astype(int).T
    return np.clip(place, 0, np.array([[shape[1] - 1], [shape[0] - 1]]))


def paint(picture, place, values, radius):
    """Set discs around pixels (2, N) to values (N,), the last ones on top."""
    height, width = picture.shape
    r = int(radius)
    y, x = np.mgrid[-r : r + 1, -r : r + 1]
    inside = np.hypot(x, y) <= radius
    for dx, dy in zip(x[inside], y[inside], strict=True):
        u = np.clip(place[0] + dx, 0, width - 1)
        v = np.clip(place[1] + dy, 0, height - 1)
        picture[v, u] = values
