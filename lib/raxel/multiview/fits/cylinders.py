"""Cylinders of unknown axis and radius through points in space.

Directions of the axis are tried over the half sphere: along the right one, the points
form a circle. This needs no normals and works for arcs of 60 degrees. The best are
refined to the least squared distances.

The search is that of Eberly 2003, "Fitting 3D data with a cylinder" (geometrictools),
with circles instead of his quadratic form.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.errors import InputError
from raxel.geometry.poses import pose, tangent_bases
from raxel.multiview.fits.circles import algebraic_circles
from raxel.multiview.fits.planes import (
    COLLINEARITY_TOL,
    checked_points,
    least_distances,
)

MIN_N_POINTS = 7  # for five parameters: five points allow up to six cylinders
N_DIRECTIONS = 600  # trial directions of the axis
N_SEARCH_POINTS = 300  # points that score directions
# Number of refined starts, and largest cosine between two of their axes.
MAX_N_STARTS, MAX_AXIS_COSINE = 6, np.cos(np.radians(12))
N_STEPS, DAMPING = 12, 1e-6
MIN_RADIUS_SIGMAS = 3.0  # radius over its standard deviation
MAX_RADIUS_RATIO = 1e4  # radius over extent


class CylinderFit(NamedTuple):
    """Cylinder about the z axis of a frame, with its covariance.

    Attributes
    ----------
    T_frame_cylinder : ndarray of shape (4, 4)
        Frame of the cylinder. Its origin is on the axis, about abeam of the mean of the
        points. The largest coordinate of z is positive.
    radius : float
        Radius, in the unit of the points.
    covariance : ndarray of shape (5, 5)
        Covariance of rotations about x and y (rad), of shifts along x and y, and of the
        radius, in the cylinder's frame.
    residuals : ndarray of shape (N,)
        Distances of all points, positive outside.
    sigma : float
        Standard deviation of a distance, see `Settled`.
    """

    T_frame_cylinder: np.ndarray
    radius: float
    covariance: np.ndarray
    residuals: np.ndarray
    sigma: float

    @property
    def axis(self) -> NDArray[np.float64]:
        """Unit direction of the axis, shape (3,)."""
        return self.T_frame_cylinder[:3, 2]


def fit_cylinder(points: ArrayLike, sigma: ArrayLike | None = None) -> CylinderFit:
    """Fit the cylinder of least squared distances to points.

    Around a belt hardly higher than the scatter, the axis may tilt farther than the
    covariance indicates: the covariance is that of small tilts.

    Parameters
    ----------
    points : array_like of shape (N, 3)
        Points, N >= 7, any unit.
    sigma : float or array_like of shape (N,), optional
        Standard deviations of the distances. None: equal, and estimated from the
        residuals.

    Returns
    -------
    CylinderFit
        Frame, radius, covariance and residuals.

    Raises
    ------
    InputError
        For fewer than seven points, values that are not finite, and points on a plane.
        Points are also on a plane if the radius is below three of its standard
        deviations.
    """
    points = checked_points("cylinder", points, 3, MIN_N_POINTS)
    _check_flat(points)
    step = -(-len(points) // N_SEARCH_POINTS)
    starts = _refined(_by_direction(points[::step])[None], points[None])[0]
    gaps = np.sum(cylinder_distances(starts, points) ** 2, axis=1)
    start = starts[np.argmin(np.where(np.isfinite(gaps), gaps, np.inf))]
    fit = _settled(points, start, sigma)
    return _as_fit(fit, points)


def cylinder_distances(cylinders, points):
    """Signed distances (m, N) of points (N, 3) from cylinders (m, 7): a point of the
    axis, its unit direction, the radius."""
    errors = points - cylinders[:, None, :3]
    along = np.einsum("mni,mi->mn", errors, cylinders[:, 3:6])
    errors -= along[..., None] * cylinders[:, None, 3:6]
    return np.linalg.norm(errors, axis=2) - cylinders[:, 6:]


def cylinder_system(cylinders, points):
    """Distances (..., N) and their derivatives (..., N, 5) by a step as `turned_axis`.

    cylinders: (..., 7); points: (..., N, 3).
    """
    axis = cylinders[..., None, 3:6]
    errors = points - cylinders[..., None, :3]
    along = np.sum(errors * axis, axis=-1)
    errors = errors - along[..., None] * axis
    separation = np.linalg.norm(errors, axis=-1)
    outward = errors / np.maximum(separation, 1e-300)[..., None]
    by_shift = -outward @ _bases(cylinders)
    # A rotation about x moves the axis along -y, one about y along x.
    by_turn = along[..., None] * by_shift[..., ::-1] * [-1.0, 1.0]
    by_radius = np.full((*separation.shape, 1), -1.0)
    jacobian = np.concatenate([by_turn, by_shift, by_radius], axis=-1)
    return separation - cylinders[..., 6:], jacobian


def turned_axis(cylinders, step):
    """Cylinders (..., 7) after steps (..., 5): rotations about x and y of
    `tangent_bases` of the axis, shifts along these, and the radius."""
    basis = _bases(cylinders)
    tilt = np.stack([step[..., 1], -step[..., 0]], axis=-1)
    axis = cylinders[..., 3:6] + (basis @ tilt[..., None])[..., 0]
    axis = axis / np.linalg.norm(axis, axis=-1, keepdims=True)
    point = cylinders[..., :3] + (basis @ step[..., 2:4, None])[..., 0]
    return np.concatenate([point, axis, cylinders[..., 6:] + step[..., 4:]], axis=-1)


def _bases(cylinders):
    axes = cylinders[..., 3:6]
    return tangent_bases(axes.reshape(-1, 3)).reshape(*axes.shape, 2)


def _by_direction(points):
    """Up to MAX_N_STARTS cylinders (k, 7) of the best circles with distinct axes."""
    cylinders, gaps = _circles_along(points[None], _half_sphere(N_DIRECTIONS))
    order = np.argsort(gaps[0], kind="stable")
    chosen = []
    for i in order[np.isfinite(gaps[0][order])]:
        axis = cylinders[0, i, 3:6]
        if all(abs(axis @ other[3:6]) < MAX_AXIS_COSINE for other in chosen):
            chosen.append(cylinders[0, i])
        if len(chosen) == MAX_N_STARTS:
            break
    if not chosen:
        raise InputError("cylinder: the points are collinear; add points off the line")
    return np.array(chosen)


def _circles_along(samples, axes):
    """Samples (k, n, 3) of points seen along axes (m, 3): the circle of each.

    Returns cylinders (k, m, 7), their points closest to the sample's mean, and mean
    squared distances (k, m); NaN for collinear points.
    """
    middle = samples.mean(axis=1)
    bases = tangent_bases(axes)
    seen = np.einsum("kni,mij->kmnj", samples - middle[:, None], bases)
    circles = algebraic_circles(seen)
    errors = seen - circles[:, :, None, :2]
    gaps = np.hypot(errors[..., 0], errors[..., 1]) - circles[..., 2:]
    point = middle[:, None] + np.einsum("mij,kmj->kmi", bases, circles[..., :2])
    axis = np.broadcast_to(axes, (*gaps.shape[:2], 3))
    cylinders = np.concatenate([point, axis, circles[..., 2:]], axis=-1)
    return cylinders, np.mean(gaps**2, axis=2)


def _refined(cylinders, points):
    """Cylinders (k, s, 7) after N_STEPS Gauss-Newton steps on points (k, n, 3) each.

    cylinders: (k, 7), one a sample, or (k, s, 7). Diverged ones are not finite.
    """
    if cylinders.ndim == 2:
        cylinders = cylinders[:, None]
    points = points[:, None]
    with np.errstate(all="ignore"):
        for _ in range(N_STEPS):
            distances, J = cylinder_system(cylinders, points)
            normal = np.swapaxes(J, -1, -2) @ J
            gradient = (np.swapaxes(J, -1, -2) @ distances[..., None])[..., 0]
            scale = np.sqrt(np.einsum("...ii->...i", normal))
            scale = np.where(scale > 0, scale, 1.0)
            normal = normal / (scale[..., :, None] * scale[..., None, :])
            normal = np.nan_to_num(normal) + DAMPING * np.eye(5)
            step = np.linalg.solve(normal, np.nan_to_num(gradient / scale)[..., None])
            cylinders = turned_axis(cylinders, -step[..., 0] / scale)
    return cylinders


def _half_sphere(count):
    """Directions (count, 3), evenly spaced on half of a sphere (Fibonacci spiral)."""
    z = (np.arange(count) + 0.5) / count
    turn = np.pi * (3 - np.sqrt(5)) * np.arange(count)
    level = np.sqrt(1 - z**2)
    return np.column_stack([level * np.cos(turn), level * np.sin(turn), z])


def _settled(points, start, sigma):
    middle = points.mean(axis=0)
    axis = start[3:6]
    abeam = start[:3] + axis * (axis @ (middle - start[:3]))
    axis = axis * np.sign(axis[np.argmax(np.abs(axis))])
    start = np.concatenate([abeam, axis, start[6:]])
    fit = least_distances(
        "cylinder", cylinder_system, turned_axis, start, points, sigma
    )
    radius, sd = abs(fit.parameters[6]), np.sqrt(fit.covariance[4, 4])
    extent = np.ptp(points, axis=0).max()
    if radius > MAX_RADIUS_RATIO * extent or not radius > MIN_RADIUS_SIGMAS * sd:
        raise InputError(
            f"cylinder: found radius {radius:.3g} +- {sd:.2g} (points nearly on a "
            "plane); give more of its arc"
        )
    return fit


def _as_fit(fit, points):
    cylinder = fit.parameters
    basis, axis = _bases(cylinder), cylinder[3:6]
    T = pose(np.column_stack([basis, axis]), cylinder[:3])
    residuals = cylinder_distances(cylinder[None], points)[0]
    radius = float(cylinder[6])
    return CylinderFit(T, radius, fit.covariance, residuals, fit.sigma)


def _check_flat(points):
    values = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    if not values[2] > COLLINEARITY_TOL * values[0]:
        raise InputError(
            "cylinder: the points are on one plane (undetermined radius); give points "
            "of more of its arc"
        )
