"""What is known of rays of the image where no board was: by extrapolation alone.

A formula goes on beyond the boards, and its own covariance says how far it may be off
there if the lens follows it. Lenses do so nearly. So the rays are judged by what the
boards say of a lens that is free to depart from the fit by any field of third degree
over the image, and by radial terms of fifth and seventh (`evaluation.corrections`): as
little as they hold such a field to, as far may rays be off, and no residual shows it.
Under the boards that is a fraction of a pixel; beyond them it grows with up to the
seventh power of the distance.
"""

from typing import NamedTuple

import numpy as np

# SD from which on a ray is taken for unknown: it may as well be its neighbour's. And
# how many times that under the boards it must be, so that the boards' reach and not
# their corners' noise is to blame.
UNKNOWN_PX, TIMES = 1.0, 2.0
LEAST_SHARE = 1 / 10  # of the image, unknown: more than a rim, or one corner


class BeyondBoards(NamedTuple):
    """share: of the pixels that have a ray, those outside the convex hull of all
    corners; unknown: of them, those outside whose ray is known to less than UNKNOWN_PX;
    largest_px: SD of the worst ray outside, 0 where there is none; under_px: RMS of the
    SDs of rays under boards. SDs are distances in px, after the best rotation."""

    share: float
    unknown: float
    largest_px: float
    under_px: float

    @property
    def matters(self):
        """Whether so much of the image is unknown that it is worth a word."""
        return self.unknown >= LEAST_SHARE


def beyond_boards(fields, covariance, views, seen):
    """The BeyondBoards of CorrectionFields, by the covariance (K, K) of their shapes.

    seen (N,) bool: the fields' pixels where boards were seen. None where that is none.
    """
    if not seen.any():
        return None
    squares = np.einsum(
        "nak,kl,nal->n", fields.shapes, covariance, fields.shapes, optimize=True
    )
    sd = np.sqrt(np.maximum(squares, 0.0))
    outside = ~_inside(fields.pixels, views)
    under = np.sqrt(np.mean(squares[seen]))
    unknown = outside & (sd > max(UNKNOWN_PX, TIMES * under))
    largest = sd[outside].max() if outside.any() else 0.0
    shares = float(np.mean(outside)), float(np.mean(unknown))
    return BeyondBoards(*shares, float(largest), float(under))


def _inside(pixels, views):
    """Which pixels (N, 2) lie in the convex hull of all corners of views: (N,) bool."""
    import cv2

    corners = np.concatenate([view.pixels for view in views])
    there = corners[np.isfinite(corners[:, 0])].astype(np.float32)
    hull = cv2.convexHull(there)
    return np.array([cv2.pointPolygonTest(hull, p, False) >= 0 for p in pixels])
