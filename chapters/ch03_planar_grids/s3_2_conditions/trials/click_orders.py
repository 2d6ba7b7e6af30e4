"""The orders in which a user may click four outer corners, and what counts as right."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from chapters.shared.grid_scoring import in_order_of, is_right
from chapters.shared.grid_trials import CLICK_SD_PX, returned
from chapters.shared.grid_views import outer
from raxel.errors import InputError
from raxel.features.celect import celect

NOT_RUN = "outer corner"
WRONG = "wrong corner returned"
DONE = "done"


class Clicked(NamedTuple):
    """One run of CELECT: the order's true lattice, its result, where it was lost."""

    lattice: np.ndarray
    result: object
    stage: str

    @property
    def right(self):
        """Whether every corner is right."""
        return self.stage == DONE


def draw_clicks(rng):
    """Offsets (4, 2) px of the clicks on the outer corners of a clockwise lattice."""
    return rng.normal(0.0, CLICK_SD_PX, (4, 2))


def ordered(lattice, first, reverse=False):
    """The lattice as it is when clicked from outer corner `first` (0 to 3) on.

    reverse: the other way round.
    """
    turned = np.rot90(lattice, first)
    return turned.transpose(1, 0, 2) if reverse else turned


def corner_areas(lattice):
    """Area (4,) in px² of the squares at the four outer corners."""
    rows, columns = lattice.shape[:2]
    areas = []
    for r, c in (
        (0, 0),
        (0, columns - 2),
        (rows - 2, columns - 2),
        (rows - 2, 0),
    ):
        a, b = lattice[r, c], lattice[r, c + 1]
        d, e = lattice[r + 1, c], lattice[r + 1, c + 1]
        (x, y), (p, q) = e - a, d - b
        areas.append(abs(x * q - y * p) / 2)
    return np.array(areas)


def run(image, lattice, offsets, first=None, reverse=False):
    """CELECT from clicks at the true outer corners plus `offsets` (4, 2): Clicked.

    lattice: (rows, columns, 2), clockwise; first: where the clicks begin; by default
    at the corner with the smallest square, as 3.3.2 advises.
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
    """Whether a detector without clicks has the lattice, from whichever corner.

    name: as in `grid_trials.METHODS`; lattice: true corners (rows, columns, 2).
    """
    rows, columns = lattice.shape[:2]
    corners = returned(name, image, columns, rows)
    if corners is None:
        return False
    truth = lattice.reshape(-1, 2)
    return is_right(in_order_of(truth, corners, columns, rows), truth)
