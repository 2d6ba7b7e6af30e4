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

    def corners(self, u, v, right, below):
        """Directions (N, 4, 3), and origins likewise or None, of cells of the table.

        u, v: (N,) upper left pixel; right, below: (N,) 1 or 0. A cell that is 0 wide or
        0 high is an edge or a single pixel: it repeats its corners. Their order is
        upper left, upper right, lower left, lower right.
        """
        first = v * self.width + u
        down = below * self.width
        index = np.stack([first, first + right, first + down, first + right + down], 1)
        directions = np.take(self.directions.reshape(-1, 3), index, axis=0)
        if self.central:
            return directions, None
        return directions, np.take(self.origins.reshape(-1, 3), index, axis=0)

    def interpolate(self, corners, s, t):
        """Direction (not unit) and origin at (s, t) in [0, 1]^2, with derivatives.

        corners: from `corners`. Returns two triples: value, d/ds, d/dt; each (N, 3),
        for a central camera's origin (3,).
        """
        directions, origins = corners
        direction = _bilinear(directions, s, t)
        if origins is None:
            return direction, (self.origins, np.zeros(3), np.zeros(3))
        return direction, _bilinear(origins, s, t)


def _bilinear(corners, s, t):
    s, t = s[:, None], t[:, None]
    base = corners[:, 0]
    along, down = corners[:, 1] - base, corners[:, 2] - base
    twist = corners[:, 3] - corners[:, 1] - down
    slope_s, slope_t = along + t * twist, down + s * twist
    return base + s * slope_s + t * down, slope_s, slope_t
