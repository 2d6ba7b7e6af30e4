"""Generic calibration, complete: a ray for every pixel, without a formula."""
