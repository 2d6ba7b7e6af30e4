"""A function given by its derivative on pieces: exact to rounding, and quick."""

import numpy as np
from numpy.polynomial import chebyshev

# Smooth derivatives of a bent sheet need some twenty terms on a piece.
TERMS = 48
NEGLIGIBLE = 1e-17


class RunningIntegral:
    """Values of the integral of `rate` from breaks[0], straight on outside the breaks.

    breaks: (n + 1,) rising, mm; rate(x (m,)) -> (m,), smooth between breaks and
    continuous. Each piece is the integral of a Chebyshev series of degree TERMS - 1.
    """

    def __init__(self, breaks, rate):
        self.breaks = np.asarray(breaks, float)
        half = np.diff(self.breaks) / 2
        nodes = np.cos(np.pi * (np.arange(TERMS) + 0.5) / TERMS)
        series = np.linalg.inv(chebyshev.chebvander(nodes, TERMS - 1))
        x = self.breaks[:-1] + half * (1 + nodes[:, None])
        slopes = series @ np.reshape(rate(x.ravel()), x.shape)
        pieces = chebyshev.chebint(slopes, lbnd=-1, axis=0) * half
        gains = pieces.sum(axis=0)
        pieces[0] += np.concatenate([[0.0], np.cumsum(gains[:-1])])
        large = np.abs(pieces).max(axis=1) > NEGLIGIBLE * np.abs(pieces).max()
        self._pieces = pieces[: max(2, np.flatnonzero(large).max(initial=0) + 1)]
        self._half = half
        self._ends = np.array([0.0, gains.sum()])
        self._end_slopes = rate(self.breaks[[0, -1]])

    def __call__(self, x):
        """Values at x (N,)."""
        inside = np.clip(x, *self.breaks[[0, -1]])
        piece = np.searchsorted(self.breaks[1:-1], inside)
        place = (inside - self.breaks[piece]) / self._half[piece] - 1
        values = chebyshev.chebval(place, self._pieces[:, piece], tensor=False)
        first, last = self._end_slopes
        return values + np.where(x > inside, last, first) * (x - inside)
