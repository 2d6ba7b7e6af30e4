"""Length scales of the contours: Table 3.1 for the sides, the rule for the columns."""

import numpy as np


def side_lengths(outer_corners, columns, rows, divisor):
    """s_1..s_4 (4,) in px of Table 3.1, from corners (4, 2) clockwise.

    `columns` and `rows` count corners, so s is a little less than half a square
    (errata E-3.01).
    """
    sides = np.linalg.norm(np.roll(outer_corners, -1, axis=0) - outer_corners, axis=1)
    return sides / (divisor * np.array([columns, rows, columns, rows]))


def mean_side(previous, settings):
    """s in px of a column from the corners (n, 2) of the previous one."""
    return settings.column_radius * corner_distances(previous).mean()


def corner_distances(corners):
    """Distances (n - 1,) in px between consecutive corners (n, 2) of a contour."""
    return np.linalg.norm(np.diff(corners, axis=0), axis=1)
