"""How far a picture is from perspective: the pinhole nearest to what it shows.

Eleven numbers, the finest that any homography of any perspective picture could do. What
is left is distortion that no pinhole has, by a lens or by rays that meet in no point.
Source: Hartley and Zisserman 2004, doi:10.1017/CBO9780511811685, chapter 7.
"""

from typing import NamedTuple

import numpy as np

from raxel.errors import InputError
from raxel.geometry.damped import descend, gauss_newton
from raxel.geometry.unit_sphere import stepped, tangents
from raxel.multiview.fits.orthogonal import FARTHEST

FEWEST = 6
FLAT = 1e-6  # extent across over the greatest, of points that are as good as on a plane
ITERATIONS, AT_REST = 100, 1e-12
ROUNDING = 1e-13  # of the picture's extent: residuals of exact points


class PinholeFit(NamedTuple):
    """P: (3, 4), |P| = 1, maps homogeneous points to pixels; centre: (3,), its eye.

    residuals: (N, 2) px, shown less mapped; rms: px, root mean square of their lengths.
    """

    P: np.ndarray
    centre: np.ndarray
    residuals: np.ndarray
    rms: float


def nearest_pinhole(points, pixels):
    """The pinhole of least squared distances between its picture and pixels.

    points: (N, 3), N >= 6, not on one plane, any frame and unit; pixels: (N, 2), where
    they are shown. A linear start, then Levenberg and Marquardt. Returns PinholeFit.
    Raises InputError for fewer than six points, values that are not finite, points on
    one plane (a homography of the plane does for these:
    `raxel.evaluation.distortion.distortion_residual`), or that leave it open.
    """
    points, pixels = _checked(points, pixels)
    T_points, T_pixels = _normalising(points), _normalising(pixels)
    X, x = _moved(T_points, points), _moved(T_pixels, pixels)
    P, costs, _ = descend(
        lambda P: _evaluated(P, X, x),
        stepped,
        _linear(X, x).ravel(),
        iterations=ITERATIONS,
        tolerance=AT_REST,
        rounding=len(X) * ROUNDING**2,
    )
    scale = T_pixels[0, 0]
    P = np.linalg.solve(T_pixels, P.reshape(3, 4) @ T_points)
    P /= np.linalg.norm(P)
    middle = np.append(points.mean(axis=0), 1)
    P *= np.sign(P[2] @ middle) or 1.0
    centre = np.linalg.svd(P)[2][3]
    with np.errstate(divide="ignore", invalid="ignore"):
        centre = centre[:3] / centre[3]
    residuals = pixels - mapped(P, points)
    rms = float(np.sqrt(costs[-1] / len(points))) / scale
    return PinholeFit(P, centre, residuals, rms)


def mapped(P, points):
    """Pixels (N, 2) of points (N, 3) by a matrix P (3, 4)."""
    x = np.asarray(points) @ P[:, :3].T + P[:, 3]
    return x[:, :2] / x[:, 2:]


def pinhole_jacobian(P, points):
    """Derivatives (N, 2, 12) of `mapped` by the entries of P, row by row."""
    X = np.column_stack([points, np.ones(len(points))])
    X = X / (X @ P[2])[:, None]
    seen = mapped(P, points)
    J = np.zeros((len(X), 2, 12))
    J[:, 0, :4] = J[:, 1, 4:8] = X
    J[:, :, 8:] = -seen[:, :, None] * X[:, None]
    return J


def _evaluated(p, X, x):
    P = p.reshape(3, 4)
    left = (mapped(P, X) - x).ravel()
    return gauss_newton(
        left, lambda: pinhole_jacobian(P, X).reshape(-1, 12) @ tangents(p)
    )


def _linear(X, x):
    """P (3, 4) of the least sum of squared algebraic errors."""
    X = np.column_stack([X, np.ones(len(X))])
    A = np.zeros((2, len(X), 12))
    A[0, :, :4] = A[1, :, 4:8] = X
    A[:, :, 8:] = -x.T[:, :, None] * X
    values, Vt = np.linalg.svd(np.linalg.qr(A.reshape(-1, 12), mode="r"))[1:]
    if not values[10] > 1e-10 * values[0]:
        raise InputError(
            "pinhole: the points leave it open; give more of them, at more depths"
        )
    return Vt[11].reshape(3, 4)


def _checked(points, pixels):
    points, pixels = np.asarray(points, float), np.asarray(pixels, float)
    many = points.shape[:1]
    if points.shape != (*many, 3) or pixels.shape != (*many, 2):
        raise InputError(
            f"pinhole: found points {points.shape} and pixels {pixels.shape}; give "
            "arrays (N, 3) and (N, 2)"
        )
    bad = ~(np.isfinite(points).all(axis=1) & np.isfinite(pixels).all(axis=1))
    if bad.any():
        raise InputError(
            f"pinhole: {bad.sum()} of {len(bad)} points or pixels are not finite; "
            "remove them"
        )
    if len(points) < FEWEST:
        raise InputError(f"pinhole: {len(points)} points; {FEWEST} or more are needed")
    if max(np.abs(points).max(), np.abs(pixels).max()) > FARTHEST:
        raise InputError(
            f"pinhole: a point or pixel is beyond {FARTHEST:g}; remove what is next to "
            "infinity"
        )
    if not np.ptp(pixels, axis=0).all():
        raise InputError(
            "pinhole: all pixels lie in one row or column; give points all over the "
            "picture"
        )
    extents = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    if not extents[2] > FLAT * extents[0]:
        raise InputError(
            "pinhole: the points lie on one plane, which any pinhole shows alike; give "
            "points before or behind it"
        )
    return points, pixels


def _normalising(points):
    """Similarity (d + 1, d + 1) to mean zero and mean square distance d."""
    d = points.shape[1]
    middle = points.mean(axis=0)
    scale = np.sqrt(d / np.mean(np.sum((points - middle) ** 2, axis=1)))
    T = np.diag([*[scale] * d, 1.0])
    T[:d, d] = -scale * middle
    return T


def _moved(T, points):
    return T[0, 0] * points + T[:-1, -1]
