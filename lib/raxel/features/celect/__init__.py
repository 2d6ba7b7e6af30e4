"""CELECT: chessboard corners in order from four clicks, however bent the image.

`celect` is the algorithm of section 3.1.2, `CelectSettings` its values.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
