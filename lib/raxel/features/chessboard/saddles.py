"""Where the grey values have a saddle, in an image and in its halved copies.

A corner of a chessboard is a saddle at any scale between its blur and its squares. The
halved copies find blurred and noisy corners, at a quarter of the time each.
"""

from typing import NamedTuple

import numpy as np

SIGMA, SHARP_SIGMA = 1.2, 0.7
MOST_PIXELS = 3_000_000
SMALLEST_SIDE = 60
MOST_LEVELS = 4
MOST_SADDLES = 12_000
LEAST_CONTRAST = 6.0
LEAST_STRENGTH = 0.12
# A saddle in noise of SD 1, smoothed by SIGMA: SD of the root of its strength.
NOISE_OF_ROOT = 0.08
NOISE_SD = 5.0
ROUNDING_SD = 1 / np.sqrt(12)
# SD of noise that is left of 1 when a picture is halved.
HALVED_NOISE = 0.3


class Level(NamedTuple):
    """A copy of the image, smoothed: `scale` image px are one of its px.

    `grey` (height, width) float32; pixel (i, j) of it is (scale i, scale j) of the
    image. `noise`: SD of a pixel before it was smoothed, in grey levels; `sigma`: of
    the smoothing, its px.
    """

    grey: np.ndarray
    scale: int
    noise: float
    sigma: float = SIGMA


class Saddles(NamedTuple):
    """Saddles of one level: positions (N, 2) in its px; root (N,) of their strength."""

    points: np.ndarray
    root: np.ndarray


def levels_of(grey, noise):
    """Levels of an image (height, width) float32 with noise of this SD, finest first.

    An image of more than MOST_PIXELS starts with a halved copy.
    """
    import cv2

    scale, levels = 1, []
    while True:
        if grey.size <= MOST_PIXELS:
            soft = cv2.GaussianBlur(grey, (0, 0), SIGMA)
            levels.append(Level(soft, scale, noise))
        if len(levels) == MOST_LEVELS or min(grey.shape) < 2 * SMALLEST_SIDE:
            return levels or [Level(grey, scale, noise)]
        grey, scale, noise = cv2.pyrDown(grey), 2 * scale, HALVED_NOISE * noise


def sharp_level(grey, noise):
    """The image itself as a Level, with next to no smoothing."""
    import cv2

    soft = cv2.GaussianBlur(grey, (0, 0), SHARP_SIGMA)
    return Level(soft, 1, noise, SHARP_SIGMA)


def noise_sd(grey):
    """SD of the noise: the median of a filter that edges hardly move.

    That of rounding to whole grey levels at least: smooth and clipped pictures, where
    most pixels are as their neighbours, are not free of it.
    """
    import cv2

    rows = max(1, len(grey) // 400)
    kernel = np.array([[1, -2, 1], [-2, 4, -2], [1, -2, 1]], np.float32)
    band = np.concatenate([grey[k : k + 3] for k in range(0, len(grey) - 2, 3 * rows)])
    moved = np.abs(cv2.filter2D(band, -1, kernel)[1::3])
    return max(float(np.median(moved)) / (6 * 0.6745), ROUNDING_SD)


def saddles_of(level):
    """Saddles of a Level that stand out from its noise, the strongest first."""
    from raxel.features.chessboard.compiled import strongest_saddles

    least = LEAST_STRENGTH * LEAST_CONTRAST / (np.pi * SIGMA**2)
    least = max(least, NOISE_SD * NOISE_OF_ROOT * level.noise) ** 2
    place, s = strongest_saddles(level.grey, np.float32(least))
    if len(place) > MOST_SADDLES:
        keep = np.argpartition(-s, MOST_SADDLES)[:MOST_SADDLES]
        place, s = place[keep], s[keep]
    order = np.argsort(-s, kind="stable")
    place, s = place[order], s[order]
    return Saddles(_stationary(level.grey, place, s), np.sqrt(s))


def _stationary(grey, place, strength):
    """Where the gradient vanishes near pixels `place`, (N, 2); within a pixel."""
    width, flat = grey.shape[1], grey.ravel()
    here, left, right = flat[place], flat[place - 1], flat[place + 1]
    above, below = flat[place - width], flat[place + width]
    gx, gy = (right - left) / 2, (below - above) / 2
    xx, yy = (left + right) - 2 * here, (above + below) - 2 * here
    xy = flat[place + width + 1] - flat[place + width - 1]
    xy = (xy - (flat[place - width + 1] - flat[place - width - 1])) / 4
    du = (yy * gx - xy * gy) / strength
    dv = (xx * gy - xy * gx) / strength
    v, u = np.divmod(place, width)
    return np.column_stack([u + np.clip(du, -1, 1), v + np.clip(dv, -1, 1)])


# The ring test: around a corner the grey goes dark, bright, dark, bright. It says
# which saddles are corners of four fields, and in which directions the four edges
# between them leave.


RADII = (3.0, 4.5)
SAMPLES = 32
LEAST_FIELD = 0.22
OPPOSITE = np.radians(35)
RING_NOISE_SD = 4.0
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
    from raxel.features.chessboard.compiled import four_changes

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
    from raxel.features.chessboard.compiled import rings_of_four

    turn = 2 * np.pi * np.arange(SAMPLES) / SAMPLES
    circle = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    rings = np.multiply.outer(radii, circle)
    least = max(LEAST_CONTRAST, RING_NOISE_SD * SMOOTHED_NOISE * level.noise)
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
    from raxel.features.chessboard.compiled import discs

    r = int(radius)
    y, x = np.mgrid[-r : r + 1, -r : r + 1]
    inside = np.hypot(x, y) <= radius
    offsets = np.stack([x[inside], y[inside]], axis=1)
    discs(picture, place, np.broadcast_to(values, place.shape[1:]), offsets)
