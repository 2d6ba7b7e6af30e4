"""What the exercises of section 2.5.3 compare an answer with."""

from __future__ import annotations

import numpy as np


def view_focal_px(half_view_deg, width_px=1024):
    """Half the width is f times the tangent of the angle to each side. The code counts
    from centre to centre of the outermost pixels; from rim to rim is 0.1 % more.
    """
    return (width_px - 1) / 2 / np.tan(np.radians(half_view_deg))


def convergence_deg(pitch_deg, x):
    """The line runs to the vanishing point, x to the side and 1 / tan(pitch) up or
    down: its lean has the tangent x tan(pitch).

    Verticals meet at the vanishing point (0, -1 / tan(pitch)) or (0, 1 / tan).
    """
    return np.degrees(np.arctan(x * np.tan(np.radians(pitch_deg))))
