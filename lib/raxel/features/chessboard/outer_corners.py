"""Errors of the outer corners of a board, where neighbouring squares end.

Blur mixes the edges of neighbouring corners into the window of a corner. Around an
inner corner they are symmetric and do not move it. No squares follow beyond the sides
of a board, so an outer corner moves. The model is a board of unit squares with a bright
margin, smoothed by a Gaussian: an indicator of the squares along each axis, and the
alternating sign of the squares, both smoothed. The corner fit is applied to its
gradients. A grey margin gives shifts that are a sixth smaller.
"""

from functools import cache

import numpy as np
from scipy.special import ndtr

from raxel.features.chessboard.corners import (
    FULL_EFFORT,
    HALF_WINDOW_STEPS,
    misfit_of,
    solved,
    window_samples,
    without_mean,
)

# Blur in squares, and number of steps of the fit until a corner is stationary.
BLURS = np.linspace(0.05, 0.5, 46)
N_STEPS = 40
# Squares that are modelled to each side of a corner.
N_SQUARES = 4


@cache
def outer_corner_model(ends):
    """Misfit and shift (RMS of both axes, in squares) of a corner for each of BLURS.

    ends: for s and for t, whether the board ends one square before the corner.
    """
    x, weight = window_samples(FULL_EFFORT.half)
    at = np.zeros((len(BLURS), 2))
    for _ in range(N_STEPS):
        s, t = np.moveaxis(HALF_WINDOW_STEPS * x + at[:, None], -1, 0)
        (a, da, c, dc), (b, db, d, dd) = map(_profiles, (s, t), ends)
        g = np.stack([dc * d - da * b, c * dd - a * db], axis=2)
        g = without_mean(g, weight)
        at += HALF_WINDOW_STEPS * solved(g, x, weight)
    return misfit_of(g, x, weight), np.sqrt((at**2).mean(axis=1))


def _profiles(s, is_end):
    """Indicator of the squares and their sign at s (blurs, K), and derivatives."""
    blur = BLURS[:, None, None]
    first = -1 if is_end else -N_SQUARES
    edges = np.arange(first, N_SQUARES)
    z = (s[..., None] - edges) / blur
    share, slope = ndtr(z), np.exp(-(z**2) / 2) / (np.sqrt(2 * np.pi) * blur)
    jumps = 2 * (-1.0) ** edges
    if is_end:
        jumps[0] = -1
        return share[..., 0], slope[..., 0], share @ jumps, slope @ jumps
    return np.ones_like(s), np.zeros_like(s), share @ jumps - 1, slope @ jumps


def outer_corner_error(misfit, half, u, v):
    """Standard deviation (rows, columns) px of corners due to squares that end.

    The blur of a corner is that for which the model has its misfit. misfit, half (rows,
    columns): see `corners.LocalisedCorners`; u, v (rows, columns): spacings in px.
    """
    error = np.zeros(misfit.shape)
    rows, columns = (np.arange(n) % max(n - 1, 1) == 0 for n in misfit.shape)
    small = np.fmin(u, v)
    for ends, outer in (
        ((True, False), rows[:, None] ^ columns),
        ((True, True), rows[:, None] & columns),
    ):
        model_misfit, shift = outer_corner_model(ends)
        blur = np.interp(misfit, model_misfit, BLURS) * half / HALF_WINDOW_STEPS
        at = np.interp(blur * np.sqrt(u * v) / small, BLURS, shift) * small
        error[outer] = at[outer]
    return error
