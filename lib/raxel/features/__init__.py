"""Detection of chessboard (checkerboard) corners.

Detectors are callables (image, columns, rows).

`CLICK_DETECTORS` also take the user's clicks, as (image, columns, rows, outer_corners,
contours).

`DETECTORS` maps their names; each returns a `Detection`. The default is the library's
own, `find_board`. It determines the size of a board and predicts the uncertainty of
each corner. It found all 61 boards of five real image sets (ordinary, wide-angle, two
fisheyes, a mirror), with and without a given size and with errors below a pixel;
'opencv' found 53 and 'opencv-sb' 47 with a given size.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
