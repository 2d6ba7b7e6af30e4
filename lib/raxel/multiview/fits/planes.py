"""Planes through points in space: total least squares."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.errors import InputError
from raxel.geometry.least_squares import descend, gauss_newton
from raxel.geometry.poses import pose

# Common part of the fits of curves and surfaces: least orthogonal distances. A shape is
# a parameter vector that a shorter step changes, so that the norm of a direction or of
# a conic's coefficients is not an unknown. The sum of squared orthogonal distances is
# the likelihood of points with isotropic Gaussian errors, except for the curvature of
# the shape over such an error. Source: Gander, Golub, Strebel 1994,
# doi:10.1007/BF01934268 (geometric against algebraic fits).


MAX_N_STEPS, COST_TOL = 100, 1e-13
ROUNDING_TOL = 1e-15  # distance of exact points, over the points' extent
# Smallest eigenvalue of equations scaled to unit diagonal.
MIN_EIGENVALUE_RATIO = 1e-12
MAX_COORDINATE = 1e100  # its square must not overflow


class Settled(NamedTuple):
    """Shape with the least squared distances.

    parameters: (P,); residuals: (N,) signed distances; covariance: (m, m) of the step
    of the shape; sigma: standard deviation of a distance (at weight 1 for given
    standard deviations), NaN where the points do not exceed the unknowns.
    """

    parameters: np.ndarray
    residuals: np.ndarray
    covariance: np.ndarray
    sigma: float


def least_distances(shape, system, move, start, points, sigma):
    """Fit a shape to points; returns `Settled`.

    shape: its name, for errors; system: parameters, points -> signed distances (N,) and
    their derivatives (N, m) by the step; move: parameters, step (m,) -> parameters;
    start: (P,); points: (N, d); sigma: as `weights_of`. Raises InputError where the
    points do not determine the shape.
    """
    weight = weights_of(shape, sigma, len(points))

    def evaluate(parameters):
        distances, jacobian = system(parameters, points)
        return gauss_newton(weight * distances, lambda: weight[:, None] * jacobian)

    extent = np.ptp(points, axis=0).max()
    least = len(points) * (ROUNDING_TOL * extent * weight.max()) ** 2
    parameters, costs, _ = descend(
        evaluate,
        move,
        start,
        iterations=MAX_N_STEPS,
        tolerance=COST_TOL,
        rounding=least,
    )
    distances, jacobian = system(parameters, points)
    inverse = _inverse_normal(shape, weight[:, None] * jacobian)
    return Settled(
        parameters, distances, *spread(inverse, costs[-1], len(points), sigma)
    )


def spread(inverse, cost, count, sigma):
    """(covariance (m, m), sigma) from the inverse normal matrix and the residuals.

    cost: sum of weighted squares of `count` distances. The covariance follows from
    given standard deviations, else from the scatter.
    """
    spare = count - len(inverse)
    scatter = np.sqrt(cost / spare) if spare > 0 else np.nan
    return inverse * (1.0 if sigma is not None else scatter**2), float(scatter)


def weights_of(shape, sigma, count):
    """Reciprocal standard deviations (count,) of the points' distances.

    sigma: a number, (count,), or None: equal and unknown. Raises InputError where they
    do not fit.
    """
    given = _numbers(shape, "sigma", 1.0 if sigma is None else sigma)
    if given.shape not in ((), (count,)):
        raise InputError(
            f"{shape}: sigma: found shape {given.shape}; give one number, or one for "
            f"each of {count} points"
        )
    bad = given[~(np.isfinite(given) & (given > 0))]
    if len(bad):
        raise InputError(
            f"{shape}: sigma: found {bad[0]:g}; give standard deviations above 0"
        )
    return np.broadcast_to(1 / given, (count,))


def checked_points(
    shape: str, points: ArrayLike, dimension: int, fewest: int
) -> NDArray[np.float64]:
    """Points (N, dimension) as floats; InputError for others, or for too few."""
    points = _numbers(shape, "points", points)
    if points.ndim != 2 or points.shape[1] != dimension:
        raise InputError(
            f"{shape}: found points {points.shape}; give an array (N, {dimension})"
        )
    bad = np.count_nonzero(~np.isfinite(points).all(axis=1))
    if bad:
        raise InputError(
            f"{shape}: {bad} of {len(points)} points are not finite; remove them"
        )
    if len(points) < fewest:
        raise InputError(f"{shape}: found {len(points)} points; give {fewest} or more")
    if np.abs(points).max() > MAX_COORDINATE:
        raise InputError(
            f"{shape}: found a point at {np.abs(points).max():.3g}; remove points near "
            "infinity"
        )
    different = len(np.unique(points, axis=0))
    if 1 < different < min(len(points), fewest + 1):
        raise InputError(
            f"{shape}: found {different} distinct of {len(points)} points; give more "
            f"than {fewest} distinct ones"
        )
    return points


def _numbers(shape: str, name: str, given: ArrayLike) -> NDArray[np.float64]:
    """Array of floats; InputError for other values."""
    try:
        return np.asarray(given, float)
    except (TypeError, ValueError) as fault:
        raise InputError(
            f"{shape}: {name}: not numeric ({fault}); give an array of numbers"
        ) from fault


def _inverse_normal(shape, jacobian):
    normal = jacobian.T @ jacobian
    scale = np.sqrt(np.diag(normal))
    if scale.min() > 0:
        values, vectors = np.linalg.eigh(normal / np.outer(scale, scale))
        if values[0] > MIN_EIGENVALUE_RATIO:
            return (vectors / values) @ vectors.T / np.outer(scale, scale)
    raise InputError(
        f"{shape}: the points do not determine it; spread them over more of the shape"
    )


COLLINEARITY_TOL = 1e-9  # distance from a line, over the extent


class PlaneFit(NamedTuple):
    """Plane z = 0 of a frame, with its covariance.

    Attributes
    ----------
    T_frame_plane : ndarray of shape (4, 4)
        Frame of the plane, in the frame of the points. Its origin is the mean of the
        points, and x the direction of their largest spread, both weighted as the
        distances. z is the normal, away from the origin of the points' frame.
    covariance : ndarray of shape (3, 3)
        Covariance of rotations about x and y (rad) and of the shift along z, in the
        plane's frame.
    residuals : ndarray of shape (N,)
        Distances of all points, positive on the side of z.
    sigma : float
        Standard deviation of a distance, see `Settled`.
    """

    T_frame_plane: np.ndarray
    covariance: np.ndarray
    residuals: np.ndarray
    sigma: float

    @property
    def normal(self) -> NDArray[np.float64]:
        """Unit normal of the plane, shape (3,)."""
        return self.T_frame_plane[:3, 2]


def fit_plane(points: ArrayLike, sigma: ArrayLike | None = None) -> PlaneFit:
    """Fit the plane of least squared distances to points, in closed form.

    Parameters
    ----------
    points : array_like of shape (N, 3)
        Points, N >= 3, any unit.
    sigma : float or array_like of shape (N,), optional
        Standard deviations of the distances. None: equal, and estimated from the
        residuals.

    Returns
    -------
    PlaneFit
        Frame, covariance and residuals.

    Raises
    ------
    InputError
        For fewer than three points, values that are not finite, and points on one line.

    References
    ----------
    Pearson 1901, doi:10.1080/14786440109462720.

    Examples
    --------
    >>> from raxel.multiview import fit_plane
    >>> fit = fit_plane([[0, 0, 5], [1, 0, 5], [0, 1, 5], [2, 3, 5]])
    >>> fit.normal.round(6).tolist()
    [0.0, 0.0, 1.0]
    """
    points = checked_points("plane", points, 3, 3)
    return _as_fit(_settled(points, sigma), points)


def _settled(points, sigma):
    weight = weights_of("plane", sigma, len(points)) ** 2
    middle = weight @ points / weight.sum()
    errors = points - middle
    extents, axes = np.linalg.svd(
        errors * np.sqrt(weight)[:, None], full_matrices=False
    )[1:]
    if not extents[1] > COLLINEARITY_TOL * extents[0]:
        raise InputError("plane: the points are collinear; add points off the line")
    normal = axes[2]
    distances = errors @ normal
    # In the frame of the axes a rotation (a, b) and a shift s change the distances by
    # b x - a y - s, and x and y are uncorrelated.
    inverse = np.diag(1 / np.array([extents[1] ** 2, extents[0] ** 2, weight.sum()]))
    covariance, scatter = spread(inverse, weight @ distances**2, len(points), sigma)
    parameters = np.concatenate([middle, normal, axes[0]])
    return Settled(parameters, distances, covariance, scatter)


def _as_fit(fit, points):
    middle, normal, x = fit.parameters.reshape(3, 3)
    normal = normal * (-1 if normal @ middle < 0 else 1)
    x = x * np.sign(x[np.argmax(np.abs(x))])
    T = pose(np.column_stack([x, np.cross(normal, x), normal]), middle)
    residuals = (points - middle) @ normal
    return PlaneFit(T, fit.covariance, residuals, fit.sigma)
