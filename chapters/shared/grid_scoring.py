"""Which corners of a found grid are right, and what lost those that are not."""

from __future__ import annotations

import numpy as np

from chapters.shared.scoring import LOST_PX, truth_of_contour
from raxel.features.celect import OUTER_CORNER, TOO_FEW, TRACING

HALF_WINDOW = 4
PRECISION_PX, MOST_STEPS = 0.1, 100
TRUTH, REFERENCE = "truth", "cornerSubPix from truth"
REFERENCES = (REFERENCE, TRUTH)
# Why a run of CELECT ended, from the contour that ended it.
DONE = "all corners right"
CONTOUR, SNAP = "contour lost", "outer corner not found"
MISSED, FALSE = "corner missed", "false corner"
MERGED, SPLIT = "corners merged", "corner split"
MISPLACED = "corner misplaced"


def localised(image, corners):
    """Corners (N, 2) after OpenCV's cornerSubPix, window 9 x 9, to 0.1 px."""
    import cv2

    criteria = cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT
    until = (criteria, MOST_STEPS, PRECISION_PX)
    start = np.ascontiguousarray(corners[:, None], dtype=np.float32)
    size = (HALF_WINDOW, HALF_WINDOW)
    return cv2.cornerSubPix(image, start, size, (-1, -1), until)[
        :, 0
    ].astype(float)


def is_right(corners, truth):
    """Whether every corner (N, 2) is next to its own true one, within 8 px."""
    if corners.shape != truth.shape or not np.isfinite(corners).all():
        return False
    apart = np.linalg.norm(corners[:, None] - truth[None], axis=2)
    own = np.arange(len(truth))
    near = apart[own, own] < LOST_PX
    return bool(near.all() and (apart.argmin(axis=1) == own).all())


def in_order_of(truth, corners, columns, rows):
    """Corners (N, 2) begun at that corner of the board which fits `truth` best.

    A detector without clicks may begin anywhere and go either way round.
    """
    lattice = np.asarray(corners, float).reshape(rows, columns, 2)
    turns = [
        lattice[::down, ::across].reshape(-1, 2)
        for down in (1, -1)
        for across in (1, -1)
    ]
    return min(turns, key=lambda c: np.linalg.norm(c - truth, axis=1).sum())


def from_smallest(lattice):
    """The lattice begun at the outer corner with the smallest square.

    lattice: (rows, columns, 2), clockwise in the picture; so is the answer,
    its rows and columns exchanged where it begins at the side of the other.
    """
    turned = [np.rot90(lattice, k) for k in range(4)]

    def area(turn):
        a, b, c, d = turn[0, 0], turn[0, 1], turn[1, 1], turn[1, 0]
        (px, py), (qx, qy) = c - a, d - b
        return abs(px * qy - py * qx) / 2

    return min(turned, key=area)


def errors_of(image, corners, truth):
    """Errors (N,) of a right grid before and after localisation, px."""
    after = localised(image, corners)
    standards = {TRUTH: truth, REFERENCE: localised(image, truth)}
    found = {}
    for name, standard in standards.items():
        key = "truth" if name == TRUTH else "reference"
        found[f"before_{key}"] = np.linalg.norm(corners - standard, axis=1)
        found[f"after_{key}"] = np.linalg.norm(after - standard, axis=1)
    return found


def cause_of(result, lattice):
    """Why a run of CELECT failed, told from its first failed contour.

    result: CelectResult; lattice: true corners (rows, columns, 2), in the
    order of the clicks.
    """
    if result.found:
        return MISPLACED
    failure = result.failures[0]
    if failure.stage == OUTER_CORNER:
        return SNAP
    if failure.stage == TRACING:
        return CONTOUR
    contour = next(c for c in result.contours if c.name == failure.contour)
    truth, _ = truth_of_contour(contour.name, lattice)
    near = nearness(truth)
    if failure.stage == TOO_FEW:
        seen = np.vstack([contour.inliers, contour.merged])
        missing = distances(truth, seen).min(axis=1) > near
        return MISSED if missing.any() else MERGED
    apart = distances(contour.merged, truth)
    strays = apart.min(axis=1) > near[apart.argmin(axis=1)]
    return FALSE if strays.any() else SPLIT


def nearness(truth):
    """How near a find must be to a true corner (n, 2) of a contour: (n,) px.

    8 px, or half the way to the next corner of the contour.
    """
    steps = np.linalg.norm(np.diff(truth, axis=0), axis=1)
    least = np.minimum(np.append(steps, np.inf), np.append(np.inf, steps))
    return np.minimum(LOST_PX, least / 2)


def distances(a, b):
    """Distances (n, m) between points (n, 2) and (m, 2); far where m is 0."""
    if not len(b):
        return np.full((len(a), 1), np.inf)
    return np.linalg.norm(a[:, None] - b[None], axis=2)
