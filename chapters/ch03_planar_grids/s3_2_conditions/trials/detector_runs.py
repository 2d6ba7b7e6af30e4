"""Runs of the detectors on one image: click orders, and losses by merging."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from chapters.shared.grid_detectors import (
    CELECT,
    CLICK_SD_PX,
    CLICKLESS,
    LINEAR,
    OPENCV,
    OPENCV_SB,
    is_right,
    returned,
)
from chapters.shared.lattices import corner_areas, outer
from raxel.errors import InputError
from raxel.evaluation.board_scores import distances, in_order_of
from raxel.features.celect import along_contour, celect
from raxel.features.tone_curve import undo_srgb

NO_CLICKS = (OPENCV, OPENCV_SB, CLICKLESS)
NOT_RUN = "outer corner"
WRONG = "wrong corner returned"
DONE = "done"
# A point belongs to a corner within this share of its nearest neighbour's distance.
NEAR = 0.25


class Clicked(NamedTuple):
    """One run of CELECT: the order's true lattice, its result, and where it failed."""

    lattice: np.ndarray
    result: object
    stage: str

    @property
    def right(self):
        """Whether every corner is correct."""
        return self.stage == DONE


def draw_clicks(rng):
    """Return offsets (4, 2) px of the clicks on a clockwise lattice."""
    return rng.normal(0.0, CLICK_SD_PX, (4, 2))


def ordered(lattice, first, reverse=False):
    """Return the lattice as clicked from outer corner `first` (0 to 3) on.

    reverse: anticlockwise.
    """
    turned = np.rot90(lattice, first)
    return turned.transpose(1, 0, 2) if reverse else turned


def run(image, lattice, offsets, first=None, reverse=False):
    """Run CELECT from clicks at the true outer corners plus `offsets` (4, 2): Clicked.

    lattice: (rows, columns, 2), clockwise; first: the first clicked corner, by
    default that with the smallest square, as 3.3.2 advises.
    """
    if first is None:
        first = int(corner_areas(lattice).argmin())
    clicked = lattice.copy()
    clicked[[0, 0, -1, -1], [0, -1, -1, 0]] += offsets
    truth = ordered(lattice, first, reverse)
    rows, columns = truth.shape[:2]
    clicks = outer(ordered(clicked, first, reverse))
    try:
        result = celect(image, clicks, columns, rows)
    except InputError:
        return Clicked(truth, None, NOT_RUN)
    if not result.found:
        return Clicked(truth, result, result.failures[0].stage)
    right = is_right(result.corners.reshape(-1, 2), truth.reshape(-1, 2))
    return Clicked(truth, result, DONE if right else WRONG)


def detected(name, image, lattice):
    """Return whether a detector without clicks finds the lattice, from any corner.

    name: as in `grid_detectors`; lattice: true corners (rows, columns, 2).
    """
    rows, columns = lattice.shape[:2]
    corners = returned(name, image, columns, rows)
    if corners is None:
        return False
    truth = lattice.reshape(-1, 2)
    return is_right(in_order_of(truth, corners, columns, rows), truth)


def both_tones(image, lattice, offsets):
    """Run CELECT on an image as it is, and with its tone curve undone."""
    return tuple(run(tone, lattice, offsets) for tone in (image, undo_srgb(image)))


def every_detector(runs, image, lattice, others=NO_CLICKS):
    """Return whether CELECT, by `both_tones`, and others, without clicks, succeed."""
    clicked, linear = runs
    values = {CELECT: clicked.right, LINEAR: linear.right, "stage": clicked.stage}
    return values | {name: detected(name, image, lattice) for name in others}


def eight_orders(image, lattice, offsets):
    """Return where CELECT ends from every first corner, in both directions.

    For the image as it is, and (`linear_`) with its tone curve undone; rank 0
    starts at the smallest square.
    """
    areas = corner_areas(lattice)
    values = {"area_ratio": float(areas.max() / areas.min())}
    for tone, picture in {"": image, "linear_": undo_srgb(image)}.items():
        for reverse, way in ((False, "clockwise"), (True, "reverse")):
            for rank, first in enumerate(np.argsort(areas)):
                clicked = run(picture, lattice, offsets, int(first), reverse)
                values[f"{tone}{way}_{rank}"] = clicked.right
                values[f"{tone}{way}_{rank}_stage"] = clicked.stage
    return values


def merging(runs):
    """Return the effect of merging in `both_tones` of an image."""
    clicked, linear = runs
    return _merging(clicked) | {"linear": _merging(linear)}


def _merging(clicked):
    return {
        "size_ratio": size_variation(clicked.lattice),
        "merge_failed": merge_failed(clicked.result, clicked.lattice),
        "success": clicked.right,
        "stage": clicked.stage,
    }


def size_variation(lattice):
    """Return the largest ratio of the longest to the shortest step along one contour.

    lattice: (rows, columns, 2). Contours are the four sides and the columns, as
    CELECT follows them.
    """
    contours = [lattice[0], lattice[-1], *lattice.swapaxes(0, 1)]
    steps = [np.linalg.norm(np.diff(c, axis=0), axis=1) for c in contours]
    return float(max(s.max() / s.min() for s in steps))


def merge_failed(result, lattice):
    """Return whether merging lost or doubled a corner on a traced contour.

    result: CelectResult or None; lattice: (rows, columns, 2) in the order of
    clicks.
    """
    if result is None:
        return False
    reach = NEAR * nearest_distances(lattice)
    for contour in result.contours:
        truth = along_contour(contour.name, lattice)
        near = along_contour(contour.name, reach)
        if not len(contour.merged):
            continue
        before = claimed(contour.inliers, truth, near)
        after = claimed(contour.merged, truth, near)
        if ((before > 0) & (after == 0)).any() or (after > 1).any():
            return True
    return False


def claimed(points, truth, near):
    """Return how many points (m, 2) are within near (n,) of each corner (n, 2)."""
    return (distances(truth, points) <= near[:, None]).sum(axis=1)


def nearest_distances(lattice):
    """Return the distance (rows, columns) px of each corner to its neighbour."""
    flat = lattice.reshape(-1, 2)
    apart = distances(flat, flat)
    np.fill_diagonal(apart, np.inf)
    return apart.min(axis=1).reshape(lattice.shape[:2])
