"""Cameras in the files of other programs: export, exact or refitted, and import."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
