"""Lines in a window: a local Hough transform, its peaks, and what is done to them.

A line is (R, theta): its distance from the window's centre in px, with a sign, and its
orientation in degrees, modulo 180. The orientation is that of the line itself, not of
its normal (errata E-3.03): R = (p - centre) . n, n the direction of theta turned by +90
degrees in (u, v). So (R, theta) and (-R, theta + 180) are the same line.
"""

import math
from typing import NamedTuple

import cv2
import numpy as np

BINS = 180


class Peaks(NamedTuple):
    """Lines of a window: `lines` (n, 2) of (R px, theta deg), `votes` (n,)."""

    lines: np.ndarray
    votes: np.ndarray


def orientation(vector):
    """Orientation of a vector (2,) in degrees, from 0 to below 180."""
    return float(np.degrees(np.arctan2(vector[1], vector[0])) % 180)


def angle_apart(a, b):
    """Angle between orientations in degrees, modulo 180: from 0 to 90 (E-3.03)."""
    apart = np.abs(np.subtract(a, b)) % 180
    return np.minimum(apart, 180 - apart)


def normal_of(theta_deg):
    """Unit vector (2,) across a line of this orientation: its direction, + 90 deg."""
    theta = math.radians(theta_deg)
    return np.array([-math.sin(theta), math.cos(theta)])


def vote(points, centre, radius):
    """The Hough space of a window, (2 m + 1, 180) float32, R = 0 in the middle row.

    Bins of 1 px by 1 degree, lightly smoothed; nothing is smoothed across the border
    of the angle, which `peaks_of` takes care of.
    """
    from raxel.features.celect.compiled import hough_space

    points = np.ascontiguousarray(points, float)
    return hough_space(points, centre, int(np.ceil(radius)) + 1)


def peaks_of(space, settings, s):
    """The lines S_h of a window from its Hough space, (3.1), with their votes.

    Non-maximal suppression from 0 to 179 degrees, a second one across the border of
    the angle (`wrap`, t2), then the mean of peaks that are close (`split_peaks`, t1).
    `s` is the length in px that scales t1 and t2.
    """
    from raxel.features.celect.compiled import lines_of

    suppress = (
        max(1, round(settings.suppression_radius * s)),
        settings.suppression_deg,
    )
    wrap, split = float(settings.wrap * s), float(settings.split_peaks * s)
    box = np.ones([2 * half + 1 for half in suppress], np.uint8)
    found = lines_of(
        space,
        cv2.dilate(space, box),
        settings.peaks,
        suppress,
        settings.least_votes,
        wrap,
        split,
    )
    return Peaks(found[:, :2], found[:, 2])
