"""Lines in a round window of CELECT, as figures draw them."""

import numpy as np


def line_ends(centre, radius, line):
    """Ends (2, 2) of the chord of a window that a line (R, theta in deg) cuts.

    A line beside the window has its two ends where it is nearest.
    """
    R, theta = line[0], np.radians(line[1])
    along = np.array([np.cos(theta), np.sin(theta)])
    foot = centre + R * np.array([-along[1], along[0]])
    half = np.sqrt(max(radius**2 - R**2, 0.0))
    return np.array([foot - half * along, foot + half * along])
