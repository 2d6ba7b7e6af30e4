"""Finding chessboard corners: detectors are callables (image, columns, rows).

`DETECTORS` maps their names; each returns a `Detection`. The default is the one that
found more: of 61 photographs in five sets (ordinary, wide, two fisheyes, a mirror)
'opencv' found 53 boards and 'opencv-sb' 47, all of them right within a pixel, and it
was faster wherever a board was found.
"""

from raxel.features.detector import Detection, refused, verified
from raxel.features.lattice import in_order_of_clicks, symmetries
from raxel.features.opencv import find_opencv, find_opencv_sb

DETECTORS = {"opencv": find_opencv, "opencv-sb": find_opencv_sb}
DEFAULT_DETECTOR = "opencv"
COUNTING_DETECTOR = "opencv-sb"  # finds boards whose size is not given

__all__ = [
    "COUNTING_DETECTOR",
    "DEFAULT_DETECTOR",
    "DETECTORS",
    "Detection",
    "in_order_of_clicks",
    "refused",
    "symmetries",
    "verified",
]
