"""A smooth surface through the corners of a lattice: C1 and exact at every corner.

Between corners each quantity is a bicubic Hermite patch. Its slopes at a corner are
those of the polynomial through up to five neighbours of the row or column, so a hole
or the rim costs order and nothing else, and a corner tells on no cell further away.
"""

import numpy as np

NEIGHBOURS = 5  # corners of a line behind one slope, where there are as many


def refined_lattice(lattice, factor):
    """The surface at `factor` points per cell each way.

    lattice: (rows, columns, ...), NaN where unknown. Returns (factor (rows - 1) + 1,
    factor (columns - 1) + 1, ...), NaN in cells that lack a corner; the given corners
    are every factor-th point, unchanged.
    """
    down, along = _slopes(lattice, 0), _slopes(lattice, 1)
    # Beside a hole the two orders of taking slopes can differ.
    twist = (_slopes(down, 1) + _slopes(along, 0)) / 2
    lattice, along = _refined(lattice, down, factor), _refined(along, twist, factor)
    return _refined(lattice.swapaxes(0, 1), along.swapaxes(0, 1), factor).swapaxes(0, 1)


def refining_weights(count, factor):
    """(factor (count - 1) + 1, count): what `refined_lattice` does along one line."""
    unit = np.eye(count)
    return _refined(unit, _slopes(unit, 0), factor)


def _refined(values, slopes, factor):
    """Cubic Hermite interpolation along the first axis."""
    t = np.arange(1, factor).reshape(-1, *[1] * (values.ndim - 1)) / factor
    before, after = values[:-1, None], values[1:, None]
    rise, fall = slopes[:-1, None], slopes[1:, None]
    between = (
        (1 + 2 * t) * (1 - t) ** 2 * before
        + t * (1 - t) ** 2 * rise
        + t**2 * (3 - 2 * t) * after
        + t**2 * (t - 1) * fall
    )
    fine = np.concatenate([before, between], axis=1)
    return np.concatenate([fine.reshape(-1, *values.shape[1:]), values[-1:]])


def _slopes(values, axis):
    """Derivatives per step along one axis, NaN where no neighbour is known.

    Of the runs of known corners the longest counts, and of those the one whose middle
    is nearest.
    """
    values = np.moveaxis(values, axis, 0)
    slopes = np.full(values.shape, np.nan)
    for first, weights in _STENCILS:
        low, high = max(0, -first), len(values) + 1 - first - len(weights)
        if high <= low:
            continue
        there = slopes[low:high]
        found = sum(
            weight * values[low + first + k : high + first + k]
            for k, weight in enumerate(weights)
        )
        there[:] = np.where(np.isnan(there), found, there)
    return np.moveaxis(slopes, 0, axis)


def _stencils():
    """(first neighbour, weights): slopes at 0 of polynomials through neighbours."""
    found = []
    for count in range(NEIGHBOURS, 1, -1):
        for first in sorted(range(1 - count, 1), key=lambda f: abs(2 * f + count - 1)):
            powers = np.vander(first + np.arange(count), increasing=True).T
            found.append((first, np.linalg.solve(powers, np.eye(count)[1])))
    return found


_STENCILS = _stencils()
