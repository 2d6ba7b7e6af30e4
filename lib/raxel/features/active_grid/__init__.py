"""Active grids: coded patterns on a monitor, decoded to a point for every pixel."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
