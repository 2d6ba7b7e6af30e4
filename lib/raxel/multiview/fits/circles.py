"""Circles through points of a plane, and of a plane in space."""

from typing import NamedTuple

import numpy as np

from raxel.errors import InputError
from raxel.geometry.poses import inverse_pose, pose, transform
from raxel.multiview.fits.orthogonal import agreeing, checked_points, least_distances
from raxel.multiview.fits.planes import PlaneFit, fit_plane

STRAIGHT = 1e-9  # sagitta over extent of points that lie on a line


class CircleFit(NamedTuple):
    """centre (2,), radius, and their covariance (3, 3), in the unit of the points.

    residuals: (N,) distances of all points, positive outside; sigma: see `Settled`;
    inliers: (N,) bool.
    """

    centre: np.ndarray
    radius: float
    covariance: np.ndarray
    residuals: np.ndarray
    sigma: float
    inliers: np.ndarray


class SpaceCircleFit(NamedTuple):
    """A circle in space: about the origin of T_frame_circle (4, 4), in its z = 0.

    plane: the `PlaneFit` whose axes the frame has; circle: the `CircleFit` in it.
    """

    T_frame_circle: np.ndarray
    plane: PlaneFit
    circle: CircleFit

    @property
    def radius(self):
        """In the unit of the points."""
        return self.circle.radius


def fit_circle(points, sigma=None):
    """The circle of least squared distances from points of a plane.

    points: (N, 2), N >= 3, any unit; sigma: standard deviations of the distances, a
    number or (N,), or None: equal, and measured by what is left. It begins with
    `algebraic_circles`. Returns CircleFit. Raises InputError for fewer than three
    points, values that are not finite, and points on one line.
    """
    points = checked_points("circle", points, 2, 3)
    fit = _settled(points, _start(points), sigma)
    return _as_fit(fit, points, np.ones(len(points), bool))


def fit_circle_ransac(points, rng, threshold, sigma=None):
    """As `fit_circle`, where some points are wrong.

    rng: numpy Generator; threshold: largest distance of a right point; sigma: one
    number or None. Samples of three points; five or more must agree.
    """
    points = checked_points("circle", points, 2, 5)

    def minimal(samples):
        circles = algebraic_circles(samples)
        return circles[np.isfinite(circles).all(axis=1)]

    fit, right = agreeing(
        "circle",
        points,
        minimal,
        circle_distances,
        lambda some, start: _settled(some, start, sigma),
        3,
        rng,
        threshold,
    )
    return _as_fit(fit, points, right)


def fit_circle_in_space(points, sigma=None):
    """The circle near points in space: their plane, then the circle in it.

    points: (N, 3); sigma: as `fit_circle`, of the distances in the plane and out of it.
    A turn of the plane moves points within it by the square of the turn alone, so both
    steps together minimise the distances in space, but for terms of second order in
    the errors. Returns SpaceCircleFit. Raises InputError as `fit_plane` and
    `fit_circle`.
    """
    plane = fit_plane(points, sigma)
    flat = transform(inverse_pose(plane.T_frame_plane), np.asarray(points, float))
    circle = fit_circle(flat[:, :2], sigma)
    T = plane.T_frame_plane @ pose(np.eye(3), [*circle.centre, 0.0])
    return SpaceCircleFit(T, plane, circle)


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


def _as_fit(fit, points, right):
    circle = fit.parameters
    residuals = circle_distances(circle[None], points)[0]
    return CircleFit(
        circle[:2], float(circle[2]), fit.covariance, residuals, fit.sigma, right
    )
