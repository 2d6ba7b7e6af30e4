"""How far CELECT's corners are from the truth, and where a run was lost.

Only scores: CELECT itself is given the picture, the clicks and the counts.
"""

import numpy as np

LOST_PX = 8.0


def scored(result, lattice):
    """Values of one CELECT run, against the true lattice (rows, columns, 2).

    A run succeeds if every corner is returned within 8 px (3.3.1).
    """
    if not result.found:
        return {"success": False}
    error = np.linalg.norm(result.corners - lattice, axis=2)
    if error.max() > LOST_PX:
        return {"success": False}
    return {
        "success": True,
        "max_px": float(error.max()),
        "mean_px": float(error.mean()),
    }
