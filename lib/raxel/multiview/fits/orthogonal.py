"""What fits of curves and surfaces share: least orthogonal distances.

A shape is a vector of parameters that a step of fewer numbers moves, so that the length
of a direction or of a conic's coefficients is no unknown. The sum of squared orthogonal
distances is the likelihood of points with isotropic Gaussian errors, up to the bend of
the shape over such an error.
Source: Gander, Golub, Strebel 1994, doi:10.1007/BF01934268 (geometric against algebraic
fits).
"""

from typing import NamedTuple

import numpy as np

from raxel.errors import InputError
from raxel.geometry.least_squares import descend, gauss_newton

ITERATIONS, AT_REST = 100, 1e-13
ROUNDING = 1e-15  # of the points' extent: distances of exact points
OPEN = 1e-12  # least eigenvalue, diagonal 1, of equations that determine a shape
FARTHEST = 1e100  # of a coordinate: its square is a number yet


class Settled(NamedTuple):
    """A shape of least squared distances.

    parameters: (P,); residuals: (N,) signed distances; covariance: (m, m) of the step
    that moves the shape; sigma: standard deviation of a distance (of one of weight 1
    where standard deviations were given), NaN where there are no more points than
    unknowns.
    """

    parameters: np.ndarray
    residuals: np.ndarray
    covariance: np.ndarray
    sigma: float


def least_distances(shape, system, move, start, points, sigma):
    """Settle a shape on points; returns `Settled`.

    shape: its name, for errors; system: parameters, points -> signed distances (N,) and
    their derivatives (N, m) by the step; move: parameters, step (m,) -> parameters;
    start: (P,); points: (N, d); sigma: as `weights_of`. Raises InputError where the
    points leave the shape open.
    """
    weight = weights_of(shape, sigma, len(points))

    def evaluate(parameters):
        distances, jacobian = system(parameters, points)
        return gauss_newton(weight * distances, lambda: weight[:, None] * jacobian)

    extent = np.ptp(points, axis=0).max()
    least = len(points) * (ROUNDING * extent * weight.max()) ** 2
    parameters, costs, _ = descend(
        evaluate, move, start, iterations=ITERATIONS, tolerance=AT_REST, rounding=least
    )
    distances, jacobian = system(parameters, points)
    inverse = _inverse_normal(shape, weight[:, None] * jacobian)
    return Settled(
        parameters, distances, *spread(inverse, costs[-1], len(points), sigma)
    )


def spread(inverse, cost, count, sigma):
    """(covariance (m, m), sigma) from the inverse normal matrix and what is left.

    cost: sum of weighted squares of `count` distances. Where standard deviations are
    given the covariance is theirs; else it is that of the scatter.
    """
    spare = count - len(inverse)
    scatter = np.sqrt(cost / spare) if spare > 0 else np.nan
    return inverse * (1.0 if sigma is not None else scatter**2), float(scatter)


def weights_of(shape, sigma, count):
    """One over the standard deviations (count,) of the points' distances.

    sigma: a number, (count,), or None: equal and unknown. Raises InputError where they
    do not fit.
    """
    given = _numbers(shape, "sigma", 1.0 if sigma is None else sigma)
    if given.shape not in ((), (count,)):
        raise InputError(
            f"{shape}: found sigma of shape {given.shape}; give one number, or one for "
            f"each of {count} points"
        )
    bad = given[~(np.isfinite(given) & (given > 0))]
    if len(bad):
        raise InputError(
            f"{shape}: found sigma {bad[0]:g}; give standard deviations above 0"
        )
    return np.broadcast_to(1 / given, (count,))


def checked_points(shape, points, dimension, fewest):
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
        raise InputError(f"{shape}: {len(points)} points; {fewest} or more are needed")
    if np.abs(points).max() > FARTHEST:
        raise InputError(
            f"{shape}: a point is at {np.abs(points).max():.3g}; remove what is as "
            "good as at infinity"
        )
    different = len(np.unique(points, axis=0))
    if 1 < different < min(len(points), fewest + 1):
        raise InputError(
            f"{shape}: only {different} of {len(points)} points differ; more than "
            f"{fewest} different ones are needed"
        )
    return points


def _numbers(shape, name, given):
    """An array of floats; InputError for what is none."""
    try:
        return np.asarray(given, float)
    except (TypeError, ValueError) as fault:
        raise InputError(
            f"{shape}: found {name} that are no numbers ({fault}); give an array"
        ) from fault


def _inverse_normal(shape, jacobian):
    normal = jacobian.T @ jacobian
    scale = np.sqrt(np.diag(normal))
    if scale.min() > 0:
        values, vectors = np.linalg.eigh(normal / np.outer(scale, scale))
        if values[0] > OPEN:
            return (vectors / values) @ vectors.T / np.outer(scale, scale)
    raise InputError(
        f"{shape}: the points leave it open; spread them over more of the shape"
    )
