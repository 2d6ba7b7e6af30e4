"""Sub-pixel localisation of chessboard corners that are known to a few pixels (3.1.3).

Localisers are callables (image, corners, **parameters) -> `Localised`.
Windows are full odd widths in px, but for OpenCV's function, which takes half windows.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
