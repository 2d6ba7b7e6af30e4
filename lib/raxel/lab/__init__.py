"""The virtual laboratory: scenes in front of any camera, photographed.

World frame, mm. Radiance is linear; 1.0 is a white diffuse surface in full light.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
