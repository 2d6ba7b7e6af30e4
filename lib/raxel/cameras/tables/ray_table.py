"""The look-up table of a general camera and the interpolation between its cells."""

import numpy as np


class RayTable:
    """One ray per pixel centre; a cell without a ray holds NaN.

    directions: (H, W, 3) unit; origins: (3,) for a central camera or (H, W, 3);
    mask: (H, W) bool, which pixels have a ray.
    Between pixel centres directions and origins are bilinear; the direction is then
    normalised by whoever needs a unit vector.
    """

    def __init__(self, directions, origins):
        self.directions, self.origins = directions, origins
        self.mask = np.isfinite(directions[..., 0])
        self.height, self.width = self.mask.shape

    @property
    def central(self):
        return self.origins.ndim == 1

    @property
    def rows(self):
        """Directions (H * W, 3) and origins, likewise or (1, 3), as
        `raxel.cameras.tables.interpolation` takes them."""
        return self.directions.reshape(-1, 3), self.origins.reshape(-1, 3)
