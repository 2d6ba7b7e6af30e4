"""Which neighbouring pixels see one surface, when each is known to see some point?

A camera need not be continuous: between two facets of a mirror, or at the rim of what
was decoded, neighbours see places far apart, and nothing between them may be filled in.
"""

import numpy as np

TILE_PX = (
    16  # px: within it, neighbours that see one surface are about equally far apart
)
MAX_SIDE_RATIO = 3.0  # times the usual step in a tile
MAX_SIDE_SIGMAS = 6.0


def whole_cells(location, sigma=None):
    """Squares of four pixels that see one piece of one surface: (H - 1, W - 1) bool.

    location: (H, W, 2), the point that each pixel sees, NaN where none is known; sigma:
    alike, standard deviations. Square [v, u] has pixel (u, v) as its upper left one. No
    side of a whole one is longer than MAX_SIDE_RATIO times the median of the sides of its kind
    in the tile around, and MAX_SIDE_SIGMAS standard deviations.
    """
    along, down = (_near(location, sigma, axis) for axis in (1, 0))
    return along[:-1] & along[1:] & down[:, :-1] & down[:, 1:]


def usual_step(location):
    """Median distance of the points that neighbouring pixels see; NaN of no pair."""
    steps = [_lengths(location, axis).ravel() for axis in (0, 1)]
    steps = np.concatenate(steps)
    steps = steps[np.isfinite(steps)]
    return float(np.median(steps)) if len(steps) else np.nan


def as_in_a_mirror(location):
    """Whether x turns into y the other way round than in the picture, for most pixels;
    None where that cannot be told. location: as above."""
    corner = location[:-1, :-1]
    right, below = location[:-1, 1:] - corner, location[1:, :-1] - corner
    turn = right[..., 0] * below[..., 1] - right[..., 1] * below[..., 0]
    sides = np.count_nonzero(turn > 0), np.count_nonzero(turn < 0)
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
    """The median of the finite steps in the tile of each, NaN where there is none."""
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
