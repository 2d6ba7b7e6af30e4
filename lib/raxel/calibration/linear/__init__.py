"""Linear stages of generic calibration: centre and poses of grids from rays."""
