"""Raxel: calibration of general cameras, pixel to ray, from images of known targets."""

__version__ = "0.1.0"
