"""Conics through points of a plane, of every kind.

A conic is the six numbers of Q(x, y) = c0 x^2 + c1 x y + c2 y^2 + c3 x + c4 y + c5 = 0,
of length 1, with c0 + c2 >= 0: inside an ellipse Q is negative.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.errors import InputError
from raxel.geometry.homography import normalising
from raxel.geometry.planes import stepped, tangents
from raxel.multiview.fits.planes import checked_points, least_distances

# Fifth over first singular value: below, the conic is undetermined.
MIN_SINGULAR_RATIO = 1e-9
MAX_N_STEPS, STEP_TOL = 30, 1e-13


class ConicFit(NamedTuple):
    """Conic of a plane with its covariance.

    Attributes
    ----------
    coefficients : ndarray of shape (6,)
        Coefficients of Q as in `raxel.multiview.fits.conics`.
    covariance : ndarray of shape (6, 6)
        Covariance of the coefficients, singular along them.
    residuals : ndarray of shape (N,)
        Distances of all points, in their unit, signed as Q.
    sigma : float
        Standard deviation of a distance, see `Settled`.
    """

    coefficients: np.ndarray
    covariance: np.ndarray
    residuals: np.ndarray
    sigma: float


def algebraic_conic(points: ArrayLike) -> NDArray[np.float64]:
    """Return the conic with the least sum of squares of Q.

    The sum is taken after the points are moved to mean zero and root mean square
    distance sqrt(2), with coefficients of length 1. Errors bias the conic towards small
    ellipses. It measures distortion rather than estimating a shape, as in the thesis.

    Parameters
    ----------
    points : array_like of shape (N, 2)
        Points, N >= 5, any unit.

    Returns
    -------
    ndarray of shape (6,)
        Coefficients of Q(x, y) = c0 x^2 + c1 x y + c2 y^2 + c3 x + c4 y + c5, of length
        1 and with c0 + c2 >= 0.

    Raises
    ------
    InputError
        For fewer than five points, values that are not finite, and points that do not
        determine a conic, such as four on a line.

    References
    ----------
    Thesis 5.3.4.
    """
    points = checked_points("conic", points, 2, 5)
    T = _normalising(points)
    return _in_frame(_algebraic(_moved(T, points)), T)[0]


def fit_conic(points: ArrayLike, sigma: ArrayLike | None = None) -> ConicFit:
    """Fit the conic, of any kind, of least squared distances to points.

    The fit starts from `algebraic_conic`. Coefficients are in the unit of the points.
    Digits are lost if the conic is far from zero for its size: move such points near
    zero.

    Parameters
    ----------
    points : array_like of shape (N, 2)
        Points, N >= 5, any unit.
    sigma : float or array_like of shape (N,), optional
        Standard deviations of the distances. None: equal, and estimated from the
        residuals.

    Returns
    -------
    ConicFit
        Coefficients, covariance and residuals.

    Raises
    ------
    InputError
        As `algebraic_conic`.
    """
    points = checked_points("conic", points, 2, 5)
    T = _normalising(points)
    moved = _moved(T, points)
    start = _algebraic(moved)
    fit = least_distances("conic", _system, stepped, start, moved, _scaled(sigma, T))
    return _as_fit(fit, T, points, sigma)


def conic_distances(
    coefficients: NDArray[np.float64], points: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return signed distances of points from a conic, and the nearest points.

    Newton's method starts from the first-order distance. It finds a foot of the point's
    normal, which is the nearest one for points near the conic. Where it finds none, as
    from the middle of a circle, the first-order distance Q / |grad Q| is returned.

    Parameters
    ----------
    coefficients : ndarray of shape (6,)
        Coefficients of Q.
    points : ndarray of shape (N, 2)
        Points, in the unit of the coefficients.

    Returns
    -------
    distances : ndarray of shape (N,)
        Distances, signed as Q.
    feet : ndarray of shape (N, 2)
        Points of the conic.
    """
    start = points - _newton_shift(coefficients, points)
    feet = start.copy()
    _, H = _gradient(coefficients, points)
    last = np.full(len(points), np.inf)
    for _ in range(MAX_N_STEPS):
        g, _ = _gradient(coefficients, feet)
        e = feet - points
        # Q = 0, and the vector from the point is along the gradient.
        on, along = value(coefficients, feet), g[:, 0] * e[:, 1] - g[:, 1] * e[:, 0]
        by_x = H[0, 0] * e[:, 1] - H[1, 0] * e[:, 0] - g[:, 1]
        by_y = H[0, 1] * e[:, 1] - H[1, 1] * e[:, 0] + g[:, 0]
        det = g[:, 0] * by_y - g[:, 1] * by_x
        det = np.where(np.abs(det) > 1e-300, det, np.nan)
        step = (
            np.column_stack([by_y * on - g[:, 1] * along, g[:, 0] * along - by_x * on])
            / det[:, None]
        )
        going = np.isfinite(step).all(axis=1)
        feet[going] -= step[going]
        last = np.where(going, np.abs(step).max(axis=1), np.inf)
        if not np.any(last > STEP_TOL * (1 + np.abs(feet).max(axis=1))):
            break
    lost = ~(last < 1e-9 * (1 + np.abs(feet).max(axis=1)))
    feet[lost] = start[lost]
    away = np.hypot(*(feet - points).T)
    return np.sign(value(coefficients, points)) * away, feet


def value(coefficients: ArrayLike, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the values of Q at points.

    Parameters
    ----------
    coefficients : array_like of shape (..., 6)
        Coefficients of Q.
    points : ndarray of shape (..., N, 2)
        Points, in the unit of the coefficients.

    Returns
    -------
    ndarray of shape (..., N)
        Values of Q, negative inside an ellipse.
    """
    return (_monomials(points) @ np.asarray(coefficients)[..., None])[..., 0]


def _monomials(points):
    x, y = points[..., 0], points[..., 1]
    return np.stack([x * x, x * y, y * y, x, y, np.ones_like(x)], axis=-1)


def _gradient(coefficients, points):
    """Gradients (..., N, 2) of Q, and its second derivatives (..., 2, 2)."""
    c = np.asarray(coefficients)
    H = np.stack([2 * c[..., 0], c[..., 1], c[..., 1], 2 * c[..., 2]], axis=-1)
    H = H.reshape(*c.shape[:-1], 2, 2)
    return points @ H + c[..., None, 3:5], H


def _newton_shift(coefficients, points):
    g, _ = _gradient(coefficients, points)
    size = np.maximum(np.sum(g**2, axis=-1, keepdims=True), 1e-300)
    return g * (value(coefficients, points)[..., None] / size)


def _algebraic(points):
    """Coefficients (6,) for points that have been normalised."""
    _, values, Vt = np.linalg.svd(np.linalg.qr(_monomials(points), mode="r"))
    if len(values) > 4 and not values[4] > MIN_SINGULAR_RATIO * values[0]:
        raise InputError(
            "conic: the points do not determine it (four of five collinear, or "
            "repeated); add other points"
        )
    return Vt[5]


def _system(coefficients, points):
    """Distances and their derivatives (N, 5) by a step along the sphere."""
    distances, feet = conic_distances(coefficients, points)
    g, _ = _gradient(coefficients, feet)
    # A change of Q moves the conic by -dQ / |grad Q| at the foot.
    size = np.maximum(np.linalg.norm(g, axis=1, keepdims=True), 1e-300)
    return distances, _monomials(feet) / size @ tangents(coefficients)


def _normalising(points):
    try:
        return normalising(points)
    except InputError:
        raise InputError(
            "conic: all points are equal; give distinct points of a curve"
        ) from None


def _moved(T, points):
    return T[0, 0] * points + T[:2, 2]


def _scaled(sigma, T):
    return None if sigma is None else np.asarray(sigma, float) * T[0, 0]


def _in_frame(coefficients, T):
    """A conic (6,) of normalised points in their own frame, and its Jacobian (6, 6)."""
    s, (u, v) = T[0, 0], T[:2, 2]
    carried = np.zeros((6, 6))
    # Q(s x + u, s y + v), monomial by monomial.
    carried[0, 0] = carried[1, 1] = carried[2, 2] = s * s
    carried[3] = [2 * s * u, s * v, 0, s, 0, 0]
    carried[4] = [0, s * u, 2 * s * v, 0, s, 0]
    carried[5] = [u * u, u * v, v * v, u, v, 1]
    c = carried @ coefficients
    size = np.linalg.norm(c) * (-1 if c[0] + c[2] < 0 else 1)
    c = c / size
    return c, (np.eye(6) - np.outer(c, c)) @ carried / size


def _as_fit(fit, T, points, sigma):
    c, carried = _in_frame(fit.parameters, T)
    J = carried @ tangents(fit.parameters)
    distances, _ = conic_distances(c, points)
    covariance = J @ fit.covariance @ J.T
    # No length in px where given standard deviations are the unit.
    scatter = fit.sigma / T[0, 0] if sigma is None else fit.sigma
    return ConicFit(c, covariance, distances, scatter)
