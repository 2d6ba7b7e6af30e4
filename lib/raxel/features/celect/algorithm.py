"""CELECT: corner extraction by local edge contour tracing, section 3.1.2.

A. K. Dunne, Calibration of Non-Conventional Imaging Systems, DCU 2009. Four clicks and
two counts go in; the corners of the board come out in order, without any model of how
the camera bends the image.
"""

import numpy as np

from raxel.features.celect.hough import orientation
from raxel.features.celect.processing import distinct, processed
from raxel.features.celect.radius import corner_distances, mean_side, side_lengths
from raxel.features.celect.result import (
    OUTER_CORNER,
    TOO_FEW,
    TOO_MANY,
    TRACING,
    CelectResult,
    ContourFailure,
    ContourTrace,
)
from raxel.features.celect.settings import CelectSettings
from raxel.features.celect.trace import FirstLine, Tracer
from raxel.features.celect.user_input import (
    checked_clicks,
    checked_contours,
    checked_count,
    checked_image,
    contour_counts,
)
from raxel.features.celect.window import (
    clear_scale,
    harris_corners,
    open_window,
    smoothing_for,
)

PUBLISHED = CelectSettings()


def celect(
    image,
    outer_corners,
    columns,
    rows,
    *,
    settings=PUBLISHED,
    given_contours=None,
    record=False,
):
    """The corners of a chessboard, in order, from four clicks and two counts.

    Parameters
    ----------
    image : (height, width) grey, uint8 or uint16.
    outer_corners : (4, 2) px (u, v), the user's clicks on corners (row 0, column 0),
        (0, last), (last, last), (last, 0). Clockwise on a board that is seen the right
        way round; a board seen in a mirror may be clicked either way round, and the
        order of the result is that of the clicks. They need not be the outermost
        corners: four inner ones give that part of the board.
    columns, rows : corners per row and per column, both ends included.
    settings : a CelectSettings.
    given_contours : {'side 1'..'side 4', 'column 2'...: (n, 2) px}, corners by hand of
        contours that failed; either direction. They are not traced.
    record : keep every window (`ContourTrace.steps`).

    Returns a CelectResult; a contour that fails is named there, with the reason. Raises
    InputError for an image that is not grey, for clicks outside it, crossing or too
    close, for counts that are none, and for contours that do not exist.
    """
    image = checked_image(image)
    columns, rows = checked_count("columns", columns), checked_count("rows", rows)
    clicks = checked_clicks(outer_corners, columns, rows, image)
    given = checked_contours(given_contours, columns, rows, image)
    scale, corners = snapped(image, clicks, columns, rows, settings)
    run = _Run(image, scale, corners, columns, rows, settings, given, record)
    if np.isfinite(corners).all():
        run.trace_sides()
        run.trace_columns()
    else:
        run.name_lost_corners(clicks)
    return run.result()


def snapped(image, clicks, columns, rows, settings):
    """The detected corners c_i (4, 2) nearest to the clicks (4, 2), and the Scale.

    A corner is looked for in a window with the smaller radius of the two sides that
    meet there; nan if it has none.
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
            off = np.linalg.norm(found - clicks[i], axis=1)
            corners[i] = found[off.argmin()]
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
        """The CelectResult of what is there."""
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
        """A failure for every click without a corner nearby."""
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
            distance = self.settings.merge * s[i]
            corners, theta = self._contour(
                f"side {i + 1}", start, end, s[i], first, distance
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
                reason = "side 1 or side 3 failed, so its ends are not known"
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

        Without a previous column, those of the side where it would have been.
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
        """The sides into the grid; a corner of two sides is the mean of both."""
        places = (
            (0, slice(None)),
            (slice(None), -1),
            (-1, slice(None, None, -1)),
            (slice(None, None, -1), 0),
        )
        total, times = np.zeros_like(self.grid), np.zeros(self.grid.shape[:2])
        for place, corners in zip(places, sides, strict=True):
            if corners is not None:
                total[place] += corners
                times[place] += 1
        placed = times > 0
        self.grid[placed] = total[placed] / times[placed][:, None]

    def _fail_count(self, name, found, wanted):
        stage = TOO_FEW if found < wanted else TOO_MANY
        reason = f"{found} corners along the trace, {wanted} are wanted"
        self._fail(name, stage, reason, found, wanted)

    def _fail(self, *failure):
        self.failures.append(ContourFailure(*failure))


def _from_start(corners, start):
    """Corners (n, 2) by hand in the direction of the trace: from `start` on."""
    first, last = np.linalg.norm(corners[[0, -1]] - start, axis=1)
    return corners if first <= last else corners[::-1]
