"""Corner processing: from the candidates along a contour to its corners in order."""

from typing import NamedTuple

import numpy as np


class Processed(NamedTuple):
    """Corners of a contour: `inliers` (m, 2) of the candidates, `merged` (k, 2)."""

    inliers: np.ndarray
    merged: np.ndarray


def processed(candidates, anchors, band, distance):
    """The corners of a contour, in order from its first end to its last.

    Parameters
    ----------
    candidates : (n, 2) px. anchors : (m, 2) px along the contour, its two end corners
        first and last; these count as candidates too.
    band, distance : px, t7 and t8.

    What the thesis leaves open: a corner that lies beyond either end corner, along the
    first or last piece of the trace, is dropped.
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
    place = position_along(merged, anchors)
    kept = (place >= place[first]) & (place <= place[last])
    order = np.argsort(place[kept], kind="stable")
    return Processed(inliers, merged[kept][order])


def distinct(points):
    """Points (n, 2) without repetitions, by rising u, then v."""
    ordered = points[np.lexsort(points.T[::-1])]
    new = np.ones(len(points), bool)
    new[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    return ordered[new]


def distance_to_trace(points, anchors):
    """Distance (n,) in px to the line through the two nearest anchors, (3.20-22)."""
    off = np.linalg.norm(points[:, None] - anchors[None], axis=2)
    nearest = np.argsort(off, axis=1, kind="stable")[:, :2]
    a, b = anchors[nearest[:, 0]], anchors[nearest[:, 1]]
    along = b - a
    length = np.maximum(np.linalg.norm(along, axis=1), np.finfo(float).tiny)
    across = points - a
    return np.abs(along[:, 0] * across[:, 1] - along[:, 1] * across[:, 0]) / length


def position_along(points, anchors):
    """Arc length (n,) in px at which points (n, 2) lie along the trace (m, 2).

    Of the trace's pieces the nearest counts. The first and the last piece go on beyond
    the ends: a point there has a negative position, or one above the whole length.
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
        least = np.where(close, labels, len(corners)).min(axis=1)
        if (least == labels).all():
            return labels
        labels = least
