"""Cameras: bulk maps from pixels to rays and from points to pixels, inverse to each
other, with flags for pixels and points without a result.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
