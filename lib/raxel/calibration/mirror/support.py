"""Which knot intervals of a spline mirror features support.

Where none does, the residual stays small while the shape is anything (5.2.2): features
must lie at least in the first and the last interval, along u and along v. How far they
reach into these tells how much of the edge is carried on.
"""

from typing import NamedTuple

import numpy as np

from raxel.errors import CalibrationError
from raxel.geometry.spline_grid import spline_grid

# Of the outermost interval: with less of it reached, the edge is a guess.
LEAST_REACH = 0.6
ENDS = (("u", 0, "first"), ("u", -1, "last"), ("v", 0, "first"), ("v", -1, "last"))


class Support(NamedTuple):
    """Features per knot interval.

    along_u, along_v: numbers of features; cells (n_u, n_v): in each; reach: of the
    first and last interval along u, then along v, the share between its inner knot and
    the outermost feature, 0 where it has none.
    """

    along_u: np.ndarray
    along_v: np.ndarray
    cells: np.ndarray
    reach: np.ndarray

    def missing(self):
        """Names of the outermost intervals that hold no feature."""
        return [
            f"the {place} knot interval along {axis}"
            for axis, end, place in ENDS
            if (self.along_u if axis == "u" else self.along_v)[end] == 0
        ]

    def weak(self):
        """Names of the outermost intervals that features reach too little into."""
        return [
            f"the {place} knot interval along {axis} ({100 * share:.0f} % of it)"
            for (axis, _, place), share in zip(ENDS, self.reach, strict=True)
            if 0 < share < LEAST_REACH
        ]


def support_of(grid, p):
    """Support of a SplineGrid by features at p (N, 2); those outside do not count."""
    p = np.asarray(p, float)
    inside = grid.inside(p)
    i, j = grid.intervals(p[inside]).T
    shape = tuple(len(breaks) - 1 for breaks in grid.breaks)
    cells = np.zeros(shape, int)
    np.add.at(cells, (i, j), 1)
    reach = []
    for breaks, x in zip(grid.breaks, grid.turned(p[inside]).T, strict=True):
        low, high = (x.min(), x.max()) if len(x) else (np.inf, -np.inf)
        reach += [
            (breaks[1] - low) / (breaks[1] - breaks[0]),
            (high - breaks[-2]) / (breaks[-1] - breaks[-2]),
        ]
    return Support(cells.sum(axis=1), cells.sum(axis=0), cells, np.clip(reach, 0, 1))


def clamped_end(grid, clamp):
    """("u", 0) or ("u", -1), the end at which a Clamp or FixedLine holds place and
    slope; None where there is none, or it holds no slope."""
    if clamp is None or clamp.slopes is None:
        return None
    u = np.median(grid.turned(clamp.points)[:, 0])
    first, last = grid.breaks[0][[0, -1]]
    return ("u", 0 if u - first < last - u else -1)


def need_support(support, clamp_at=None, prior=False):
    """Flags (list of text) for weak intervals; CalibrationError for unsupported ones.

    clamp_at: ("u", 0) or the like, the end that a clamp in place and slope carries;
    prior: whether a prior carries what features do not, which is then flagged.
    """
    carried = dict.fromkeys(
        (f"the {place} knot interval along {axis}"
         for axis, end, place in ENDS if clamp_at == (axis, end)), "the clamp"
    )  # fmt: skip
    missing = support.missing()
    open_ends = [name for name in missing if name not in carried]
    if open_ends and not prior:
        raise CalibrationError(
            f"mirror shape: no common feature in {', '.join(open_ends)}; its shape "
            "would be a guess: use fewer knots, a smaller deflection, features that "
            "reach there, or a prior",
            code="no-feature-at-end",
        )
    flags = [f"{name}: carried by {carried.get(name, 'the prior')}" for name in missing]
    return flags + [f"{name}: few features" for name in support.weak()]


def supported_grid(span, p, most=(7, 3), degree=(2, 2), angle=0.0, clamp_at=None):
    """The SplineGrid with the most basis functions whose outermost intervals features
    support, at most `most` (Kf, Kg).

    span: (M, 2), what its box spans; p: (N, 2), the features common to both pictures:
    the further they were displaced, the fewer reach the free edge, and the wider its
    interval must be. Raises CalibrationError where not even one interval will do.
    """
    shape = list(most)
    while True:
        grid = spline_grid(span, shape, degree, angle)
        support = support_of(grid, p)
        poor = _unsupported_axes(support, clamp_at)
        fewer = [axis for axis in poor if shape[axis] > degree[axis] + 1]
        if not fewer:
            need_support(support, clamp_at)
            return grid
        for axis in fewer:
            shape[axis] -= 1


def _unsupported_axes(support, clamp_at):
    counts = {"u": support.along_u, "v": support.along_v}
    poor = {
        "uv".index(axis)
        for (axis, end, _), share in zip(ENDS, support.reach, strict=True)
        if (axis, end) != clamp_at and (counts[axis][end] == 0 or share < LEAST_REACH)
    }
    return sorted(poor)
