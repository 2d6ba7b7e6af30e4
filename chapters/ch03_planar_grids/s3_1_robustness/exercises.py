"""Answers to the exercises of section 3.3.1."""

from __future__ import annotations

import math


def farthest_yaw(corner_px, focal_px):
    """Yaw (deg) at which a corner `corner_px` from the middle meets the camera."""
    return math.degrees(math.asin(focal_px / corner_px))


def shrunk_interval(inner_px, outer_px, focal_px):
    """Length (px) of a radial step of the flat picture, seen by the fisheye."""

    def radius(flat_px):
        return 2 * focal_px * math.sin(math.atan(flat_px / focal_px) / 2)

    return radius(outer_px) - radius(inner_px)


def mean_click(sd_px):
    """Mean distance (px) of Gaussian clicks from the corner: a Rayleigh law's."""
    return sd_px * math.sqrt(math.pi / 2)
