"""Parametric cameras: Zhang's method, OpenCV's fisheye model, general lens models."""
