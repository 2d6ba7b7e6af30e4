"""How far CELECT's corners are from the truth, and where a run was lost.

Only scores: CELECT itself is given the picture, the clicks and the counts.
"""

import numpy as np

from raxel.evaluation.board_scores import distances
from raxel.features.celect import along_contour

LOST_PX = 8.0
DONE = "done"
CORNER_OFF = "corner more than 8 px off"


def missing_on(contour, lattice):
    """(corners without a find within 8 px, those of them on the rim): counts.

    contour: ContourTrace; lattice: true corners (rows, columns, 2).
    """
    truth = along_contour(contour.name, lattice)
    lost = distances(truth, contour.merged).min(axis=1) > LOST_PX
    rim = np.ones(lattice.shape[:2], bool)
    rim[1:-1, 1:-1] = False
    on_rim = lost & along_contour(contour.name, rim)
    return int(lost.sum()), int(on_rim.sum())


def scored(result, lattice):
    """Values of one CELECT run, against the true lattice (rows, columns, 2).

    A run succeeds if every corner is returned within 8 px (3.3.1). `missed` counts
    corners of the contours it went along that are lost; `stage` says where the run
    was given up.
    """
    missed = np.array([missing_on(c, lattice) for c in result.contours])
    missed, on_rim = missed.sum(axis=0) if len(missed) else (0, 0)
    values = {"missed": int(missed), "missed_on_rim": int(on_rim), "success": False}
    if not result.found:
        first = result.failures[0]
        return values | {"stage": first.stage, "contour": first.contour}
    error = np.linalg.norm(result.corners - lattice, axis=2)
    success = bool(error.max() <= LOST_PX)
    stage = DONE if success else CORNER_OFF
    values |= {"success": success, "stage": stage, "contour": None}
    if success:
        values |= {"max_px": float(error.max()), "mean_px": float(error.mean())}
    return values
