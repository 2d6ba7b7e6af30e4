"""What the exercises of section 3.1.3 compare an answer with."""

from __future__ import annotations

import numpy as np

SURFACE = {"a": 0.5, "b": 12.0, "c": -0.5, "d": -3.0, "e": 4.0}


def stationary_point():
    """Where the gradient of the exercise's surface vanishes, (2,) px."""
    a, b, c, d, e = SURFACE.values()
    return np.linalg.solve([[2 * a, b], [b, 2 * c]], [-d, -e])


def farthest_return():
    """Farthest start (px) that OpenCV's 9 x 9 window can bring back.

    It gives up what moves further than its half window on either axis.
    """
    return 4 * np.sqrt(2)


def pulled_edge(radius_px, blur_sd_px):
    """How far (px) blur moves an edge that is an arc, towards its centre.

    The Laplacian of a straight edge has its zero on the edge; that of an arc
    has one more term, the slope over the radius, and blur adds half the
    variance times the Laplacian.
    """
    return blur_sd_px**2 / (2 * radius_px)
