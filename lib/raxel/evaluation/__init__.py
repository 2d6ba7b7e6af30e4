"""Evaluation: how far a calibrated camera is from what it should be, with intervals."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
