"""Circles through points of a plane."""

from typing import NamedTuple

import numpy as np

from raxel.errors import InputError
from raxel.multiview.fits.planes import checked_points, least_distances

STRAIGHT = 1e-9  # sagitta over extent of points that lie on a line


class CircleFit(NamedTuple):
    """centre (2,), radius, and their covariance (3, 3), in the unit of the points.

    residuals: (N,) distances of all points, positive outside; sigma: see `Settled`.
    """

    centre: np.ndarray
    radius: float
    covariance: np.ndarray
    residuals: np.ndarray
    sigma: float


def fit_circle(points, sigma=None):
    """The circle of least squared distances from points of a plane.

    points: (N, 2), N >= 3, any unit; sigma: standard deviations of the distances, a
    number or (N,), or None: equal, and measured by what is left. It begins with
    `algebraic_circles`. Returns CircleFit. Raises InputError for fewer than three
    points, values that are not finite, and points on one line.
    """
    points = checked_points("circle", points, 2, 3)
    fit = _settled(points, _start(points), sigma)
    return _as_fit(fit, points)


def algebraic_circles(points):
    """Circles (..., 3), centre and radius, of points (..., N, 2), N >= 3.

    Minimises the sum of squares of Q = a (x^2 + y^2) + b x + c y + d over the mean
    squared length of its gradient; exact for three points, and the best of the
    algebraic fits on short arcs. NaN where the points lie on one line.
    Source: Taubin 1991, doi:10.1109/34.103273.
    """
    middle = points.mean(axis=-2, keepdims=True)
    off = points - middle
    square = np.sum(off**2, axis=-1)
    mean = square.mean(axis=-1, keepdims=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        # In this scale the mean squared gradient of Q is the length of (a, b, c).
        rows = np.concatenate(
            [((square - mean) / (2 * np.sqrt(mean)))[..., None], off], axis=-1
        )
        moments = np.swapaxes(rows, -1, -2) @ rows
        known = np.isfinite(moments).all(axis=(-1, -2), keepdims=True)
        q = np.linalg.eigh(np.where(known, moments, 0.0))[1][..., 0]
        size = np.sqrt(mean[..., 0])
        bend = np.where(np.abs(q[..., 0]) > STRAIGHT, q[..., 0], np.nan)
        centre = -q[..., 1:] * (size / bend)[..., None]
        radius = np.sqrt(np.sum(centre**2, axis=-1) + mean[..., 0])
    return np.concatenate([middle[..., 0, :] + centre, radius[..., None]], axis=-1)


def circle_distances(circles, points):
    """Signed distances (m, N) of points (N, 2) from circles (m, 3)."""
    off = points - circles[:, None, :2]
    return np.hypot(off[..., 0], off[..., 1]) - circles[:, 2:]


def _start(points):
    start = algebraic_circles(points)
    if not np.isfinite(start).all():
        raise InputError("circle: the points lie on one line; give points beside it")
    return start


def _settled(points, start, sigma):
    return least_distances("circle", _system, np.add, start, points, sigma)


def _system(circle, points):
    off = points - circle[:2]
    apart = np.hypot(off[:, 0], off[:, 1])
    outward = off / np.maximum(apart, 1e-300)[:, None]
    return apart - circle[2], -np.column_stack([outward, np.ones(len(points))])


def _as_fit(fit, points):
    circle = fit.parameters
    residuals = circle_distances(circle[None], points)[0]
    return CircleFit(circle[:2], float(circle[2]), fit.covariance, residuals, fit.sigma)
