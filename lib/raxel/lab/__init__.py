"""Simulator: rendered images of scenes in front of any camera.

World frame, mm. Radiance is linear; 1.0 is a white diffuse surface in full light.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
