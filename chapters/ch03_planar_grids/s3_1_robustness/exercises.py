"""Answers to the exercises of section 3.3.1."""

from __future__ import annotations

import math


def farthest_yaw(corner_px, focal_px):
    """Turned by the yaw, an outer corner comes nearer by its distance times the sine;
    it is beside the camera when that is the focal length.
    """
    return math.degrees(math.asin(focal_px / corner_px))


def shrunk_interval(inner_px, outer_px, focal_px):
    """An end of the step at r is seen at theta = arctan(r / f), and the fisheye shows
    that at 2 f sin(theta / 2); the difference of the two ends is the answer.
    """

    def radius(flat_px):
        return 2 * focal_px * math.sin(math.atan(flat_px / focal_px) / 2)

    return radius(outer_px) - radius(inner_px)


def mean_click(sd_px):
    """The distance of Gaussian clicks follows Rayleigh's law, whose mean is the SD of
    an axis times sqrt(pi / 2).
    """
    return sd_px * math.sqrt(math.pi / 2)
