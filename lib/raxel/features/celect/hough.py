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


def strongest(space, limits, neighbourhood, share, columns=None):
    """Non-maximal suppression: [(row, column, votes), ...], the strongest first.

    A peak of a Hough space (h, w) is the largest value of its `neighbourhood` (rows,
    columns), half widths: the flank of another peak is none. Peaks count down to
    `share` of the strongest, but `limits` (least, most) of them. If there are fewer
    than the least number, the largest values outside the others' neighbourhoods make
    it up. `columns` (first, last + 1) restricts where all of them may lie.
    """
    from raxel.features.celect.compiled import strongest_peaks

    box = np.ones([2 * half + 1 for half in neighbourhood], np.uint8)
    rows, at = strongest_peaks(
        space,
        cv2.dilate(space, box),
        limits,
        neighbourhood,
        share,
        columns or (0, space.shape[1]),
    )
    return list(zip(rows.tolist(), at.tolist(), space[rows, at].tolist(), strict=True))


def peaks_of(space, settings, s):
    """The lines S_h of a window from its Hough space, (3.1), with their votes.

    Non-maximal suppression from 0 to 179 degrees, a second one across the border of
    the angle (`wrap`, t2), then the mean of peaks that are close (`split_peaks`, t1).
    `s` is the length in px that scales t1 and t2.
    """
    m = space.shape[0] // 2
    suppress = (
        max(1, round(settings.suppression_radius * s)),
        settings.suppression_deg,
    )
    found = strongest(space, settings.peaks, suppress, settings.least_votes)
    found = [(row - m, column, votes) for row, column, votes in found]
    if settings.wrap > 0:
        found = _suppressed_at_border(space, found, suppress, settings, s)
    merged = np.array(merge_close(found, settings.split_peaks * s), float)
    merged = merged.reshape(-1, 3)
    return Peaks(merged[:, :2], merged[:, 2])


def _suppressed_at_border(space, found, suppress, settings, s):
    """Peaks within t2 of 180 degrees, found again where 180 degrees is not a border.

    The space is remapped to 90..269 degrees by (R, theta) = (-R, theta + 180).
    """
    m, near = space.shape[0] // 2, settings.wrap * s
    at_border = [p for p in found if min(p[1], BINS - p[1]) <= near]
    if not at_border:
        return found
    remapped = np.hstack((space[:, BINS // 2 :], space[::-1, : BINS // 2]))
    middle = BINS // 2
    columns = middle - int(near), middle + int(near) + 1
    limits = 1, len(at_border)
    again = strongest(remapped, limits, suppress, settings.least_votes, columns)
    again = [(row - m, column + middle, votes) for row, column, votes in again]
    return [p for p in found if p not in at_border] + again


def merge_close(peaks, bins):
    """Peaks [(R, theta, votes), ...] within `bins` of each other become their mean.

    The mean is weighted by the votes. Close means by steps: a chain of close peaks is
    one line. The same line written as (R, theta) and (-R, theta + 180) is close to
    itself. Angles come out from 0 to below 180 degrees.
    """
    left, merged = list(peaks), []
    while left:
        group = [left.pop(0)]
        for member in group:
            for other in list(left):
                twin = nearest_form(other, member)
                if math.hypot(twin[0] - member[0], twin[1] - member[1]) <= bins:
                    left.remove(other)
                    group.append(twin)
        total = sum(votes for _, _, votes in group)
        R = sum(votes * R for R, _, votes in group) / total
        theta = sum(votes * theta for _, theta, votes in group) / total
        turns = math.floor(theta / BINS)
        merged.append((-R if turns % 2 else R, theta - BINS * turns, total))
    return merged


def nearest_form(line, other):
    """The form of a line, (R, theta) or (-R, theta +- 180), with theta nearest."""
    R, theta, votes = line
    turns = round((other[1] - theta) / BINS)
    return (-R if turns % 2 else R), theta + BINS * turns, votes
