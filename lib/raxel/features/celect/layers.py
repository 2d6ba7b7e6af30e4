"""Edges and corners of an image, made tile by tile as the windows come to need them.

Neighbouring windows overlap, so every pixel would be smoothed and searched several
times. A tile is searched once, on a patch that reaches as far beyond it as anything
within depends on; only the hysteresis of Canny's method could reach farther.
"""

import numpy as np

from raxel.features.celect.window import (
    Window,
    canny_edges,
    gradients,
    harris_corners,
    margin,
)

TILE_PX = 160


class Layers:
    """The edge pixels S_c (3.8) and the corner candidates of an image.

    `image` (h, w) grey, `scale` its `window.Scale`, `settings` a CelectSettings.
    """

    def __init__(self, image, scale, settings):
        self.image = image
        self.scale = scale
        self.settings = settings
        self._edges, self._corners = {}, {}

    def edges(self, centre, radius):
        """Edge pixels (n, 2) within `radius` px of a centre (2,)."""
        return self._within(self._edges, centre, radius)

    def corners(self, centre, radius):
        """Corners (m, 2) px within `radius` px of a centre (2,)."""
        return self._within(self._corners, centre, radius)

    def _within(self, layer, centre, radius):
        from raxel.features.celect.compiled import within

        pieces = []
        for tile in self._tiles(centre, radius):
            if tile not in layer:
                self._search(tile)
            pieces.append(within(layer[tile], centre, radius))
        return pieces[0] if len(pieces) == 1 else np.concatenate(pieces)

    def _tiles(self, centre, radius):
        """The tiles (column, row) of the image that a window touches."""
        (u, v), (height, width) = centre.tolist(), self.image.shape
        columns, rows = _span(u, radius, width), _span(v, radius, height)
        return [(column, row) for column in columns for row in rows]

    def _search(self, tile):
        low = np.array(tile) * TILE_PX
        high = low + TILE_PX
        reach = margin(self.scale.smoothing)
        first, across, down = gradients(
            self.image, low - reach, high + reach, self.scale.smoothing
        )
        # The circle about the tile; what lies beyond the tile is its neighbours'.
        middle, radius = (low + high - 1) / 2, TILE_PX
        window = Window(middle, radius, first, across, down)
        settings = self.settings
        edges = canny_edges(window, self.scale, settings.canny_high, settings.canny_low)
        corners = harris_corners(window, self.scale, settings)
        self._edges[tile] = _inside(edges, low, high)
        self._corners[tile] = _inside(corners, low, high)


def _span(middle, radius, size):
    """The tiles of a side of `size` px within a radius of a place on it."""
    first, last = int((middle - radius) // TILE_PX), int((middle + radius) // TILE_PX)
    return range(max(first, 0), min(last, (size - 1) // TILE_PX) + 1)


def _inside(points, low, high):
    """The points (n, 2) of a tile, as float64."""
    (u, v), (left, top), (right, bottom) = points.T, low - 0.5, high - 0.5
    inside = (u >= left) & (u < right) & (v >= top) & (v < bottom)
    return points[inside].astype(float)
