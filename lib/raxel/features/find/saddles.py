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


def levels_of(image):
    """Levels of a grey image (height, width), the finest first.

    An image of more than MOST_PIXELS starts with a halved copy.
    """
    import cv2

    grey = image.astype(np.float32)
    noise, scale, levels = noise_sd(grey), 1, []
    while True:
        if grey.size <= MOST_PIXELS:
            soft = cv2.GaussianBlur(grey, (0, 0), SIGMA)
            levels.append(Level(soft, scale, noise))
        if len(levels) == MOST_LEVELS or min(grey.shape) < 2 * SMALLEST_SIDE:
            return levels or [Level(grey, scale, noise)]
        grey, scale, noise = cv2.pyrDown(grey), 2 * scale, HALVED_NOISE * noise


def sharp_level(image):
    """The image itself as a Level, with next to no smoothing."""
    import cv2

    grey = image.astype(np.float32)
    soft = cv2.GaussianBlur(grey, (0, 0), SHARP_SIGMA)
    return Level(soft, 1, noise_sd(grey), SHARP_SIGMA)


def noise_sd(grey):
    """SD of the noise: the median of a filter that edges hardly move."""
    import cv2

    rows = max(1, len(grey) // 400)
    kernel = np.array([[1, -2, 1], [-2, 4, -2], [1, -2, 1]], np.float32)
    band = np.concatenate([grey[k : k + 3] for k in range(0, len(grey) - 2, 3 * rows)])
    moved = np.abs(cv2.filter2D(band, -1, kernel)[1::3])
    return float(np.median(moved)) / (6 * 0.6745)


def saddles_of(level):
    """Saddles of a Level that stand out from its noise, the strongest first."""
    import cv2

    b = level.grey
    xx = cv2.Sobel(b, cv2.CV_32F, 2, 0, ksize=1)
    yy = cv2.Sobel(b, cv2.CV_32F, 0, 2, ksize=1)
    kernel = np.array([-0.5, 0, 0.5], np.float32)
    xy = cv2.sepFilter2D(b, cv2.CV_32F, kernel, kernel)
    strength = cv2.multiply(xy, xy) - cv2.multiply(xx, yy)
    least = LEAST_STRENGTH * LEAST_CONTRAST / (np.pi * SIGMA**2)
    least = max(least, NOISE_SD * NOISE_OF_ROOT * level.noise) ** 2
    top = cv2.dilate(strength, np.ones((3, 3), np.uint8))
    top = cv2.compare(strength, top, cv2.CMP_EQ) & cv2.compare(
        strength, float(least), cv2.CMP_GT
    )
    top[:2] = top[-2:] = 0
    top[:, :2] = top[:, -2:] = 0
    place = np.flatnonzero(top)
    s = strength.ravel()[place]
    if len(place) > MOST_SADDLES:
        keep = np.argpartition(-s, MOST_SADDLES)[:MOST_SADDLES]
        place, s = place[keep], s[keep]
    order = np.argsort(-s, kind="stable")
    place, s = place[order], s[order]
    points = _stationary(b, xx, yy, xy, place, s)
    return Saddles(points, np.sqrt(s))


def _stationary(b, xx, yy, xy, place, strength):
    """Where the gradient vanishes near pixels `place`, (N, 2); within a pixel."""
    width = b.shape[1]
    flat = b.ravel()
    gx = (flat[place + 1] - flat[place - 1]) / 2
    gy = (flat[place + width] - flat[place - width]) / 2
    xx, yy, xy = (a.ravel()[place] for a in (xx, yy, xy))
    du = (yy * gx - xy * gy) / strength
    dv = (xx * gy - xy * gx) / strength
    v, u = np.divmod(place, width)
    return np.column_stack([u + np.clip(du, -1, 1), v + np.clip(dv, -1, 1)])
