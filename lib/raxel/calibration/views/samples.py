"""Board points at a lattice of pixels: what the generic method computes with.

Millions of pixels add nothing to the few numbers of centre and poses, so these are
found from every k-th pixel; the table of rays is made for all pixels at the end.
"""

from typing import NamedTuple

import numpy as np

from raxel.calibration.views.correspondence import pixels_on_board


class BoardSamples(NamedTuple):
    """pixels (M, 2) int, multiples of step, seen on any board; points (n, M, 2) on each
    of n boards, NaN where not seen; seen (n, M) bool; step in px.
    """

    pixels: np.ndarray
    points: np.ndarray
    seen: np.ndarray
    step: int

    def thinned(self, factor):
        """The samples whose pixels are multiples of factor * step."""
        step = factor * self.step
        keep = np.all(self.pixels % step == 0, axis=1)
        return BoardSamples(
            self.pixels[keep], self.points[:, keep], self.seen[:, keep], step
        )


def sample_boards(views, width, height, observations):
    """BoardSamples of about this many pixel-board pairs, at most every pixel."""
    area = sum(view.area() for view in views)
    step = max(1, round(np.sqrt(area / observations)))
    columns, rows = (width - 1) // step + 1, (height - 1) // step + 1
    points = np.full((len(views), rows * columns, 2), np.nan)
    for k, view in enumerate(views):
        pixels, on_board = pixels_on_board(view, width, height, step)
        points[k, pixels[:, 1] // step * columns + pixels[:, 0] // step] = on_board
    seen = np.isfinite(points[..., 0])
    used = np.flatnonzero(seen.any(axis=0))
    pixels = step * np.column_stack([used % columns, used // columns])
    return BoardSamples(pixels, points[:, used], seen[:, used], step)
