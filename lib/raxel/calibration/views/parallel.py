"""Boards that are all parallel leave the camera open, whatever a fit says."""

import numpy as np

from raxel.errors import CalibrationError

MIN_TILT_DEG = 3.0  # between boards that count as tilted against each other


def refuse_parallel(rotations, method, needed):
    """Raise CalibrationError without ``needed`` (2 or 3) boards tilted pairwise.

    rotations: (n, 3, 3) of the boards as fitted, any common frame; method: for the
    message. Parallel boards share one vanishing line, so whatever focal length or
    centre a fit came to rest at, it finds them parallel: the poses themselves tell. A
    centre that came out far away leaves the tilts to the noise, and a board or two may
    seem tilted by chance; three of them pairwise do not.
    """
    normals = rotations[:, :, 2]
    cosine = np.clip(np.abs(normals @ normals.T), 0.0, 1.0)
    angles = np.degrees(np.arccos(cosine))
    apart = angles >= MIN_TILT_DEG
    pairs = apart.astype(int)
    found = apart if needed == 2 else apart & (pairs @ pairs > 0)
    if not found.any():
        what = "the boards are parallel"
        if angles.max() >= MIN_TILT_DEG:
            what += ", or no camera with a single centre fits them"
        widest = f"widest pair {angles.max():.1f}"
        raise CalibrationError(
            f"{method}: no {needed} boards are tilted against each other by"
            f" {MIN_TILT_DEG:.0f} degrees ({widest}): {what}; tilt them more",
            code="parallel-grids",
        )
