"""How much of the image and of the world a calibration knows."""

import numpy as np

SAMPLES = 257  # along a line across the image
GRID = 64  # pixels each way that stand for all


def board_counts(views, width, height):
    """How many views cover each pixel: (height, width) uint16.

    A board covers the cells of its lattice whose four corners were found; an active
    grid the pixels that found their point on it.
    """
    counts = np.zeros((height, width), np.uint16)
    for view in views:
        counts += view.covered(width, height)
    return counts


def field_of_view(camera):
    """Angles in degrees that rays cover: horizontal, vertical, from_axis (NaN: none).

    The first two along the middle row and column, from the rim of the first pixel to
    that of the last, past any hole, and more than 180 where rays look behind;
    from_axis: the largest angle of a ray to the camera's z axis.
    """
    half = (np.array([camera.width, camera.height]) - 1) / 2
    ends = np.linspace(-1, 1, SAMPLES)
    angles = {}
    for axis, name in enumerate(("horizontal", "vertical")):
        pixels = np.tile(half, (SAMPLES, 1))
        pixels[:, axis] += ends * (half[axis] + 0.5)
        angles[name] = _turned(camera.rays(pixels))
    u, v = (np.linspace(-0.5, 2 * h + 0.5, GRID) for h in half)
    pixels = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
    rays = camera.rays(np.clip(pixels, 0, 2 * half))
    z = np.clip(rays.directions[rays.valid, 2], -1, 1)
    angles["from_axis"] = float(np.degrees(np.arccos(z.min()))) if len(z) else np.nan
    return angles


def _turned(rays):
    """Degrees from ray to ray along a line, where both of two neighbours are there."""
    cosine = np.sum(rays.directions[1:] * rays.directions[:-1], axis=1)
    cosine = cosine[np.isfinite(cosine)]
    if not len(cosine):
        return np.nan
    return float(np.degrees(np.sum(np.arccos(np.clip(cosine, -1, 1)))))
