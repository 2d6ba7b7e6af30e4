"""Active grids: coded patterns on a monitor, decoded to a point for every pixel."""

from raxel.features.active_grid.decode import REASONS, Decoded, decode
from raxel.features.active_grid.errors import Noise, estimate_noise

__all__ = ["REASONS", "Decoded", "Noise", "decode", "estimate_noise"]
