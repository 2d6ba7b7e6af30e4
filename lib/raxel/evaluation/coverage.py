"""Image area that the boards cover, and the uncertainty of the rays outside it.

Rays outside the area of the boards are extrapolated. The covariance of a parametric
model is valid there only if the lens follows the model, which lenses do approximately.
Therefore the uncertainty is that of a lens that may deviate from the fit by any field
of third degree over the image, and by radial terms of fifth and seventh degree
(`evaluation.misfit`), as far as the boards do not constrain it. No residual shows such
an error. Inside the boards it is a fraction of a pixel; outside it grows with up to the
seventh power of the distance.
"""

from typing import NamedTuple

import numpy as np

from raxel.evaluation.misfit import without_turns

N_SAMPLES = 257  # along a line across the image
N_GRID = 64  # pixels along each axis, for all
MAX_N_CELLS = 64  # of the covered area, along the longer side of the image
# SD above which a ray is unknown: it may as well be that of the next pixel. And its
# minimum ratio to the SD inside the boards, so that the cause is the area of the boards
# and not the noise of their corners.
UNKNOWN_SD_PX, UNKNOWN_SD_RATIO = 1.0, 2.0
MIN_UNKNOWN_SHARE = 1 / 10  # of the image: more than an edge, or one corner


def board_counts(views, width, height):
    """How many views cover each pixel: (height, width) uint16.

    A board covers the cells of its lattice whose four corners were found; an active
    grid the pixels that found their point on it.
    """
    counts = np.zeros((height, width), np.uint16)
    for view in views:
        counts += view.covered(width, height)
    return counts


def covered_cells(views, width, height):
    """Cells of the image of which a board covers a pixel, bool (rows, columns).

    Cells are nearly square, MAX_N_CELLS along the longer side of the image.
    """
    counts = board_counts(views, width, height)
    share = min(1.0, MAX_N_CELLS / max(width, height))
    rows, columns = (max(1, round(share * side)) for side in counts.shape)
    starts = (
        np.arange(n) * side // n
        for n, side in zip((rows, columns), counts.shape, strict=True)
    )
    for axis, start in enumerate(starts):
        counts = np.maximum.reduceat(counts, start, axis=axis)
    return counts > 0


def field_of_view(camera):
    """Angles in degrees that rays cover: horizontal, vertical, from_axis (NaN: none).

    The first two along the middle row and column, from the outer edge of the first
    pixel to that of the last, across holes, more than 180 where rays point backwards;
    from_axis: the largest angle of a ray to the camera's z axis.
    """
    half = (np.array([camera.width, camera.height]) - 1) / 2
    ends = np.linspace(-1, 1, N_SAMPLES)
    angles = {}
    for axis, name in enumerate(("horizontal", "vertical")):
        pixels = np.tile(half, (N_SAMPLES, 1))
        pixels[:, axis] += ends * (half[axis] + 0.5)
        angles[name] = _turned(camera.rays(pixels))
    u, v = (np.linspace(-0.5, 2 * h + 0.5, N_GRID) for h in half)
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


class BeyondBoards(NamedTuple):
    """share: of the pixels that have a ray, those outside the convex hull of all
    corners; unknown: of them, those outside with an SD above UNKNOWN_SD_PX; largest_px:
    SD of the worst ray outside, the larger of both sources, 0 without any; under_px:
    RMS of the SDs of rays inside boards, by the camera's own covariance where it has
    one. SDs are distances in px, after the best rotation of rays inside boards."""

    share: float
    unknown: float
    largest_px: float
    under_px: float

    @property
    def matters(self):
        """Whether so much of the image is unknown that it is reported."""
        return self.unknown >= MIN_UNKNOWN_SHARE

    def fields(self):
        """The area for JSON."""
        keys = "share_of_image", "share_unknown", "largest_sd_px", "sd_under_boards_px"
        return dict(zip(keys, self, strict=True))


def beyond_boards(fields, covariance, views, seen, own):
    """The BeyondBoards of CorrectionFields, by the covariance (K, K) of their shapes.

    seen (N,) bool: the fields' pixels inside boards; own (N,): SDs of all pixels by the
    camera's own covariance, px, NaN where unknown. None without any pixel inside.
    """
    import cv2

    if not seen.any():
        return None
    corners = np.concatenate([view.pixels for view in views])
    hull = cv2.convexHull(corners[np.isfinite(corners[:, 0])].astype(np.float32))
    inside = [cv2.pointPolygonTest(hull, p, False) >= 0 for p in fields.pixels]
    outside = ~np.array(inside)
    shapes = without_turns(fields.turns, fields.shapes, seen)
    squares = np.sum((shapes @ covariance) * shapes, axis=(1, 2))
    sd = np.sqrt(np.maximum(squares, 0.0))
    under = np.sqrt(np.mean(squares[seen]))
    unknown = outside & (sd > max(UNKNOWN_SD_PX, UNKNOWN_SD_RATIO * under))
    shares = float(np.mean(outside)), float(np.mean(unknown))
    largest = np.max(np.fmax(sd, own) * outside)
    known = own[seen & np.isfinite(own)]
    under = np.sqrt(np.mean(known**2)) if len(known) else under
    return BeyondBoards(*shares, float(largest), float(under))
