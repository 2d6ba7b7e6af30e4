"""Calibration of a viewer with a mirror that bends."""
