"""Circles through points of a plane."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.errors import InputError
from raxel.multiview.fits.planes import checked_points, least_distances

MIN_SAGITTA_RATIO = 1e-9  # sagitta over extent of points on a line


class CircleFit(NamedTuple):
    """Circle of a plane with its covariance.

    Attributes
    ----------
    centre : ndarray of shape (2,)
        Centre, in the unit of the points.
    radius : float
        Radius, in the unit of the points.
    covariance : ndarray of shape (3, 3)
        Covariance of centre and radius.
    residuals : ndarray of shape (N,)
        Distances of all points from the circle, positive outside.
    sigma : float
        Standard deviation of a distance, see `Settled`.
    """

    centre: np.ndarray
    radius: float
    covariance: np.ndarray
    residuals: np.ndarray
    sigma: float


def fit_circle(points: ArrayLike, sigma: ArrayLike | None = None) -> CircleFit:
    """Fit the circle of least squared distances to points of a plane.

    The fit starts from `algebraic_circles`.

    Parameters
    ----------
    points : array_like of shape (N, 2)
        Points, N >= 3, any unit.
    sigma : float or array_like of shape (N,), optional
        Standard deviations of the distances. None: equal, and estimated from the
        residuals.

    Returns
    -------
    CircleFit
        Centre, radius, covariance and residuals.

    Raises
    ------
    InputError
        For fewer than three points, values that are not finite, and points on one line.

    Examples
    --------
    >>> from raxel.multiview import fit_circle
    >>> fit = fit_circle([[3, 0], [0, 3], [-3, 0], [0, -3]])
    >>> round(fit.radius, 6)
    3.0
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
    errors = points - middle
    square = np.sum(errors**2, axis=-1)
    mean = square.mean(axis=-1, keepdims=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        # In this scale the mean squared gradient of Q is the length of (a, b, c).
        rows = np.concatenate(
            [((square - mean) / (2 * np.sqrt(mean)))[..., None], errors], axis=-1
        )
        moments = np.swapaxes(rows, -1, -2) @ rows
        known = np.isfinite(moments).all(axis=(-1, -2), keepdims=True)
        q = np.linalg.eigh(np.where(known, moments, 0.0))[1][..., 0]
        size = np.sqrt(mean[..., 0])
        bend = np.where(np.abs(q[..., 0]) > MIN_SAGITTA_RATIO, q[..., 0], np.nan)
        centre = -q[..., 1:] * (size / bend)[..., None]
        radius = np.sqrt(np.sum(centre**2, axis=-1) + mean[..., 0])
    return np.concatenate([middle[..., 0, :] + centre, radius[..., None]], axis=-1)


def circle_distances(
    circles: NDArray[np.float64], points: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return signed distances of points from circles.

    Parameters
    ----------
    circles : ndarray of shape (m, 3)
        Centre and radius of each circle.
    points : ndarray of shape (N, 2)
        Points, in the same unit.

    Returns
    -------
    ndarray of shape (m, N)
        Distances, positive outside.
    """
    errors = points - circles[:, None, :2]
    return np.hypot(errors[..., 0], errors[..., 1]) - circles[:, 2:]


def _start(points):
    start = algebraic_circles(points)
    if not np.isfinite(start).all():
        raise InputError("circle: the points are collinear; add points off the line")
    return start


def _settled(points, start, sigma):
    return least_distances("circle", _system, np.add, start, points, sigma)


def _system(circle, points):
    errors = points - circle[:2]
    separation = np.hypot(errors[:, 0], errors[:, 1])
    outward = errors / np.maximum(separation, 1e-300)[:, None]
    return separation - circle[2], -np.column_stack([outward, np.ones(len(points))])


def _as_fit(fit, points):
    circle = fit.parameters
    residuals = circle_distances(circle[None], points)[0]
    return CircleFit(circle[:2], float(circle[2]), fit.covariance, residuals, fit.sigma)
