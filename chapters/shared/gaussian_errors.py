"""Gaussian errors for the rigs of chapter 5, where no measured ones are asked for."""

from typing import NamedTuple

# Standard deviations of a corner, px, and of a decoded point, mm, along each axis.
CORNER_PX, DECODED_MM = 0.2, 0.01


class GaussianErrors(NamedTuple):
    """Independent errors, for a rig in place of `MirrorErrors`."""

    corner_px: float = CORNER_PX
    decoded_mm: float = DECODED_MM

    def corners(self, pixels, rng):
        """Pixels (N, 2) of corners in the mirror with errors."""
        return pixels + rng.normal(0, self.corner_px, pixels.shape)

    plate_corners = corners

    def in_mirror(self, points, rng):
        """Points (N, 2) mm of the monitor, decoded in the flexible mirror."""
        return points + rng.normal(0, self.decoded_mm, points.shape)

    in_platter = in_mirror

    def mounted(self, platter, rng, positions):
        """The `Platter` at each of the monitor's positions: where its board says."""
        return [platter] * positions

    @property
    def plate_sd_px(self):
        """Standard deviation of a corner of the platter's board along an axis, px."""
        return self.corner_px

    @property
    def platter_sd_mm(self):
        """Standard deviation of a point decoded in the platter along an axis, mm."""
        return self.decoded_mm
