"""Lines, planes, rigid poses and homographies.

Everything is vectorised over points and rays, in float64. Poses are 4x4 arrays named
target from source; Plücker lines keep the thesis's order (see `lines`).
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
