"""Cells of neighbouring pixels that see one continuous surface.

A camera need not be continuous: at an edge between two facets of a mirror, or of the
decoded area, neighbours see distant positions, and there is no interpolation between
them.
"""

import numpy as np

# Px: within it, neighbours on one surface have similar distances.
TILE_PX = 16
ROWS_PER_BLOCK = 16 * TILE_PX  # handled at once, which bounds the memory
MAX_SIDE_RATIO = 3.0  # over the median side in a tile
MAX_SIDE_SIGMAS = 6.0


def whole_cells(location, sigma=None):
    """Squares of four pixels that see one piece of one surface: (H - 1, W - 1) bool.

    location: (H, W, 2), the point that each pixel sees, NaN where unknown; sigma:
    likewise, standard deviations. Square [v, u] has pixel (u, v) as its upper left one.
    The sides of a whole square are at most MAX_SIDE_RATIO times the median of the sides
    of their kind in the tile around, plus MAX_SIDE_SIGMAS standard deviations.
    """
    parts = []
    for first in range(0, max(len(location) - 1, 1), ROWS_PER_BLOCK):
        rows = slice(first, first + ROWS_PER_BLOCK + TILE_PX + 1)
        near = location[rows], None if sigma is None else sigma[rows]
        along, down = (_near(*near, axis) for axis in (1, 0))
        whole = along[:-1] & along[1:] & down[:, :-1] & down[:, 1:]
        parts.append(whole[:ROWS_PER_BLOCK])
    return np.concatenate(parts)


def usual_step(location):
    """Median distance of the points that neighbouring pixels see; NaN without a
    pair."""
    steps = [_lengths(location, axis).ravel() for axis in (0, 1)]
    steps = np.concatenate(steps)
    steps = steps[np.isfinite(steps)]
    return float(np.median(steps)) if len(steps) else np.nan


def as_in_a_mirror(location):
    """Whether x turns into y in the opposite sense of the image, for most pixels; None
    where undetermined. location: as above."""
    sides = np.zeros(2, int)
    for first in range(0, len(location) - 1, ROWS_PER_BLOCK):
        part = location[first : first + ROWS_PER_BLOCK + 1]
        corner = part[:-1, :-1]
        right, below = part[:-1, 1:] - corner, part[1:, :-1] - corner
        turn = right[..., 0] * below[..., 1] - right[..., 1] * below[..., 0]
        sides += np.count_nonzero(turn > 0), np.count_nonzero(turn < 0)
    return bool(sides[1] > sides[0]) if any(sides) else None


def _near(location, sigma, axis):
    """Whether each pixel and the next one along an axis see one surface."""
    steps = _lengths(location, axis)
    allowed = MAX_SIDE_RATIO * _tile_medians(steps)
    if sigma is not None:
        variance = np.sum(np.square(sigma), axis=2)
        ends = np.moveaxis(variance, axis, 0)
        both = np.moveaxis(ends[:-1] + ends[1:], 0, axis)
        allowed = allowed + MAX_SIDE_SIGMAS * np.sqrt(both)
    with np.errstate(invalid="ignore"):
        return steps <= allowed


def _lengths(location, axis):
    return np.linalg.norm(np.diff(location, axis=axis), axis=2)


def _tile_medians(steps):
    """Median of the finite steps in the tile of each, NaN without one."""
    height, width = steps.shape
    rows, columns = -(-height // TILE_PX), -(-width // TILE_PX)
    padded = np.full((rows * TILE_PX, columns * TILE_PX), np.nan, steps.dtype)
    padded[:height, :width] = steps
    tiles = padded.reshape(rows, TILE_PX, columns, TILE_PX).swapaxes(1, 2)
    tiles = np.sort(tiles.reshape(rows * columns, -1), axis=1)  # NaN last
    known = np.count_nonzero(np.isfinite(tiles), axis=1)
    middle = tiles[np.arange(len(tiles)), np.maximum(known - 1, 0) // 2]
    medians = middle.reshape(rows, columns).repeat(TILE_PX, 0).repeat(TILE_PX, 1)
    return medians[:height, :width]
