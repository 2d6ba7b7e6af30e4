"""Answers to the exercises of section 3.1.2."""

from __future__ import annotations

from chapters.ch03_planar_grids.s1_2_celect.results import interior
from raxel.features.celect import CelectSettings


def largest_growth():
    """Radius of the largest window, in squares, for ten corners a side."""
    settings = CelectSettings()
    corners = 10
    radius = (corners - 1) / (settings.radius_divisor * corners)
    return radius * (1 + settings.growth) ** settings.most_growths


def borderless_gain():
    """Corners that a white border costs on a board of 12 x 9 squares."""
    return interior((12, 9), 0) - interior((12, 9), 1)


def first_corner_wrong():
    """Least turn, in degrees, that takes the edge 40 deg from L4 into t4."""
    return 40 - CelectSettings().first_angle_deg
