"""Finding chessboard corners: detectors are callables (image, columns, rows).

`CLICK_DETECTORS` also take the user's clicks, as (image, columns, rows, outer_corners,
contours).

`DETECTORS` maps their names; each returns a `Detection`. The default is the library's
own, `find_board`: it counts, it says how certain each corner is, and of 61 photographs
in five sets (ordinary, wide, two fisheyes, a mirror) it found all 61 boards with their
size given and without, all of them right within a pixel, where 'opencv' found 53 and
'opencv-sb' 47 with their size given.
"""

from raxel.features.celect.algorithm import find_celect
from raxel.features.chessboard import find_board
from raxel.features.detector import (
    Detection,
    Partial,
    find_opencv,
    find_opencv_sb,
    refused,
    verified,
)
from raxel.features.lattice import order_of_clicks, symmetries

DETECTORS = {"raxel": find_board, "opencv": find_opencv, "opencv-sb": find_opencv_sb}
DEFAULT_DETECTOR = "raxel"
CLICK_DETECTORS = {"celect": find_celect}

__all__ = [
    "CLICK_DETECTORS",
    "DEFAULT_DETECTOR",
    "DETECTORS",
    "Detection",
    "Partial",
    "find_board",
    "order_of_clicks",
    "refused",
    "symmetries",
    "verified",
]
