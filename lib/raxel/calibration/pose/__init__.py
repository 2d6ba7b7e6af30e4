"""Poses of planar grids from calibrated rays."""
