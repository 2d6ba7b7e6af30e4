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
    from raxel.features.find.compiled import four_changes

    some = four_changes(level.grey, saddles.points, CIRCLE)
    points, root = saddles.points[some], saddles.root[some]
    found, angles, signs, contrast = ring_test(level, points, root, RADII)
    return Nodes(
        points[found] * level.scale,
        angles[found],
        signs[found],
        contrast[found],
        np.full(np.count_nonzero(found), number),
    )


def ring_test(level, points, root, radii):
    """(found (N,), angles (N, 4), signs (N, 4), contrast (N,)).

    They are those of the first radius at which the test holds. points: (N, 2) px of the
    level; root: (N,) of the saddle's strength, see `saddles`.
    """
    from raxel.features.find.compiled import rings_of_four

    turn = 2 * np.pi * np.arange(SAMPLES) / SAMPLES
    circle = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    rings = np.multiply.outer(radii, circle)
    least = max(LEAST_CONTRAST, NOISE_SD * SMOOTHED_NOISE * level.noise)
    limits = least, np.pi * SIGMA**2, LEAST_STRENGTH, LEAST_FIELD
    limits = np.array(limits, np.float32)
    return rings_of_four(level.grey, points, root, rings, limits, OPPOSITE)


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
    from raxel.features.find.compiled import discs

    r = int(radius)
    y, x = np.mgrid[-r : r + 1, -r : r + 1]
    inside = np.hypot(x, y) <= radius
    offsets = np.stack([x[inside], y[inside]], axis=1)
    discs(picture, place, np.broadcast_to(values, place.shape[1:]), offsets)
