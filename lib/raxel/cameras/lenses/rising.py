"""Inverse of a rising function of one variable: Newton's method inside a bracket."""

import numpy as np


def smallest_positive_root(ascending):
    """Smallest real root > 0 of a polynomial with ascending coefficients; else inf."""
    descending = np.array(ascending, float)[::-1]
    # So small a leading coefficient has its root beyond all numbers.
    descending[np.abs(descending) < 1e-200 * np.abs(descending).max()] = 0
    roots = np.roots(np.trim_zeros(descending, "f"))
    # Rounding splits a double root, the inflection of a curve, into a complex pair.
    real = roots.real[np.abs(roots.imag) <= 1e-12 * np.abs(roots)]
    return float(real[real > 0].min(initial=np.inf))


NODES = 1025  # of the table that gives the first guess


def invert_rising(function, slope, targets, high):
    """x in [0, high] with function(x) = targets, for a function rising from 0.

    targets: (N,) in [0, function(high)]; `high` may be inf, then the targets must lie
    below the function's supremum. Safeguarded: a tangent that leaves the bracket is
    replaced by bisection, so that the branch between 0 and `high` is never left.
    """
    targets = np.asarray(targets, float)
    with np.errstate(all="ignore"):
        low, top, x = _bracket(function, targets, high)
        # Newton's method would take forty steps to come so close to 0.
        done = targets == 0
        x = np.where(done, 0.0, x)
        for _ in range(200):
            gap = function(x) - targets
            top = np.where(gap > 0, x, top)
            low = np.where(gap < 0, x, low)
            new = x - gap / slope(x)
            new = np.where((new >= low) & (new <= top), new, (low + top) / 2)
            # What has settled stays, so no result depends on its neighbours.
            settled = (gap == 0) | (np.abs(new - x) <= 1e-15 * x) | (top <= low)
            x = np.where(done | (gap == 0), x, new)
            done |= settled
            if done.all():
                break
    return x


def _bracket(function, targets, high):
    """Ends around each solution, and a first guess between them.

    Where the range is finite, from a table of the function: it depends on nothing but
    the range, so a guess does not depend on the other targets.
    """
    if np.isfinite(high):
        nodes = np.linspace(0, high, NODES)
        values = np.maximum.accumulate(function(nodes))
        if np.isfinite(values).all():
            place = np.clip(np.searchsorted(values, targets), 1, NODES - 1)
            return nodes[place - 1], nodes[place], np.interp(targets, values, nodes)
    low = np.zeros_like(targets)
    top = np.full_like(targets, min(high, 1.0))
    while True:
        short = (function(top) < targets) & (top < min(high, 1e200))
        if not short.any():
            return low, top, (low + top) / 2
        low = np.where(short, top, low)
        top = np.where(short, np.minimum(2 * top, high), top)
