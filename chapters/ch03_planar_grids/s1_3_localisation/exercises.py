"""What the exercises of section 3.1.3 compare an answer with."""

from __future__ import annotations

import numpy as np

SURFACE = {"a": 0.5, "b": 12.0, "c": -0.5, "d": -3.0, "e": 4.0}


def stationary_point():
    """The gradient of the surface vanishes: 2 a x + b y + d = 0 and
    b x + 2 c y + e = 0.
    """
    a, b, c, d, e = SURFACE.values()
    return np.linalg.solve([[2 * a, b], [b, 2 * c]], [-d, -e])


def farthest_return():
    """The half window is 4 px. A start may be off by 4 px on both axes at once, which
    is 4 sqrt(2) px.
    """
    return 4 * np.sqrt(2)


def pulled_edge(radius_px, blur_sd_px):
    """Blur moves an arc by its variance over twice the radius, here 9 / 800 px.

    The Laplacian of a straight edge has its zero on the edge; that of an arc
    has one more term, the slope over the radius, and blur adds half the
    variance times the Laplacian.
    """
    return blur_sd_px**2 / (2 * radius_px)
