"""Saddle points of the grey levels, in an image and in its halved copies.

A corner of a chessboard is a saddle at any scale between its blur and its squares. The
halved copies contain blurred and noisy corners, at a quarter of the cost each.
"""

from typing import NamedTuple

import cv2
import numpy as np

from raxel.features.chessboard.compiled import (
    discs,
    four_changes,
    rings_of_four,
    strongest_saddles,
)

SMOOTHING_SIGMA_PX, SHARP_SIGMA_PX = 1.2, 0.7
MAX_LEVEL_PIXELS = 3_000_000
MIN_LEVEL_SIDE_PX = 60
MAX_N_LEVELS = 4
MAX_N_SADDLES = 12_000
MIN_CONTRAST_LEVELS = 6.0
MIN_STRENGTH_RATIO = 0.12
# SD of the root of the strength of saddles in noise of SD 1, after smoothing.
ROOT_NOISE_SD = 0.08
MIN_SADDLE_SIGMAS = 5.0
ROUNDING_SD = 1 / np.sqrt(12)
# Largest error of an image that is restored from its halved copy, as a fraction of its
# contrast: enlarged twice or more. Both are between percentiles.
MAX_LOST_DETAIL, DETAIL_PERCENTILES = 0.05, (0.1, 99.9)
# SD of noise of 1 after an image is halved.
HALVED_NOISE_SD = 0.3


class Level(NamedTuple):
    """A smoothed copy of the image; `scale` image px are one of its px.

    `grey` (height, width) float32; its pixel (i, j) is (scale i, scale j) of the image.
    `noise`: SD of a pixel before smoothing, in grey levels; `sigma`: of the smoothing,
    in its px.
    """

    grey: np.ndarray
    scale: int
    noise: float
    sigma: float = SMOOTHING_SIGMA_PX


class Saddles(NamedTuple):
    """Saddles of one level: positions (N, 2) in its px; root (N,) of their strength."""

    points: np.ndarray
    root: np.ndarray


def levels_of(grey, noise):
    """Levels of an image (height, width) float32 with noise of this SD, finest first.

    An image of more than MAX_LEVEL_PIXELS starts with a halved copy.
    """
    scale, levels = 1, []
    while True:
        if grey.size <= MAX_LEVEL_PIXELS:
            soft = cv2.GaussianBlur(grey, (0, 0), SMOOTHING_SIGMA_PX)
            levels.append(Level(soft, scale, noise))
        if len(levels) == MAX_N_LEVELS or min(grey.shape) < 2 * MIN_LEVEL_SIDE_PX:
            return levels or [Level(grey, scale, noise)]
        grey, scale, noise = cv2.pyrDown(grey), 2 * scale, HALVED_NOISE_SD * noise


def sharp_level(grey, noise):
    """The image itself as a Level, with little smoothing."""
    soft = cv2.GaussianBlur(grey, (0, 0), SHARP_SIGMA_PX)
    return Level(soft, 1, noise, SHARP_SIGMA_PX)


def halved(image):
    """The image (height, width) at half its scale, or None where detail would be lost.

    An image without detail at the scale of its pixels is restored from its halved copy.
    Its largest error is a fraction of its contrast; sharp edges have a tenth and more.
    """
    height, width = (n // 2 * 2 for n in image.shape)
    if min(height, width) < 2 * MIN_LEVEL_SIDE_PX:
        return None
    image = image[:height, :width]
    half = cv2.resize(image, (width // 2, height // 2), interpolation=cv2.INTER_AREA)
    restored = cv2.resize(half, (width, height), interpolation=cv2.INTER_CUBIC)
    error = np.percentile(cv2.absdiff(image, restored), DETAIL_PERCENTILES[1])
    contrast = np.subtract(*np.percentile(image, DETAIL_PERCENTILES[::-1]))
    return half if error < MAX_LOST_DETAIL * contrast else None


def noise_sd(grey):
    """SD of the noise: the median of a filter that edges hardly affect.

    At least that of rounding to integer grey levels, since smooth and clipped images,
    where most pixels equal their neighbours, are not free of it.
    """
    rows = max(1, len(grey) // 400)
    kernel = np.array([[1, -2, 1], [-2, 4, -2], [1, -2, 1]], np.float32)
    band = np.concatenate([grey[k : k + 3] for k in range(0, len(grey) - 2, 3 * rows)])
    moved = np.abs(cv2.filter2D(band, -1, kernel)[1::3])
    return max(float(np.median(moved)) / (6 * 0.6745), ROUNDING_SD)


def saddles_of(level):
    """Saddles of a Level above its noise, the strongest first."""
    min_strength = (
        MIN_STRENGTH_RATIO * MIN_CONTRAST_LEVELS / (np.pi * SMOOTHING_SIGMA_PX**2)
    )
    min_strength = (
        max(min_strength, MIN_SADDLE_SIGMAS * ROOT_NOISE_SD * level.noise) ** 2
    )
    index, s = strongest_saddles(level.grey, np.float32(min_strength))
    if len(index) > MAX_N_SADDLES:
        keep = np.argpartition(-s, MAX_N_SADDLES)[:MAX_N_SADDLES]
        index, s = index[keep], s[keep]
    order = np.argsort(-s, kind="stable")
    index, s = index[order], s[order]
    return Saddles(_stationary(level.grey, index, s), np.sqrt(s))


def _stationary(grey, index, strength):
    """Positions (N, 2) where the gradient vanishes near the pixels `index`."""
    width, flat = grey.shape[1], grey.ravel()
    centre, left, right = flat[index], flat[index - 1], flat[index + 1]
    above, below = flat[index - width], flat[index + width]
    gx, gy = (right - left) / 2, (below - above) / 2
    xx, yy = (left + right) - 2 * centre, (above + below) - 2 * centre
    xy = flat[index + width + 1] - flat[index + width - 1]
    xy = (xy - (flat[index - width + 1] - flat[index - width - 1])) / 4
    du = (yy * gx - xy * gy) / strength
    dv = (xx * gy - xy * gx) / strength
    v, u = np.divmod(index, width)
    return np.column_stack([u + np.clip(du, -1, 1), v + np.clip(dv, -1, 1)])


# The ring test. Around a corner the grey levels alternate: dark, bright, dark, bright.
# The test selects the saddles with four squares, and measures the directions of the
# four edges between them.


RING_RADII_PX = (3.0, 4.5)
N_RING_SAMPLES = 32
MIN_SECTOR_DEPTH = 0.22
MAX_OPPOSITE_ANGLE_RAD = np.radians(35)
MIN_RING_SIGMAS = 4.0
# SD of white noise of SD 1 after smoothing by SMOOTHING_SIGMA_PX.
SMOOTHED_NOISE_SD = 0.24
# Smallest distance of two corners of one level, in its px.
MIN_NODE_SPACING_PX = 3.0
# Integer pixels at a distance of about 3 px, in order.
CIRCLE_OFFSETS_PX = np.array(
    [(3, 0), (3, 1), (2, 2), (1, 3), (0, 3), (-1, 3), (-2, 2), (-3, 1)]
    + [(-3, 0), (-3, -1), (-2, -2), (-1, -3), (0, -3), (1, -3), (2, -2), (3, -1)]
)


class Nodes(NamedTuple):
    """Corners of four squares, in image px.

    points (N, 2); angles (N, 4) of the edges, increasing, so clockwise in the image;
    signs (N, 4): +1 where the grey level rises with the angle; contrast (N,); level
    (N,): index of the level that contains them.
    """

    points: np.ndarray
    angles: np.ndarray
    signs: np.ndarray
    contrast: np.ndarray
    level: np.ndarray


def nodes_of(level, saddles, number):
    """The Nodes among the Saddles of a Level with this index."""
    candidates = four_changes(level.grey, saddles.points, CIRCLE_OFFSETS_PX)
    points, root = saddles.points[candidates], saddles.root[candidates]
    found, angles, signs, contrast = ring_test(level, points, root, RING_RADII_PX)
    return Nodes(
        points[found] * level.scale,
        angles[found],
        signs[found],
        contrast[found],
        np.full(np.count_nonzero(found), number),
    )


def ring_test(level, points, root, radii):
    """(found (N,), angles (N, 4), signs (N, 4), contrast (N,)) of the ring test.

    From the first radius at which the test succeeds. points: (N, 2) px of the level;
    root: (N,) of the saddle's strength, see `Saddles`.
    """
    turn = 2 * np.pi * np.arange(N_RING_SAMPLES) / N_RING_SAMPLES
    circle = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    rings = np.multiply.outer(radii, circle)
    min_span = max(
        MIN_CONTRAST_LEVELS, MIN_RING_SIGMAS * SMOOTHED_NOISE_SD * level.noise
    )
    limits = (
        min_span,
        np.pi * SMOOTHING_SIGMA_PX**2,
        MIN_STRENGTH_RATIO,
        MIN_SECTOR_DEPTH,
    )
    limits = np.array(limits, np.float32)
    return rings_of_four(
        level.grey, points, root, rings, limits, MAX_OPPOSITE_ANGLE_RAD
    )


# cv2.INTER_LINEAR
LINEAR = 1


def remapped(grey, u, v, border, interpolation=LINEAR):
    """Grey levels at (u, v), of any shape with two axes, interpolated."""
    rows = 32_000
    parts = [
        cv2.remap(
            grey, u[k : k + rows], v[k : k + rows], interpolation, borderMode=border
        )
        for k in range(0, len(u), rows)
    ]
    return parts[0] if len(parts) == 1 else np.concatenate(parts)


def merge_nodes(parts, levels):
    """Nodes of several levels as one; a corner in several is taken from the finest.

    parts: list of Nodes, as `levels`, the finest first and the strongest of each first.
    """
    kept = parts[0]
    for number, (nodes, level) in enumerate(zip(parts, levels, strict=True)):
        shape = level.grey.shape
        taken = np.zeros(shape, np.int32)
        if number:
            paint_discs(
                taken,
                pixels_of(kept.points / level.scale, shape),
                -1,
                MIN_NODE_SPACING_PX,
            )
        pixels = pixels_of(nodes.points / level.scale, shape)
        free = taken[pixels[1], pixels[0]] == 0
        rank = np.arange(1, len(free) + 1)
        paint_discs(
            taken, pixels[:, free][:, ::-1], rank[free][::-1], MIN_NODE_SPACING_PX
        )
        alone = free & (taken[pixels[1], pixels[0]] == rank)
        nodes = Nodes(*(array[alone] for array in nodes))
        both = zip(kept, nodes, strict=True)
        kept = Nodes(*map(np.concatenate, both)) if number else nodes
    return kept


def pixels_of(points, shape):
    """Nearest pixels (2, N) of points (N, 2) inside an image of this shape."""
    pixels = np.rint(points).astype(int).T
    return np.clip(pixels, 0, np.array([[shape[1] - 1], [shape[0] - 1]]))


def paint_discs(image, pixels, values, radius):
    """Set discs around pixels (2, N) to values (N,), later ones on top."""
    r = int(radius)
    y, x = np.mgrid[-r : r + 1, -r : r + 1]
    inside = np.hypot(x, y) <= radius
    offsets = np.stack([x[inside], y[inside]], axis=1)
    discs(image, pixels, np.broadcast_to(values, pixels.shape[1:]), offsets)
