"""What the exercises of section 2.5.3 compare an answer with."""

from __future__ import annotations

import numpy as np


def view_focal_px(half_view_deg, width_px=1024):
    """Focal length (px) of a pinhole view this wide to each side."""
    return (width_px - 1) / 2 / np.tan(np.radians(half_view_deg))


def convergence_deg(pitch_deg, x):
    """How far (deg) a vertical line's picture leans at (x, 0), f = 1.

    Verticals meet at the vanishing point (0, -1 / tan(pitch)) or (0, 1 / tan).
    """
    return np.degrees(np.arctan(x * np.tan(np.radians(pitch_deg))))
