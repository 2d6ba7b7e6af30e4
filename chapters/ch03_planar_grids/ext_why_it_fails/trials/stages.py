"""Which stage of CELECT lost a board: its trace held against the true one.

CELECT itself says only which contour failed. Here the truth is known, so the first
thing that went wrong along the contour can be named. Nothing of this goes back to
CELECT.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from chapters.shared.lattices import outer
from raxel.evaluation.board_scores import distances
from raxel.features.celect import along_contour

UNSEEN = "not in the picture"
DONE = "all corners right"
CLICK = "outer corner"
NO_EDGE = "no edge found"
TOO_LONG = "end not reached"
WRONG_EDGE = "wrong edge"
MISSED = "corner not detected"
THROWN_OUT = "corner thrown out"
MERGED = "corners merged"
FALSE = "false corner kept"
ORDER = "corner off its place"
# In the order in which a contour passes through them.
STAGES = (
    CLICK,
    NO_EDGE,
    TOO_LONG,
    WRONG_EDGE,
    MISSED,
    THROWN_OUT,
    MERGED,
    FALSE,
    ORDER,
)

NEAR = 0.25
"""A point is near a corner or a contour within this share of the nearest square."""

OFF_EDGE, OFF_EDGE_PX = 0.08, 3.0
"""An anchor is off its contour beyond this share of a square, and these px at least."""

DENSE = 24


class Lost(NamedTuple):
    """The stage that lost a board, the contour, and where: (2,) px."""

    stage: str
    contour: str = ""
    where: np.ndarray | None = None


def lost_at(result, coordinates, place, near_px=None):
    """The first thing that went wrong in a CelectResult: Lost.

    DONE if every corner was returned near its place, whatever the way there.

    coordinates: (rows, columns, 2), lattice points of the corners in the order of the
    clicks; place: lattice points (N, 2) -> true pixels (N, 2); near_px: how near a
    corner has to be, though never farther than half a square; a quarter of the
    nearest square if not given.
    """
    lattice = place(coordinates.reshape(-1, 2)).reshape(coordinates.shape)
    squares = spacing(lattice)
    reach = NEAR * squares
    if near_px is not None:
        reach = np.minimum(near_px, squares / 2)
    if (np.linalg.norm(result.corners - lattice, axis=2) <= reach).all():
        return Lost(DONE)
    ends, allowed = (outer(grid) for grid in (lattice, reach))
    off = np.linalg.norm(result.outer_corners - ends, axis=1)
    wrong = ~(off <= allowed)
    if wrong.any():
        first = int(wrong.argmax())
        return Lost(CLICK, f"corner {first + 1}", ends[first])
    for contour in result.contours:
        truth = along_contour(contour.name, lattice)
        near = along_contour(contour.name, reach)
        square = along_contour(contour.name, squares)
        stops = along_contour(contour.name, coordinates)
        lost = _lost_on(contour, truth, near, square, place(between(stops)))
        if lost:
            return lost
    return Lost(ORDER)


def spacing(lattice):
    """Distance (rows, columns) in px from every corner to its nearest neighbour."""
    nearest = np.full(lattice.shape[:2], np.inf)
    for axis in (0, 1):
        steps = np.linalg.norm(np.diff(lattice, axis=axis), axis=2)
        for side in (0, 1):
            pads = [(0, 0), (0, 0)]
            pads[axis] = (1, 0) if side else (0, 1)
            padded = np.pad(steps, pads, constant_values=np.inf)
            nearest = np.minimum(nearest, padded)
    return nearest


def between(stops):
    """Points (DENSE (n - 1) + 1, 2) along the pieces between lattice points (n, 2)."""
    along = np.linspace(0, len(stops) - 1, DENSE * (len(stops) - 1) + 1)
    index = np.arange(len(stops))
    return np.column_stack([np.interp(along, index, c) for c in stops.T])


def _lost_on(contour, truth, near, square, curve):
    """Lost on a contour with true corners (n, 2), or None.

    near (n,): px within which a point belongs to a corner; square (n,): px to the
    next corner; curve (m, 2): the true contour.
    """
    right = len(contour.merged) == len(truth)
    if right and _claimed(truth, near, contour.merged).all():
        return None
    off = np.maximum(OFF_EDGE * square, OFF_EDGE_PX)
    left = _left_at(contour.anchors, truth, off, curve)
    if left is not None:
        return Lost(WRONG_EDGE, contour.name, contour.anchors[left])
    if not len(contour.merged):
        # The window that led nowhere has a radius, and no anchor after it.
        stuck = len(contour.radii) == len(contour.anchors)
        stage = NO_EDGE if stuck else TOO_LONG
        return Lost(stage, contour.name, contour.anchors[-1])
    found = (contour.candidates, contour.inliers, contour.merged)
    for stage, points in zip((MISSED, THROWN_OUT, MERGED), found, strict=True):
        bare = ~_claimed(truth, near, points)
        # CELECT knows where a contour ends.
        bare[[0, -1]] &= stage == MERGED
        if bare.any():
            return Lost(stage, contour.name, truth[bare.argmax()])
    if len(contour.merged) > len(truth):
        return Lost(FALSE, contour.name, _spare(contour.merged, truth))
    return None


def _left_at(anchors, truth, allowed, curve):
    """Index of the anchor with which a trace left its contour, None if it did not.

    One anchor beside the contour is none: edges are rounded where they cross. Two in
    a row are, and of several such rows the last. allowed (n,): px that an anchor next
    to a corner may be off.
    """
    off = distances(anchors, curve).min(axis=1)
    nearest = distances(anchors, truth).argmin(axis=1)
    away = off > allowed[nearest]
    starts = away[:-1] & away[1:] & ~np.concatenate(([False], away[:-2]))
    return int(np.flatnonzero(starts)[-1]) if starts.any() else None


def _claimed(truth, near, points):
    """Which true corners (n,) have a point near."""
    return distances(truth, points).min(axis=1) <= near


def _spare(merged, truth):
    """The merged corner that is farthest from being the only one of a true corner."""
    off = distances(merged, truth)
    owner = off.argmin(axis=1)
    best = np.array([off[:, k].argmin() for k in range(len(truth))])
    extra = [i for i in range(len(merged)) if best[owner[i]] != i]
    return merged[extra[0]] if extra else merged[off.min(axis=1).argmax()]
