"""Generic cameras: ray look-up tables, and B-spline ray fields over an image."""
