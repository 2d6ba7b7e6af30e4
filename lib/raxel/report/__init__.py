"""The report of a calibration: a page with figures of corners, residuals, coverage."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
