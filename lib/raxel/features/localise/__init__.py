"""Sub-pixel localisation of chessboard corners that are known to a few pixels (3.1.3).

`LOCALISERS` maps names to callables (image, corners, **parameters) -> `Localised`.
Windows are full odd widths in px, but for OpenCV's function, which takes half windows.
"""

from raxel.features.localise.ridges import derivative
from raxel.features.localise.saddle import Localised, saddle_point
from raxel.features.localise.subpix import corner_subpix

LOCALISERS = {
    "saddle-point": saddle_point,
    "derivative": derivative,
    "opencv": corner_subpix,
}

__all__ = ["LOCALISERS", "Localised", "corner_subpix", "derivative", "saddle_point"]
