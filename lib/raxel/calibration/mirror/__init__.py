"""Calibration of a camera that views a flexible mirror."""
