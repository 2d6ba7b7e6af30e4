"""How far CELECT's corners are from the truth, and where a run was lost.

Only scores: CELECT itself is given the picture, the clicks and the counts.
"""

from __future__ import annotations

import numpy as np

LOST_PX = 8.0
DONE = "done"
CORNER_OFF = "corner more than 8 px off"


def truth_of_contour(name, lattice):
    """True corners (n, 2) of a contour, and whether each is on the board's rim.

    lattice: (rows, columns, 2). Names as `CelectResult.contours` has them.
    """
    kind, number = name.split()
    number = int(number)
    if kind == "side":
        row_wise = (lattice[0], lattice[:, -1], lattice[-1], lattice[:, 0])
        corners = row_wise[number - 1]
        return corners, np.ones(len(corners), bool)
    rim = np.zeros(len(lattice), bool)
    rim[[0, -1]] = True
    return lattice[:, number - 1], rim


def missing_on(contour, lattice):
    """(corners without a find within 8 px, those of them on the rim): counts."""
    truth, rim = truth_of_contour(contour.name, lattice)
    if not len(contour.merged):
        return len(truth), int(rim.sum())
    apart = np.linalg.norm(truth[:, None] - contour.merged[None], axis=2)
    lost = apart.min(axis=1) > LOST_PX
    return int(lost.sum()), int((lost & rim).sum())


def scored(result, lattice):
    """Values of one CELECT run, against the true lattice (rows, columns, 2).

    A run succeeds if every corner is returned within 8 px (3.3.1). `missed` counts
    corners of the contours it went along that are lost; `stage` says where the run
    was given up.
    """
    missed = np.array([missing_on(c, lattice) for c in result.contours])
    missed, on_rim = missed.sum(axis=0) if len(missed) else (0, 0)
    values = {
        "missed": int(missed),
        "missed_on_rim": int(on_rim),
        "success": False,
    }
    if not result.found:
        first = result.failures[0]
        return values | {"stage": first.stage, "contour": first.contour}
    error = np.linalg.norm(result.corners - lattice, axis=2)
    success = bool(error.max() <= LOST_PX)
    stage = DONE if success else CORNER_OFF
    values |= {"success": success, "stage": stage, "contour": None}
    if success:
        values |= {
            "max_px": float(error.max()),
            "mean_px": float(error.mean()),
        }
    return values
