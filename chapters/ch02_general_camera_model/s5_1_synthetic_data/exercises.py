"""What the exercises of section 2.5.1 compare an answer with."""

from __future__ import annotations

import numpy as np

from chapters.shared.three_planes import PRINCIPAL

# From the middle of the image to its corner, half a pixel outside the last centres.
HALF_DIAGONAL_PX = np.hypot(*(np.asarray(PRINCIPAL) + 0.5))


def clean_residual(noise, grids):
    """The mean length of Gaussian noise on two axes is its SD times sqrt(pi / 2), and
    the mean of points with independent noise has it divided by the root of their
    number.

    noise: SD on each axis; grids: points that a ray is fitted to.
    """
    return noise * np.sqrt(np.pi / 2) / np.sqrt(grids)


def seen_over_unseen(grids):
    """RMS distance of a ray from one of its ``grids`` points, over a new one's.

    Of noise of variance 1 the ray has 1 / grids, which it shares with its own
    points and adds to that of others.
    """
    return np.sqrt((1 - 1 / grids) / (1 + 1 / grids))


def focal_of_equidistance(fov_deg, half_diagonal_px=HALF_DIAGONAL_PX):
    """At the image's corner r = f theta, with r half the diagonal and theta half the
    field of view in radians.
    """
    return half_diagonal_px / (np.radians(fov_deg) / 2)


def stretch_at(angle_deg):
    """The corrected view has the radius f tan(theta), the image f theta; the derivative
    of the tangent is one over the squared cosine.
    """
    return 1 / np.cos(np.radians(angle_deg)) ** 2
