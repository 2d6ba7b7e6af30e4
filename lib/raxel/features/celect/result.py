"""What CELECT returns: the corners in order, or which contour failed and why."""

from typing import NamedTuple

import numpy as np

OUTER_CORNER = "outer corner"
TRACING = "tracing"
TOO_FEW = "too few corners"
TOO_MANY = "too many corners"


class ContourFailure(NamedTuple):
    """A contour that failed, at which stage, and why.

    `contour`: 'corner 1'..'corner 4' of the clicks, 'side 1'..'side 4', 'column 2'...
    `stage`: one of OUTER_CORNER, TRACING, TOO_FEW, TOO_MANY. `reason`: one line.
    `found`, `wanted`: numbers of corners.
    """

    contour: str
    stage: str
    reason: str
    found: int
    wanted: int


class ContourTrace(NamedTuple):
    """The trace of one contour: what was stepped through and what was found.

    anchors (n, 2) px, from end corner to end corner unless tracing failed. radii px of
    the window at each anchor but the last. s: the contour's length scale in px.
    candidates (m, 2): corners as detected. inliers (k, 2): those near the trace, with
    the two end corners. merged (j, 2): in order. steps: of `trace.Step`, if recorded.
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
    """The corners of a board in the order of the clicks.

    corners (rows, columns, 2) px (u, v): row 0 runs from the first click to the second,
    column 0 from the first to the fourth; nan where nothing was found. found: all of
    them are there. outer_corners (4, 2): the clicks after snapping, nan where there was
    no corner. failures: in the order in which they happened. contours: a ContourTrace
    for every contour that was traced.
    """

    found: bool
    corners: np.ndarray
    columns: int
    rows: int
    outer_corners: np.ndarray
    failures: tuple[ContourFailure, ...]
    contours: tuple[ContourTrace, ...]


def along_contour(name, lattice):
    """What a lattice (rows, columns, ...) has along one contour: (n, ...).

    `name` is that of a ContourTrace, 'side 1'..'side 4' or 'column 1'...; the lattice
    has a value for each corner, in the order of the clicks. Sides 1 and 3 are its first
    and last row, sides 2 and 4 its last and first column, in the order of the lattice.
    """
    kind, number = name.split()
    if kind == "column":
        return lattice[:, int(number) - 1]
    sides = lattice[0], lattice[:, -1], lattice[-1], lattice[:, 0]
    return sides[int(number) - 1]
