"""Tracing one contour: the window steps from anchor to anchor along an edge."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import ArrayLike

from raxel.features.celect.compiled import (
    farthest_ahead,
    hough_space,
    lines_of,
    response_of,
    set_within,
    structure_tensor,
    within,
)

# Length scales of the contours: Table 3.1 for the sides, the rule for the columns.


def side_lengths(
    outer_corners: np.ndarray, columns: int, rows: int, divisor: float
) -> np.ndarray:
    """Return s_1..s_4 of Table 3.1 in px, the length scales of the four sides.

    `columns` and `rows` count corners, so s is a little less than half a square
    (errata E-3.01).

    Parameters
    ----------
    outer_corners : np.ndarray
        (4, 2) px, clockwise.
    columns, rows : int
        Corners per row and per column.
    divisor : float
        `CelectSettings.radius_divisor`.

    Returns
    -------
    np.ndarray
        (4,) px.
    """
    sides = np.linalg.norm(np.roll(outer_corners, -1, axis=0) - outer_corners, axis=1)
    return sides / (divisor * np.array([columns, rows, columns, rows]))


def mean_side(previous, settings):
    """s in px of a column from the corners (n, 2) of the previous one."""
    return settings.column_radius * corner_distances(previous).mean()


def corner_distances(corners):
    """Distances (n - 1,) in px between consecutive corners (n, 2) of a contour."""
    return np.linalg.norm(np.diff(corners, axis=0), axis=1)


# Edges and corners of an image, computed tile by tile where windows need them.
# Neighbouring windows overlap, so that every pixel would be smoothed and searched
# several times. A tile is searched once, on a patch that includes all pixels on which
# its result depends; only the hysteresis of Canny's method could extend farther.


TILE_PX = 160


class Layers:
    """Hold the edge pixels S_c (3.8) and the corner candidates of an image.

    Parameters
    ----------
    image : np.ndarray
        (h, w) grey levels.
    scale : Scale
        Clear gradient and response of the image.
    settings : CelectSettings
        Values of the algorithm.
    """

    def __init__(self, image: np.ndarray, scale: Scale, settings: Any):
        self.image = image
        self.scale = scale
        self.settings = settings
        self._edges, self._corners = {}, {}  # type: ignore[var-annotated]

    def edges(self, centre: np.ndarray, radius: float) -> np.ndarray:
        """Return edge pixels (n, 2) within `radius` px of a centre (2,)."""
        return self._within(self._edges, centre, radius)

    def corners(self, centre: np.ndarray, radius: float) -> np.ndarray:
        """Return corners (m, 2) px within `radius` px of a centre (2,)."""
        return self._within(self._corners, centre, radius)

    def _within(self, layer, centre, radius):
        pieces = []
        for tile in self._tiles(centre, radius):
            if tile not in layer:
                self._search(tile)
            pieces.append(within(layer[tile], centre, radius))
        return pieces[0] if len(pieces) == 1 else np.concatenate(pieces)

    def _tiles(self, centre, radius):
        """The tiles (column, row) of the image that a window intersects."""
        (u, v), (height, width) = centre.tolist(), self.image.shape
        columns, rows = _span(u, radius, width), _span(v, radius, height)
        return [(column, row) for column in columns for row in rows]

    def _search(self, tile):
        low = np.array(tile) * TILE_PX
        high = low + TILE_PX
        reach = margin(self.scale.smoothing)
        first, across, down = gradients(
            self.image, low - reach, high + reach, self.scale.smoothing
        )
        # The circle around the tile; positions outside the tile belong to its
        # neighbours.
        middle, radius = (low + high - 1) / 2, TILE_PX
        window = Window(middle, radius, first, across, down)
        settings = self.settings
        edges = canny_edges(window, self.scale, settings.canny_high, settings.canny_low)
        corners = harris_corners(window, self.scale, settings)
        self._edges[tile] = _inside(edges, low, high)
        self._corners[tile] = _inside(corners, low, high)


def _span(middle, radius, size):
    """The tiles of a side of `size` px within a radius of a position on it."""
    first, last = int((middle - radius) // TILE_PX), int((middle + radius) // TILE_PX)
    return range(max(first, 0), min(last, (size - 1) // TILE_PX) + 1)


def _inside(points, low, high):
    """The points (n, 2) of a tile, as float64."""
    (u, v), (left, top), (right, bottom) = points.T, low - 0.5, high - 0.5
    inside = (u >= left) & (u < right) & (v >= top) & (v < bottom)
    return points[inside].astype(float)


# Lines in a window: a local Hough transform and its peaks. A line is (R, theta): its
# signed distance from the window's centre in px, and its orientation in degrees, modulo
# 180. The orientation is that of the line itself, not of its normal (errata E-3.03): R
# = (p - centre) . n, with n the direction of theta rotated by +90 degrees in (u, v). So
# (R, theta) and (-R, theta + 180) are the same line.


N_ANGLE_BINS = 180


class Peaks(NamedTuple):
    """Hold the lines of a window.

    Attributes
    ----------
    lines : np.ndarray
        (n, 2) of (R px, theta deg).
    votes : np.ndarray
        (n,) votes.
    """

    lines: np.ndarray
    votes: np.ndarray


def orientation(vector):
    """Orientation of a vector (2,) in degrees, from 0 to below 180."""
    return float(np.degrees(np.arctan2(vector[1], vector[0])) % 180)


def angle_difference(a: ArrayLike, b: ArrayLike) -> Any:
    """Return the angle between orientations in degrees, modulo 180: 0 to 90 (E-3.03).

    Parameters
    ----------
    a, b : ArrayLike
        Orientations in degrees, of any shapes that broadcast.

    Returns
    -------
    float or np.ndarray
        Angles in degrees.
    """
    difference = np.abs(np.subtract(a, b)) % 180
    return np.minimum(difference, 180 - difference)


def normal_of(theta_deg):
    """Unit vector (2,) across a line of this orientation: its direction, + 90 deg."""
    theta = math.radians(theta_deg)
    return np.array([-math.sin(theta), math.cos(theta)])


def vote(points: ArrayLike, centre: np.ndarray, radius: float) -> np.ndarray:
    """Return the Hough space of a window.

    Bins have 1 px by 1 degree, lightly smoothed. Nothing is smoothed across the border
    of the angle, which `peaks_of` handles.

    Parameters
    ----------
    points : ArrayLike
        (n, 2) edge pixels (u, v).
    centre : np.ndarray
        (2,) pixel (u, v) of the window's centre.
    radius : float
        Radius of the window in px.

    Returns
    -------
    np.ndarray
        (2 m + 1, 180) float32, R = 0 in the middle row.
    """
    points = np.ascontiguousarray(points, float)
    return hough_space(points, centre, int(np.ceil(radius)) + 1)


def peaks_of(space: np.ndarray, settings: Any, s: float) -> Peaks:
    """Return the lines S_h of a window from its Hough space, (3.1), with their votes.

    Non-maximal suppression runs from 0 to 179 degrees, a second one across the border
    of the angle (`wrap`, t2). The mean of close peaks follows (`split_peaks`, t1).

    Parameters
    ----------
    space : np.ndarray
        Hough space, as of `vote`.
    settings : CelectSettings
        Values of the algorithm.
    s : float
        Length in px that scales t1 and t2.

    Returns
    -------
    Peaks
        Lines and votes.
    """
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
        settings.min_vote_fraction,
        wrap,
        split,
    )
    return Peaks(found[:, :2], found[:, 2])


# The circular window that moves along a contour: its edges and its corners. Gradients
# are computed after Gaussian smoothing, on a patch large enough that none of them
# depends on the end of the window. The scale of the gradients (the strength of an edge
# and of a corner) is measured in the four clicked windows.


MARGIN_SIGMAS = 3.0
"""How far a Gaussian reaches, in its standard deviations."""

CANNY_FULL_SCALE = 4000.0
"""Value of the reference gradient in the whole numbers that Canny's method takes."""


class Smoothing(NamedTuple):
    """Standard deviations in px: of the grey values, and of the tensor of a corner."""

    grey: float
    tensor: float


class Scale(NamedTuple):
    """Hold the strength of a clear edge and of a clear corner in a smoothed image.

    Attributes
    ----------
    smoothing : Smoothing
        Standard deviations of the smoothing.
    gradient : float
        Grey levels per pixel.
    response : float
        Response of the corner detector.
    """

    smoothing: Smoothing
    gradient: float
    response: float


class Window(NamedTuple):
    """A circle of the image with the gradients of the square patch around it.

    `centre` (2,) pixels (u, v); `radius` px; `first` (2,) pixel (u, v) of the patch's
    first element; `gradient_u`, `gradient_v` (h, w) float32, grey levels per pixel.
    """

    centre: np.ndarray
    radius: float
    first: np.ndarray
    gradient_u: np.ndarray
    gradient_v: np.ndarray

    def within(self, mask):
        """Pixels (n, 2) inside the circle where the mask (h, w) uint8 is set."""
        return set_within(mask, self.first, self.centre, float(self.radius))


def smoothing_for(s: float, settings: Any) -> Smoothing:
    """Return the Smoothing of an image whose smallest contour scale is `s` px.

    Parameters
    ----------
    s : float
        Smallest length scale of the contours in px.
    settings : CelectSettings
        Values of the algorithm.

    Returns
    -------
    Smoothing
        Standard deviations in px.
    """
    grey = float(np.clip(settings.smoothing * s, *settings.smoothing_limits_px))
    return Smoothing(grey, settings.integration * grey)


def open_window(
    image: np.ndarray, centre: ArrayLike, radius: float, smoothing: Smoothing
) -> Window:
    """Return the Window of an image around a centre.

    The border of the image repeats its outermost pixels. No pixel beyond it is ever an
    edge or a corner.

    Parameters
    ----------
    image : np.ndarray
        (height, width) grey levels.
    centre : ArrayLike
        (2,) pixel (u, v).
    radius : float
        Radius in px.
    smoothing : Smoothing
        Standard deviations of the smoothing.

    Returns
    -------
    Window
        The circle with its gradients.
    """
    centre = np.asarray(centre, float)
    reach = radius + margin(smoothing)
    low = np.floor(centre - reach).astype(int)
    high = np.ceil(centre + reach).astype(int) + 1
    return Window(centre, radius, *gradients(image, low, high, smoothing))


def margin(smoothing):
    """Distance in px at which pixels affect whether a pixel is an edge or a corner."""
    return math.ceil(MARGIN_SIGMAS * (smoothing.grey + smoothing.tensor)) + 2


def gradients(image, low, high, smoothing):
    """First pixel (2,), and gradients (h, w) along u and v, of part of an image.

    `low`, `high` (2,): first pixel (u, v) and the one after the last, clipped at the
    image.
    """
    height, width = image.shape
    left, top = np.maximum(low, 0)
    right, bottom = min(high[0], width), min(high[1], height)
    patch = image[top:bottom, left:right].astype(np.float32)
    smooth = blurred(patch, smoothing.grey)
    across, down = (
        cv2.Sobel(
            smooth,
            cv2.CV_32F,
            *order,
            ksize=1,
            scale=0.5,
            borderType=cv2.BORDER_REPLICATE,
        )
        for order in ((1, 0), (0, 1))
    )
    return np.array([left, top], np.int32), across, down


def blurred(image, sd):
    """A Gaussian blur truncated at MARGIN_SIGMAS; border pixels are repeated."""
    size = 2 * math.ceil(MARGIN_SIGMAS * sd) + 1
    return cv2.GaussianBlur(image, (size, size), sd, borderType=cv2.BORDER_REPLICATE)


def canny_edges(window: Window, scale: Scale, high: float, low: float) -> np.ndarray:
    """Return the edge pixels S_c of a window by Canny's method (3.8).

    Parameters
    ----------
    window : Window
        The window.
    scale : Scale
        Clear gradient and response of the image.
    high, low : float
        The two thresholds, as shares of the clear gradient of the image.

    Returns
    -------
    np.ndarray
        (n, 2) pixels (u, v).
    """
    factor = CANNY_FULL_SCALE / scale.gradient
    across, down = (
        cv2.multiply(g, 1.0, scale=factor, dtype=cv2.CV_16S)  # type: ignore[call-overload]
        for g in (window.gradient_u, window.gradient_v)
    )
    edges = cv2.Canny(
        across, down, low * CANNY_FULL_SCALE, high * CANNY_FULL_SCALE, L2gradient=True
    )
    return window.within(edges)


def harris_response(window, tensor_px, k):
    """Harris's R = det M - k trace(M)^2 over the patch of a window, (h, w)."""
    tensor = structure_tensor(window.gradient_u, window.gradient_v)
    return response_of(blurred(tensor, tensor_px), np.float32(k))


def harris_corners(window, scale, settings):
    """Corner pixels (n, 2) of a window: local maxima of Harris's response.

    A maximum counts from `harris_share` of the image's clear response.
    """
    response = harris_response(window, scale.smoothing.tensor, settings.harris_k)
    min_response = max(
        settings.harris_share * scale.response, np.finfo(np.float32).tiny
    )
    peaks = (response >= cv2.dilate(response, None)) & (response >= min_response)
    return window.within(peaks.view(np.uint8))


def clear_scale(
    windows: Sequence[Window], smoothing: Smoothing, settings: Any
) -> Scale:
    """Return the Scale of an image from the windows around its clicked corners.

    The result is the median over the windows of the largest gradient and response of
    each: one window with glare or clutter does not matter. Both are 0 in a flat image.

    Parameters
    ----------
    windows : Sequence[Window]
        Windows around the clicked corners.
    smoothing : Smoothing
        Standard deviations of the smoothing.
    settings : CelectSettings
        Values of the algorithm.

    Returns
    -------
    Scale
        Clear gradient and response.
    """
    gradients, responses = [], []
    for window in windows:
        steep = np.hypot(window.gradient_u, window.gradient_v)
        response = harris_response(window, smoothing.tensor, settings.harris_k)
        inside = window.within(np.ones(steep.shape, np.uint8)) - window.first
        u, v = inside.T
        gradients.append(steep[v, u].max(initial=0.0))
        responses.append(response[v, u].max(initial=0.0))
    return Scale(smoothing, float(np.median(gradients)), float(np.median(responses)))


class Step(NamedTuple):
    """The content of one window, for figures.

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
    """Edges, lines and Hough space of a window."""

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
    """Describe how the line is chosen at the first anchor of a contour.

    Attributes
    ----------
    wrong_deg : float
        Orientation in degrees of the other contour there.
    exact : bool
        Whether only the line nearest to it is removed (3.14, 3.16), instead of all
        within t4 of it (3.4).
    along : np.ndarray
        (2,) vector from the first end to the last (3.5, 3.10, 3.17-3.19).
    """

    wrong_deg: float
    exact: bool
    along: np.ndarray


def near_lines(lines: np.ndarray, near: float) -> np.ndarray:
    """Return the indices S_d of the lines less than `near` px from the centre, (3.3).

    Parameters
    ----------
    lines : np.ndarray
        (k, 2) of (R px, theta deg).
    near : float
        Distance in px, t3.

    Returns
    -------
    np.ndarray
        Indices of lines.
    """
    return np.flatnonzero(np.abs(lines[:, 0]) < near)


def first_line(
    lines: np.ndarray,
    near: np.ndarray,
    first: FirstLine,
    angle_deg: float,
    along_deg: float,
) -> int | None:
    """Return the index of the line h_p at a first anchor, None without one.

    Parameters
    ----------
    lines : np.ndarray
        (k, 2) of (R px, theta deg).
    near : np.ndarray
        Indices S_d.
    first : FirstLine
        How the line is chosen.
    angle_deg : float
        t4 in degrees.
    along_deg : float
        Orientation in degrees to which the line should be near.

    Returns
    -------
    int or None
        Index of a line.

    References
    ----------
    Thesis (3.4), (3.5) and the equations of the other contours.
    """
    difference = angle_difference(lines[near, 1], first.wrong_deg)
    if first.exact:
        remaining = np.delete(near, difference.argmin()) if len(near) else near
    else:
        remaining = near[difference > angle_deg]
    return next_line(lines, remaining, along_deg)


def next_line(lines: np.ndarray, near: np.ndarray, theta_deg: float) -> int | None:
    """Return the index of the near line with the least turn, (3.5, 3.11, 3.18).

    Parameters
    ----------
    lines : np.ndarray
        (k, 2) of (R px, theta deg).
    near : np.ndarray
        Indices of lines.
    theta_deg : float
        Orientation in degrees from which the turn counts.

    Returns
    -------
    int or None
        Index of a line; None without one.
    """
    if not len(near):
        return None
    return int(near[angle_difference(lines[near, 1], theta_deg).argmin()])


def next_anchor(
    edges: ArrayLike,
    line: np.ndarray,
    centre: np.ndarray,
    band: float,
    away_from: np.ndarray,
    direction: np.ndarray,
) -> np.ndarray | None:
    """Return the edge pixel that becomes the next anchor, None without one.

    It is the one farthest from `away_from`, of the edge pixels within `band` px of the
    line and in `direction` from the centre.

    Parameters
    ----------
    edges : ArrayLike
        (n, 2) edge pixels (u, v).
    line : np.ndarray
        (2,) R px and theta deg.
    centre, away_from : np.ndarray
        (2,) pixels (u, v).
    band : float
        Distance in px.
    direction : np.ndarray
        (2,) vector.

    Returns
    -------
    np.ndarray or None
        (2,) pixel (u, v).

    References
    ----------
    Thesis (3.7), (3.9) to (3.13).
    """
    distance, theta = line
    edges = np.ascontiguousarray(edges, float)
    index = farthest_ahead(
        edges, centre, normal_of(theta), distance, band, away_from, direction
    )
    return None if index < 0 else edges[index]


class Tracer:
    """Trace contours of one image with one set of values.

    Parameters
    ----------
    image : np.ndarray
        (h, w) grey levels.
    scale : Scale
        Clear gradient and response of the image.
    settings : CelectSettings
        Values of the algorithm.
    record : bool
        Keep every step.
    """

    def __init__(
        self, image: np.ndarray, scale: Scale, settings: Any, record: bool = False
    ):
        self.layers = Layers(image, scale, settings)
        self.settings = settings
        self.record = record

    def trace(
        self, start: ArrayLike, end: ArrayLike, s: float, first: FirstLine, squares: int
    ) -> Trace:
        """Trace a contour from one corner to another.

        The last anchor is the end corner.

        Parameters
        ----------
        start, end : ArrayLike
            (2,) pixels (u, v) of the two corners.
        s : float
            Length in px that scales window and thresholds.
        first : FirstLine
            How the first line is chosen.
        squares : int
            Number of squares that the contour passes.

        Returns
        -------
        Trace
            If the end is not reached, its `fault` states why.
        """
        trace = Trace([np.asarray(start, float)])
        max_steps = self.settings.steps_per_square * squares
        for _ in range(max_steps):
            if not self._advance(trace, s, first):
                trace.fault = "no edge to follow in the largest window"
                return trace
            if self._arrived(trace, end, s):
                trace.anchors[-1] = np.asarray(end, float)
                return trace
        trace.fault = f"the end corner was not reached in {max_steps} steps"
        return trace

    def _advance(self, trace, s, first):
        """Advance one step, in a window that grows until there is a next anchor."""
        settings = self.settings
        centre = trace.anchors[-1]
        for growths in range(settings.max_growths + 1):
            radius = settings.radius_scale * s * (1 + settings.growth) ** growths
            content = self._look(centre, radius, s)
            chosen = self._choose(trace, content.peaks.lines, s, first)
            anchor = None
            if chosen is not None:
                anchor = self._step_to(trace, content, chosen, s, first)
            if anchor is not None:
                break
        corners = self.layers.corners(centre, radius)
        trace.radii.append(radius)
        trace.candidates.append(corners)
        if anchor is None:
            return False
        trace.theta = float(content.peaks.lines[chosen, 1])
        trace.anchors.append(anchor)
        if self.record:
            lines = content.peaks.lines
            trace.steps.append(
                Step(
                    centre,
                    radius,
                    content.edges,
                    content.space,
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

    def _step_to(self, trace, content, chosen, s, first):
        band = max(self.settings.edge_band * s, self.settings.min_band_px)
        centre = trace.anchors[-1]
        if len(trace.anchors) == 1:
            away_from, direction = centre, first.along
        else:
            away_from = trace.anchors[-2]
            direction = centre - away_from
        line = content.peaks.lines[chosen]
        return next_anchor(content.edges, line, centre, band, away_from, direction)

    def _arrived(self, trace, end, s):
        """Whether the last step passed within t6 of the end corner."""
        (u, v), (to_u, to_v), (end_u, end_v) = (
            point.tolist() for point in (*trace.anchors[-2:], end)
        )
        du, dv = to_u - u, to_v - v
        share = ((end_u - u) * du + (end_v - v) * dv) / (du * du + dv * dv)
        share = min(max(share, 0.0), 1.0)
        nearest = u + share * du, v + share * dv
        return math.dist(nearest, (end_u, end_v)) < self.settings.arrival * s
