"""Boards that are all parallel leave the camera open, whatever a fit says."""

import numpy as np

from raxel.errors import CalibrationError

SMALLEST_TILT_DEG = 3.0  # between some two boards


def refuse_parallel(rotations, method):
    """Raise CalibrationError if all boards are parallel.

    rotations: (n, 3, 3) of the boards as fitted, any common frame; method: for the
    message. Parallel boards share one vanishing line, so whatever focal length or
    centre a fit came to rest at, it finds them parallel: the poses themselves tell.
    """
    normals = rotations[:, :, 2]
    cosine = np.clip(normals @ normals.T, -1.0, 1.0)
    widest = np.degrees(np.arccos(np.min(np.abs(cosine))))
    if widest < SMALLEST_TILT_DEG:
        raise CalibrationError(
            f"{method}: all boards are parallel to within {widest:.1f} degrees; tilt"
            " them against each other"
        )
