"""Failures of CELECT's merging, told by the truth, and what may cause them."""

from __future__ import annotations

import numpy as np

from chapters.shared.scoring import truth_of_contour

NEAR = 0.25
"""A point belongs to a corner within this share of the nearest corner's distance."""

SEPARATED = 1e-6
"""Information below which a slope is without bound."""


def size_variation(lattice):
    """Largest ratio of the longest to the shortest step along one contour.

    lattice: (rows, columns, 2). Contours are the four sides and the columns, as
    CELECT follows them.
    """
    contours = [lattice[0], lattice[-1], *lattice.swapaxes(0, 1)]
    steps = [np.linalg.norm(np.diff(c, axis=0), axis=1) for c in contours]
    return float(max(s.max() / s.min() for s in steps))


def merge_failed(result, lattice):
    """Whether merging lost or doubled a corner on a traced contour.

    result: CelectResult or None; lattice: (rows, columns, 2) in the order of clicks.
    """
    if result is None:
        return False
    reach = NEAR * nearest_distances(lattice)
    for contour in result.contours:
        truth, _ = truth_of_contour(contour.name, lattice)
        near, _ = truth_of_contour(contour.name, reach)
        if not len(contour.merged):
            continue
        before = claims(contour.inliers, truth, near)
        after = claims(contour.merged, truth, near)
        if ((before > 0) & (after == 0)).any() or (after > 1).any():
            return True
    return False


def claims(points, truth, near):
    """How many points (m, 2) belong to each true corner (n, 2), within near (n,)."""
    if not len(points):
        return np.zeros(len(truth), int)
    apart = np.linalg.norm(truth[:, None] - points[None], axis=2)
    return (apart <= near[:, None]).sum(axis=1)


def nearest_distances(lattice):
    """Distance (rows, columns) px from each corner to its nearest neighbour."""
    flat = lattice.reshape(-1, 2)
    apart = np.linalg.norm(flat[:, None] - flat[None], axis=2)
    np.fill_diagonal(apart, np.inf)
    return apart.min(axis=1).reshape(lattice.shape[:2])


def logistic_slope(x, y):
    """Slope of log odds of y (n,) bool over x (n,), and its standard error.

    Maximum likelihood by Newton's method; (nan, nan) where all y are alike or x parts
    them, so that no slope is the steepest.
    """
    y = np.asarray(y, float)
    if y.min() == y.max():
        return np.nan, np.nan
    scale = x.std()
    design = np.column_stack([np.ones(len(x)), (x - x.mean()) / scale])
    weights = np.zeros(2)
    for _ in range(50):
        p = 1 / (1 + np.exp(-design @ weights))
        information = design.T @ (design * (p * (1 - p))[:, None])
        if np.linalg.eigvalsh(information)[0] < SEPARATED:
            return np.nan, np.nan
        step = np.linalg.solve(information, design.T @ (y - p))
        weights += step
        if np.abs(step).max() < 1e-10:
            break
    error = np.sqrt(np.linalg.inv(information)[1, 1])
    return float(weights[1] / scale), float(error / scale)


def logistic_curve(x, y, at):
    """Probability (m,) at places `at` (m,) by the logistic fit of y (n,) over x (n,).

    The mean of y where there is no such fit.
    """
    slope, _ = logistic_slope(x, y)
    y = np.asarray(y, float)
    if not np.isfinite(slope):
        return np.full(len(at), y.mean())
    offset = _offset(slope, x, y)
    return 1 / (1 + np.exp(-(offset + slope * at)))


def _offset(slope, x, y):
    """Constant of the fit of a known slope: the mean probability is that of y."""
    from scipy.optimize import brentq

    def excess(offset):
        return (1 / (1 + np.exp(-(offset + slope * x)))).mean() - y.mean()

    far = 50 + np.abs(slope * x).max()
    return brentq(excess, -far, far)
