"""Complete generic calibration: per-pixel rays without a parametric model."""
