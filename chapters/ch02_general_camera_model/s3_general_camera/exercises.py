"""What the exercises of sections 2.3 and 2.4 compare an answer with."""

from __future__ import annotations

import numpy as np

from raxel.calibration import rays_from_known_motion
from raxel.geometry import pluecker_matrix, pluecker_vector, pose

# A pixel sees these points on two parallel grids, 100 mm apart.
SEEN_MM = ((30.0, -20.0), (45.0, -30.0))
STEP_MM = 100.0
A_MM, B_MM = (1.0, 2.0, 3.0), (4.0, 6.0, 3.0)


def vector_through():
    """Plücker vector (6,) of the line through A and B (2.12)."""
    return pluecker_vector(pluecker_matrix([*A_MM, 1.0], [*B_MM, 1.0]))


def ray_of_pixel():
    """Unit direction (3,) of the ray through the two points seen."""
    T = np.stack([np.eye(4), pose(np.eye(3), [0.0, 0.0, STEP_MM])])
    points = np.array(SEEN_MM)[:, None]
    return rays_from_known_motion(points, T).directions[0]


def angle_per_shift(shift_mm, step_mm):
    """Angle (deg) by which a ray along z turns when grid 2 is off."""
    return np.degrees(np.arctan(shift_mm / step_mm))


def bytes_of_table(width, height):
    """Bytes of a look-up table of Plücker matrices in double precision."""
    return 16 * 8 * width * height
