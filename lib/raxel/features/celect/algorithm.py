"""CELECT: corner extraction by local edge contour tracing, section 3.1.2.

A. K. Dunne, Calibration of Non-Conventional Imaging Systems, DCU 2009. Input: four
clicks and two counts. Output: the corners of the board in order, without a model of the
distortion.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from raxel.errors import InputError
from raxel.features.celect.trace import (
    FirstLine,
    Scale,
    Tracer,
    clear_scale,
    corner_distances,
    harris_corners,
    mean_side,
    open_window,
    orientation,
    side_lengths,
    smoothing_for,
)
from raxel.features.detector import Detection, Partial, refine, rejected, verified

# All parameters of CELECT: those of the thesis, and those that it does not state.


@dataclass(frozen=True)
class CelectSettings:
    """Hold the values of Tables 3.1 and 3.2, the column rules, and the unstated values.

    A share is one of s, the contour's length scale in px. For side i, s is s_i of Table
    3.1; for a column, the window radius of the rule of the previous column (errata
    E-3.05). t1 and t2 take the number as Hough bins and degrees (E-3.02). Names that
    end in px or deg have that unit. An ablation is another value (`max_growths=0`,
    `split_peaks=0`, `wrap=0`).

    Attributes
    ----------
    radius_divisor, near_centre, edge_band, arrival, corner_band, merge
        Values of Tables 3.1 and 3.2; the last five are t3 and t5 to t8.
    split_peaks, wrap, first_angle_deg
        t1, t2 and t4 of Table 3.2.
    peaks : tuple[int, int]
        Least and largest number of Hough peaks in a window.
    column_radius
        Share of the mean side of the previous column.
    column_merge
        Share of the least distance of corners of the previous column.
    growth
        Share of the radius.
    smoothing
        Share of the smallest s_i.
    integration
        Share of the smoothing.
    harris_share, canny_high, canny_low
        Shares of what is clear in the clicked windows.
    min_vote_fraction
        Share of the votes of the first peak.

    References
    ----------
    Thesis 3.1.2, Tables 3.1 and 3.2.
    """

    # Table 3.1 and section 3.1.2: the window radius.
    radius_divisor: float = 1.9
    column_radius: float = 0.5
    growth: float = 0.2
    # Table 3.2.
    split_peaks: float = 0.5  # t1
    wrap: float = 0.125  # t2
    near_centre: float = 0.4  # t3
    first_angle_deg: float = 15.0  # t4
    edge_band: float = 0.1  # t5
    arrival: float = 0.56  # t6
    corner_band: float = 0.4  # t7
    merge: float = 0.8  # t8
    column_merge: float = 0.47
    peaks: tuple[int, int] = (2, 5)

    # Not stated in the thesis.
    radius_scale: float = 1.0
    max_growths: int = 4
    steps_per_square: int = 6
    smoothing: float = 0.085
    smoothing_limits_px: tuple[float, float] = (0.5, 1.5)
    integration: float = 1.0
    harris_k: float = 0.04
    harris_share: float = 0.1
    canny_high: float = 0.3
    canny_low: float = 0.12
    suppression_deg: int = 10
    suppression_radius: float = 0.2
    min_vote_fraction: float = 0.5
    min_band_px: float = 1.0


# Result of CELECT: the corners in order, or which contour failed and why.


OUTER_CORNER = "outer corner"
TRACING = "tracing"
TOO_FEW = "too few corners"
TOO_MANY = "too many corners"


class ContourFailure(NamedTuple):
    """Describe a contour that failed, at which stage, and why.

    Attributes
    ----------
    contour : str
        'corner 1'..'corner 4' of the clicks, 'side 1'..'side 4', 'column 2'...
    stage : str
        One of OUTER_CORNER, TRACING, TOO_FEW, TOO_MANY.
    reason : str
        One line.
    found, wanted : int
        Numbers of corners.
    """

    contour: str
    stage: str
    reason: str
    found: int
    wanted: int


class ContourTrace(NamedTuple):
    """Hold the trace of one contour: its windows and its corners.

    Attributes
    ----------
    name : str
        Name of the contour, as of `along_contour`.
    anchors : np.ndarray
        (n, 2) px, from end corner to end corner unless tracing failed.
    radii : np.ndarray
        Radius in px of the window at each anchor but the last.
    s : float
        Length scale of the contour in px.
    candidates : np.ndarray
        (m, 2) px, corners as detected.
    inliers : np.ndarray
        (k, 2) px, those near the trace, with the two end corners.
    merged : np.ndarray
        (j, 2) px, the corners in order.
    steps : tuple
        `trace.Step` of each window, if recorded.
    """

    name: str
    anchors: np.ndarray
    radii: np.ndarray
    s: float
    candidates: np.ndarray
    inliers: np.ndarray
    merged: np.ndarray
    steps: tuple = ()


class CelectResult(NamedTuple):
    """Hold the corners of a board in the order of the clicks.

    Attributes
    ----------
    found : bool
        Whether all corners were found.
    corners : np.ndarray
        (rows, columns, 2) px (u, v), NaN where nothing was found. Row 0 runs from the
        first click to the second, column 0 from the first to the fourth.
    columns, rows : int
        Numbers of corners per row and per column.
    outer_corners : np.ndarray
        (4, 2) px, the clicks after snapping, NaN where there was no corner.
    failures : tuple[ContourFailure, ...]
        In the order in which they happened.
    contours : tuple[ContourTrace, ...]
        One for every contour that was traced.
    """

    found: bool
    corners: np.ndarray
    columns: int
    rows: int
    outer_corners: np.ndarray
    failures: tuple[ContourFailure, ...]
    contours: tuple[ContourTrace, ...]


def along_contour(name: str, lattice: np.ndarray) -> np.ndarray:
    """Return the values of a lattice along one contour.

    Sides 1 and 3 are its first and last row, sides 2 and 4 its last and first column,
    in the order of the lattice.

    Parameters
    ----------
    name : str
        Name of a ContourTrace, 'side 1'..'side 4' or 'column 1'...
    lattice : np.ndarray
        (rows, columns, ...), a value for each corner, in the order of the clicks.

    Returns
    -------
    np.ndarray
        (n, ...) values.

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.features.celect import along_contour
    >>> along_contour("side 2", np.arange(6).reshape(2, 3)).tolist()
    [2, 5]
    """
    kind, number = name.split()
    if kind == "column":
        return lattice[:, int(number) - 1]
    sides = lattice[0], lattice[:, -1], lattice[-1], lattice[:, 0]
    return sides[int(number) - 1]


# Corner processing: from the candidates along a contour to its corners in order.


class Processed(NamedTuple):
    """Hold the corners of a contour.

    Attributes
    ----------
    inliers : np.ndarray
        (m, 2) px, those of the candidates near the trace.
    merged : np.ndarray
        (k, 2) px, the corners in order.
    """

    inliers: np.ndarray
    merged: np.ndarray


def processed(
    candidates: np.ndarray, anchors: np.ndarray, band: float, distance: float
) -> Processed:
    """Return the corners of a contour, in order from its first end to its last.

    The thesis does not state what happens to a corner beyond either end corner, along
    the first or last piece of the trace: it is dropped here.

    Parameters
    ----------
    candidates : np.ndarray
        (n, 2) px.
    anchors : np.ndarray
        (m, 2) px along the contour, its two end corners first and last; these count as
        candidates too.
    band, distance : float
        px, t7 and t8.

    Returns
    -------
    Processed
        The corners.
    """
    ends = anchors[[0, -1]]
    everything = np.vstack((ends, candidates)) if len(candidates) else ends
    everything = distinct(everything)
    inliers = everything[distance_to_trace(everything, anchors) < band]
    labels = average_close(inliers, distance)
    labels = np.unique(labels, return_inverse=True)[1]
    size = np.bincount(labels)
    merged = np.column_stack([np.bincount(labels, c) / size for c in inliers.T])
    first, last = (labels[(inliers == end).all(axis=1).argmax()] for end in ends)
    position = position_along(merged, anchors)
    kept = (position >= position[first]) & (position <= position[last])
    order = np.argsort(position[kept], kind="stable")
    return Processed(inliers, merged[kept][order])


def distinct(points):
    """Points (n, 2) without repetitions, by rising u, then v."""
    ordered = points[np.lexsort(points.T[::-1])]
    new = np.ones(len(points), bool)
    new[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    return ordered[new]


def distance_to_trace(points, anchors):
    """Distance (n,) in px to the line through the two nearest anchors, (3.20-22)."""
    distance = np.linalg.norm(points[:, None] - anchors[None], axis=2)
    nearest = np.argsort(distance, axis=1, kind="stable")[:, :2]
    a, b = anchors[nearest[:, 0]], anchors[nearest[:, 1]]
    along = b - a
    length = np.maximum(np.linalg.norm(along, axis=1), np.finfo(float).tiny)
    across = points - a
    return np.abs(along[:, 0] * across[:, 1] - along[:, 1] * across[:, 0]) / length


def position_along(points, anchors):
    """Arc length (n,) in px of points (n, 2) projected on the trace (m, 2).

    Each point is projected on the nearest segment of the trace. The first and the last
    segment are extended: a point there has a negative position, or one above the whole
    length.
    """
    pieces = np.diff(anchors, axis=0)
    lengths = np.linalg.norm(pieces, axis=1)
    real = lengths > 0
    starts, pieces, lengths = anchors[:-1][real], pieces[real], lengths[real]
    before = np.concatenate(([0.0], np.cumsum(lengths)[:-1]))
    units = pieces / lengths[:, None]
    along = np.einsum("nmk,mk->nm", points[:, None] - starts[None], units)
    low, high = np.zeros_like(lengths), lengths.copy()
    low[0], high[-1] = -np.inf, np.inf
    along = np.clip(along, low, high)
    nearest = starts[None] + along[..., None] * units[None]
    piece = np.linalg.norm(points[:, None] - nearest, axis=2).argmin(axis=1)
    return before[piece] + along[np.arange(len(points)), piece]


def average_close(corners, distance):
    """Labels (n,) of groups of corners (n, 2) px within `distance` of each other.

    The rule of t8: a chain of close corners is one corner (single linkage).
    """
    close = np.linalg.norm(corners[:, None] - corners[None], axis=2) < distance
    labels = np.arange(len(corners))
    while True:
        lowest = np.where(close, labels, len(corners)).min(axis=1)
        if (lowest == labels).all():
            return labels
        labels = lowest


# Validation of the user's input: image, clicks, counts, contours by hand.


MIN_N_CORNERS = 2
MIN_SQUARE_PX = 3.0


def checked_image(image):
    """The image as a grey array (h, w) of uint8 or uint16, or InputError."""
    image = np.asarray(image)
    if image.ndim != 2 or image.dtype not in (np.uint8, np.uint16) or not image.size:
        raise InputError(
            f"image: found an array of shape {image.shape} and type "
            f"{image.dtype}; give grey levels (height, width), 8 or 16 bit"
        )
    return image


def checked_count(name, value):
    """A count of corners as an int, or InputError."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer):
        raise InputError(f"{name}: found {value!r}; give a whole number of corners")
    if value < MIN_N_CORNERS:
        raise InputError(
            f"{name}: found {value}; give at least {MIN_N_CORNERS} corners"
        )
    return int(value)


def checked_points(name, points, count, image):
    """Points (count, 2) float64 inside the image, or InputError."""
    try:
        array = np.array(points, dtype=float)
    except (TypeError, ValueError, OverflowError):
        array = np.empty(0)
    if array.shape != (count, 2) or not np.isfinite(array).all():
        raise InputError(
            f"{name}: found shape {array.shape}; give {count} finite points (u, v)"
        )
    height, width = image.shape
    beyond = (array < -0.5) | (array > (width - 0.5, height - 0.5))
    if beyond.any():
        index = int(beyond.any(axis=1).argmax())
        u, v = array[index]
        raise InputError(
            f"{name}[{index}]: found ({u:g}, {v:g}), outside the image of {width} "
            f"x {height} px; give points inside"
        )
    return array


def checked_clicks(outer_corners, columns, rows, image):
    """The four clicks (4, 2), around the board and not too close, or InputError."""
    clicks = checked_points("outer_corners", outer_corners, 4, image)
    if _cross(*clicks) or _cross(*np.roll(clicks, 1, axis=0)):
        raise InputError(
            "outer_corners: two sides cross; give the four corners in order "
            "around the board"
        )
    sides = np.linalg.norm(np.roll(clicks, -1, axis=0) - clicks, axis=1)
    squares = sides / (np.array([columns, rows, columns, rows]) - 1)
    if squares.min() < MIN_SQUARE_PX:
        raise InputError(
            f"outer_corners: found a side with squares of {squares.min():.2g} px; "
            f"give corners of a board with squares of at least {MIN_SQUARE_PX:g} "
            "px"
        )
    return clicks


def checked_contours(given, columns, rows, image):
    """Corners by hand, {contour: (n, 2)}, of known names and counts, or InputError."""
    counts = contour_counts(columns, rows)
    checked = {}
    for name, points in (given or {}).items():
        if name not in counts:
            raise InputError(
                f"given_contours: found {name!r}; give one of {', '.join(counts)}"
            )
        field = f"given_contours[{name!r}]"
        checked[name] = checked_points(field, points, counts[name], image)
    return checked


def contour_counts(columns, rows):
    """How many corners each contour has, {name: count}, in the order of tracing."""
    counts = {f"side {i}": (columns, rows)[(i - 1) % 2] for i in range(1, 5)}
    return counts | {f"column {k}": rows for k in range(2, columns)}


def _cross(a, b, c, d):
    """Whether the segments ab and cd cross."""
    return _turn(a, b, c) * _turn(a, b, d) < 0 and _turn(c, d, a) * _turn(c, d, b) < 0


def _turn(a, b, c):
    (x, y), (p, q) = b - a, c - a
    return x * q - y * p


PUBLISHED = CelectSettings()


def celect(
    image: ArrayLike,
    outer_corners: ArrayLike,
    columns: int,
    rows: int,
    *,
    settings: CelectSettings = PUBLISHED,
    given_contours: Mapping[str, ArrayLike] | None = None,
    record: bool = False,
) -> CelectResult:
    """Find the corners of a chessboard, in order, from four clicks and two counts.

    Parameters
    ----------
    image : ArrayLike
        (height, width) grey levels, uint8 or uint16.
    outer_corners : ArrayLike
        (4, 2) px (u, v), the user's clicks on corners (row 0, column 0), (0, last),
        (last, last), (last, 0). They are clockwise on a board that is not mirrored. A
        board in a mirror may be clicked in either sense, and the order of the result is
        that of the clicks. They need not be the outermost corners: four inner ones give
        that part of the board.
    columns, rows : int
        Corners per row and per column, both ends included.
    settings : CelectSettings
        Values of the algorithm.
    given_contours : Mapping, optional
        {'side 1'..'side 4', 'column 2'...: (n, 2) px}, corners by hand of contours that
        failed, in either direction. They are not traced.
    record : bool
        Keep every window (`ContourTrace.steps`).

    Returns
    -------
    CelectResult
        The corners. A contour that fails is named there, with the reason.

    Raises
    ------
    InputError
        `bad-input` for an image that is not grey, for clicks outside it, crossing or
        too close, for invalid counts, and for contours that do not exist.

    References
    ----------
    Thesis 3.1.2.

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.features.celect import celect
    >>> squares = np.indices((5, 6)).sum(axis=0) % 2
    >>> board = np.kron(squares, np.ones((30, 30)))
    >>> image = np.pad(255 * board, 40, constant_values=255).astype(np.uint8)
    >>> clicks = [[70, 70], [190, 70], [190, 160], [70, 160]]
    >>> result = celect(image, clicks, 5, 4)
    >>> result.found, result.corners.shape
    (True, (4, 5, 2))
    """
    image = checked_image(image)
    columns, rows = checked_count("columns", columns), checked_count("rows", rows)
    clicks = checked_clicks(outer_corners, columns, rows, image)
    given = checked_contours(given_contours, columns, rows, image)
    scale, corners = snapped(image, clicks, columns, rows, settings)  # type: ignore[arg-type]
    run = _Run(image, scale, corners, columns, rows, settings, given, record)
    if np.isfinite(corners).all():
        run.trace_sides()
        run.trace_columns()
    else:
        run.name_lost_corners(clicks)
    return run.result()


def snapped(
    image: np.ndarray,
    clicks: np.ndarray,
    columns: int,
    rows: int,
    settings: CelectSettings,
) -> tuple[Scale, np.ndarray]:
    """Return the Scale of an image and the detected corners nearest to the clicks.

    A corner is searched for in a window with the smaller radius of the two sides that
    meet there.

    Parameters
    ----------
    image : np.ndarray
        (height, width) grey levels.
    clicks : np.ndarray
        (4, 2) px (u, v).
    columns, rows : int
        Corners per row and per column.
    settings : CelectSettings
        Values of the algorithm.

    Returns
    -------
    scale : Scale
        Clear gradient and response of the image.
    corners : np.ndarray
        (4, 2) px, the corners c_i; NaN where a window has none.
    """
    s = side_lengths(clicks, columns, rows, settings.radius_divisor)
    radii = np.minimum(s, np.roll(s, 1))
    smoothing = smoothing_for(s.min(), settings)
    windows = [
        open_window(image, click, radius, smoothing)
        for click, radius in zip(clicks, radii, strict=True)
    ]
    scale = clear_scale(windows, smoothing, settings)
    corners = np.full((4, 2), np.nan)
    if not (scale.gradient > 0 and scale.response > 0):
        return scale, corners
    for i, window in enumerate(windows):
        found = harris_corners(window, scale, settings)
        if len(found):
            distance = np.linalg.norm(found - clicks[i], axis=1)
            corners[i] = found[distance.argmin()]
    return scale, corners


class _Run:
    """One run: the grid as it fills, contour after contour."""

    def __init__(self, image, scale, outer, columns, rows, settings, given, record):
        self.tracer = Tracer(image, scale, settings, record)
        self.settings = settings
        self.outer = outer
        self.columns, self.rows = columns, rows
        self.counts = contour_counts(columns, rows)
        self.given = given
        self.grid = np.full((rows, columns, 2), np.nan)
        self.failures, self.contours = [], []

    def result(self):
        """The CelectResult of the current state."""
        found = not self.failures and bool(np.isfinite(self.grid).all())
        return CelectResult(
            found,
            self.grid,
            self.columns,
            self.rows,
            self.outer,
            tuple(self.failures),
            tuple(self.contours),
        )

    def name_lost_corners(self, clicks):
        """Add a failure for every click without a corner nearby."""
        for i in np.flatnonzero(np.isnan(self.outer[:, 0])):
            u, v = clicks[i]
            reason = f"no corner near the click at ({u:.0f}, {v:.0f})"
            self._fail(f"corner {i + 1}", OUTER_CORNER, reason, 0, 1)

    def trace_sides(self):
        """The four outer contours, clockwise from the first corner."""
        c = self.outer
        s = side_lengths(c, self.columns, self.rows, self.settings.radius_divisor)
        self.s_4 = s[3]
        theta, sides = None, []
        for i in range(4):
            start, end, before = c[i], c[(i + 1) % 4], c[i - 1]
            known = theta is not None
            wrong = theta if known else orientation(start - before)
            first = FirstLine(wrong, known, end - start)
            corners, theta = self._contour(
                f"side {i + 1}", start, end, s[i], first, self.settings.merge * s[i]
            )
            sides.append(corners)
        self._place_sides(sides)

    def trace_columns(self):
        """The columns between sides 4 and 2, from the top down."""
        top, bottom = self.grid[0], self.grid[-1]
        previous = self._complete(0)
        for k in range(1, self.columns - 1):
            name = f"column {k + 1}"
            if name not in self.given and np.isnan((top, bottom)).any():
                reason = "side 1 or side 3 failed, so that its ends are unknown"
                self._fail(name, TRACING, reason, 0, self.rows)
                continue
            s, distance = self._column_scale(previous)
            wrong = orientation(top[k + 1] - top[k - 1])
            first = FirstLine(wrong, True, bottom[k] - top[k])
            corners, _ = self._contour(name, top[k], bottom[k], s, first, distance)
            if corners is not None:
                inner = slice(None) if name in self.given else slice(1, -1)
                self.grid[inner, k] = corners[inner]
                previous = self.grid[:, k]

    def _column_scale(self, previous):
        """s and the merging distance in px of a column from the previous one.

        Without a previous column, those of the side at its position.
        """
        if previous is None:
            return self.s_4, self.settings.merge * self.s_4
        s = mean_side(previous, self.settings)
        return s, self.settings.column_merge * corner_distances(previous).min()

    def _complete(self, k):
        column = self.grid[:, k]
        return column if np.isfinite(column).all() else None

    def _contour(self, name, start, end, s, first, distance):
        """Corners (n, 2) of a contour, or None, and theta at its end, or None."""
        wanted = self.counts[name]
        if name in self.given:
            corners = _from_start(self.given[name], start)
            return corners, orientation(corners[-1] - corners[-2])
        trace = self.tracer.trace(start, end, s, first, wanted - 1)
        anchors, candidates = np.array(trace.anchors), np.vstack(trace.candidates)
        nothing = np.empty((0, 2))
        inliers, merged = nothing, nothing
        if not trace.fault:
            inliers, merged = processed(
                candidates, anchors, self.settings.corner_band * s, distance
            )
        self.contours.append(
            ContourTrace(
                name,
                anchors,
                np.array(trace.radii),
                s,
                distinct(candidates),
                inliers,
                merged,
                tuple(trace.steps),
            )
        )
        if trace.fault:
            self._fail(name, TRACING, trace.fault, 0, wanted)
            return None, None
        if len(merged) != wanted:
            self._fail_count(name, len(merged), wanted)
            return None, trace.theta
        return merged, trace.theta

    def _place_sides(self, sides):
        """Put the sides into the grid; a corner of two sides is the mean of both."""
        side_cells = (
            (0, slice(None)),
            (slice(None), -1),
            (-1, slice(None, None, -1)),
            (slice(None, None, -1), 0),
        )
        total, times = np.zeros_like(self.grid), np.zeros(self.grid.shape[:2])
        for cells, corners in zip(side_cells, sides, strict=True):
            if corners is not None:
                total[cells] += corners
                times[cells] += 1
        placed = times > 0
        self.grid[placed] = total[placed] / times[placed][:, None]

    def _fail_count(self, name, found, wanted):
        stage = TOO_FEW if found < wanted else TOO_MANY
        reason = f"{found} corners along the trace, expected {wanted}"
        self._fail(name, stage, reason, found, wanted)

    def _fail(self, *failure):
        self.failures.append(ContourFailure(*failure))


def _from_start(corners, start):
    """Corners (n, 2) by hand in the direction of the trace: from `start` on."""
    first, last = np.linalg.norm(corners[[0, -1]] - start, axis=1)
    return corners if first <= last else corners[::-1]


# CELECT as a detector of an image set: clicks from set.yaml, corners refined.


def find_celect(
    image: np.ndarray,
    columns: int | None,
    rows: int | None,
    outer_corners: ArrayLike | None,
    contours: Iterable[tuple[str, ArrayLike]] = (),
) -> Detection:
    """Detect the board between four clicks by CELECT and refine its corners.

    The refinement is that of OpenCV's corners, `refine`.

    Parameters
    ----------
    image : np.ndarray
        (height, width) grey levels, uint8 or uint16.
    columns, rows : int or None
        Numbers of interior corners. They must be known: without them the result is a
        rejected Detection.
    outer_corners : ArrayLike or None
        (4, 2) px (u, v), clockwise; None without clicks.
    contours : Iterable
        (name, points) pairs of contours by hand.

    Returns
    -------
    Detection
        The board. A rejected one has the ordered part, and names the contour that
        failed.

    Raises
    ------
    InputError
        `bad-input`, as `celect`.
    """
    if columns is None or rows is None:
        reason = "celect requires target.columns and target.rows"
        return rejected(columns, rows, reason)
    if outer_corners is None:
        return rejected(columns, rows, "celect requires outer_corners, the four clicks")
    given = {name: np.array(points) for name, points in contours}
    result = celect(image, outer_corners, columns, rows, given_contours=given)
    if not result.found:
        return _with_part(result)
    corners = refine(image, result.corners.reshape(-1, 2), columns, rows)
    return verified(corners, columns, rows, image)


def _with_part(result):
    first = result.failures[0]
    reason = f"{first.contour}: {first.stage}: {first.reason}"
    if first.contour == "side 1" and first.found == result.rows != first.wanted:
        reason += "; the second click must be at the other end of the first row"
    detection = rejected(result.columns, result.rows, reason)
    known = np.isfinite(result.corners[..., 0])
    if not known.any():
        return detection
    part = Partial(result.corners[known], np.argwhere(known))
    return detection._replace(partial=part)
