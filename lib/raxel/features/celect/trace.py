"""Tracing one contour: the window steps from anchor to anchor along an edge."""

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from raxel.features.celect.hough import Peaks, angle_apart, normal_of, peaks_of, vote
from raxel.features.celect.layers import Layers


class Step(NamedTuple):
    """What one window saw: for figures.

    `centre` (2,), `radius` px; `edges` (n, 2) pixels S_c; `space` the Hough space;
    `lines` (k, 2) the peaks S_h as (R px, theta deg), `chosen` the index of h_p among
    them; `corners` (m, 2) candidates; `anchor` (2,) the next anchor.
    """

    centre: np.ndarray
    radius: float
    edges: np.ndarray
    space: np.ndarray
    lines: np.ndarray
    chosen: int
    corners: np.ndarray
    anchor: np.ndarray


class WindowContent(NamedTuple):
    """What is in a window."""

    edges: np.ndarray
    peaks: Peaks
    space: np.ndarray


@dataclass
class Trace:
    """A trace as it grows: anchors and candidates in px, theta of the last line."""

    anchors: list
    radii: list = field(default_factory=list)
    candidates: list = field(default_factory=list)
    theta: float | None = None
    fault: str = ""
    steps: list = field(default_factory=list)


class FirstLine(NamedTuple):
    """How the line is chosen at a contour's first anchor.

    `wrong_deg`: orientation of the other contour there. If `exact`, the line nearest to
    it is taken out (3.14, 3.16), else all within t4 of it (3.4). `along` (2,): vector
    from the first end to the last (3.5, 3.10, 3.17-3.19).
    """

    wrong_deg: float
    exact: bool
    along: np.ndarray


def near_lines(lines, near):
    """Indices S_d of the lines (k, 2) less than `near` px from the centre, (3.3)."""
    return np.flatnonzero(np.abs(lines[:, 0]) < near)


def first_line(lines, near, first, angle_deg, along_deg):
    """Index of the line h_p at a first anchor, None without one: (3.4, 3.5) and kin.

    `lines` (k, 2), `near` indices S_d, `first` a FirstLine, `angle_deg` t4, `along_deg`
    the orientation to be near to.
    """
    off = angle_apart(lines[near, 1], first.wrong_deg)
    if first.exact:
        left = np.delete(near, off.argmin()) if len(near) else near
    else:
        left = near[off > angle_deg]
    return next_line(lines, left, along_deg)


def next_line(lines, near, theta_deg):
    """Index of the near line with the least turn from theta_deg, (3.5, 3.11, 3.18)."""
    if not len(near):
        return None
    return int(near[angle_apart(lines[near, 1], theta_deg).argmin()])


def next_anchor(edges, line, centre, band, away_from, direction):
    """The edge pixel that becomes the next anchor, None without one: (3.7, 3.9-3.13).

    Of the edge pixels (n, 2) within `band` px of the line and in `direction` (2,) from
    the centre: the one farthest from `away_from` (2,).
    """
    from raxel.features.celect.compiled import farthest_ahead

    distance, theta = line
    edges = np.ascontiguousarray(edges, float)
    index = farthest_ahead(
        edges, centre, normal_of(theta), distance, band, away_from, direction
    )
    return None if index < 0 else edges[index]


class Tracer:
    """Traces contours of one image with one set of values.

    `image` (h, w) grey; `scale` the image's `window.Scale`; `record` keeps every step.
    """

    def __init__(self, image, scale, settings, record=False):
        self.layers = Layers(image, scale, settings)
        self.settings = settings
        self.record = record

    def trace(self, start, end, s, first, squares):
        """The Trace from corner `start` (2,) to corner `end` (2,).

        `s` px scales window and thresholds; `first` is a FirstLine; `squares` are how
        many the contour passes. The last anchor is the end corner. If the end is not
        reached, `fault` says why.
        """
        trace = Trace([np.asarray(start, float)])
        most = self.settings.steps_per_square * squares
        for _ in range(most):
            if not self._advance(trace, s, first):
                trace.fault = "no edge to follow in the largest window"
                return trace
            if self._arrived(trace, end, s):
                trace.anchors[-1] = np.asarray(end, float)
                return trace
        trace.fault = f"the end corner was not reached in {most} steps"
        return trace

    def _advance(self, trace, s, first):
        """One step, in a window that grows until there is a next anchor."""
        settings = self.settings
        centre = trace.anchors[-1]
        for growths in range(settings.most_growths + 1):
            radius = settings.radius_scale * s * (1 + settings.growth) ** growths
            seen = self._look(centre, radius, s)
            chosen = self._choose(trace, seen.peaks.lines, s, first)
            anchor = None
            if chosen is not None:
                anchor = self._step_to(trace, seen, chosen, s, first)
            if anchor is not None:
                break
        corners = self.layers.corners(centre, radius)
        trace.radii.append(radius)
        trace.candidates.append(corners)
        if anchor is None:
            return False
        trace.theta = float(seen.peaks.lines[chosen, 1])
        trace.anchors.append(anchor)
        if self.record:
            lines = seen.peaks.lines
            trace.steps.append(
                Step(
                    centre,
                    radius,
                    seen.edges,
                    seen.space,
                    lines,
                    chosen,
                    corners,
                    anchor,
                )
            )
        return True

    def _look(self, centre, radius, s):
        edges = self.layers.edges(centre, radius)
        space = vote(edges, centre, radius)
        return WindowContent(edges, peaks_of(space, self.settings, s), space)

    def _choose(self, trace, lines, s, first):
        near = near_lines(lines, self.settings.near_centre * s)
        if trace.theta is not None:
            return next_line(lines, near, trace.theta)
        along = np.degrees(np.arctan2(first.along[1], first.along[0]))
        return first_line(lines, near, first, self.settings.first_angle_deg, along)

    def _step_to(self, trace, seen, chosen, s, first):
        band = max(self.settings.edge_band * s, self.settings.least_band_px)
        centre = trace.anchors[-1]
        if len(trace.anchors) == 1:
            away_from, direction = centre, first.along
        else:
            away_from = trace.anchors[-2]
            direction = centre - away_from
        line = seen.peaks.lines[chosen]
        return next_anchor(seen.edges, line, centre, band, away_from, direction)

    def _arrived(self, trace, end, s):
        """Whether the last step came within t6 of the end corner, anywhere on it."""
        (u, v), (to_u, to_v), (end_u, end_v) = (
            point.tolist() for point in (*trace.anchors[-2:], end)
        )
        du, dv = to_u - u, to_v - v
        share = ((end_u - u) * du + (end_v - v) * dv) / (du * du + dv * dv)
        share = min(max(share, 0.0), 1.0)
        nearest = u + share * du, v + share * dv
        return math.dist(nearest, (end_u, end_v)) < self.settings.arrival * s
