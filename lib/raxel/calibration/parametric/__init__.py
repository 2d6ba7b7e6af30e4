"""Cameras with a formula: Zhang's method, OpenCV's fisheye, any lens formula."""
