"""Shape of a bent mirror from scene points whose places are known (5.2.2, 5.29).

The sum of squared ray-point distances falls by Levenberg-Marquardt steps in the free
unknowns of the clamp's subspace, so that the clamp stays exactly; where its place is
uncertain, its equations count with stated weights instead. A prior may be added: then
squares are told in standard deviations, of the residuals by the noise of the corners.
"""

from typing import NamedTuple

import numpy as np

from raxel.calibration.mirror.clamp import TRUNCATION, clamped, soft_clamp
from raxel.calibration.mirror.ray_points import RayPoints
from raxel.cameras.mirrors.spline import SplineMirrorCamera
from raxel.errors import CalibrationError, InputError
from raxel.geometry.damped import descend, gauss_newton

ITERATIONS, AT_REST = 50, 1e-7
ROUNDING = 1e-9  # standard deviations: residuals of points that fit exactly
# Of the normal matrix's largest eigenvalue, after scaling: below it is nothing.
OPEN = 1e-13


class ShapeFit(NamedTuple):
    """coefficients (K,); costs: sum of squares at the start and after each step, in
    squared standard deviations; residuals (N, 3) mm; converged; sd_mm: standard
    deviation that was taken for each component of a residual; covariance (K, K) of the
    coefficients, of corner noise, grid pose and prior; prior_share: of all the degrees
    of freedom, those that the prior settles.
    """

    coefficients: np.ndarray
    costs: np.ndarray
    residuals: np.ndarray
    converged: bool
    sd_mm: float
    covariance: np.ndarray
    prior_share: float


def refine_shape(
    p,
    points,
    grid,
    quantity,
    start,
    *,
    noise,
    clamp=None,
    prior=None,
    weights=None,
    point_motion=None,
    pose_covariance=None,
    truncation=TRUNCATION,
):
    """ShapeFit of a spline mirror to points seen in its rays.

    p: (N, 2) normalised image coordinates; points: (N, 3) mm, viewer's frame; start:
    (K,) coefficients, made to keep the clamp. noise: standard deviation of p along each
    axis, a number or (N,), in the unit of p. clamp: Clamp or FixedLine; prior:
    PriorRows. weights: (N,), each multiplies a residual. point_motion (N, 3, 6) and
    pose_covariance (6, 6): how the points move with the grid's pose, and how uncertain
    that is. Raises CalibrationError for data that leave coefficients open, and for a
    mirror that comes out behind the viewer.
    """
    rays = RayPoints(p, grid, quantity)
    weights = np.ones(len(p)) if weights is None else np.asarray(weights, float)
    further = [soft_clamp(grid, clamp), prior]
    # Soft equations take the clamp's place in the subspace.
    space = clamped(grid, clamp if further[0] is None else None, truncation)
    rows, values = stacked([part for part in further if part is not None], grid.size)
    noise = np.broadcast_to(noise, len(p))
    free = space.free(start)
    c = space.coefficients(free)
    if not rays.in_front(c):
        raise CalibrationError(
            "mirror shape: the start lies in part behind the camera; too few features,"
            " or directions that do not belong to them",
            code="behind-camera",
        )
    sd = residual_sd(rays, c, points, noise, weights > 0)

    def evaluate(free):
        c = space.coefficients(free)
        if not rays.in_front(c):
            return np.inf, None
        scaled = weights[:, None] / sd * rays.residuals(c, points)
        whole = np.concatenate([scaled.ravel(), rows @ c - values])

        def jacobian():
            scaled = (weights / sd)[:, None, None] * rays.jacobian(c, points)
            return np.vstack([scaled.reshape(-1, grid.size), rows]) @ space.directions

        return gauss_newton(whole, jacobian)

    free, costs, converged = descend(
        evaluate,
        lambda free, step: free + step,
        free,
        iterations=ITERATIONS,
        tolerance=AT_REST,
        rounding=ROUNDING**2 * len(p),
    )
    c = space.coefficients(free)
    jacobian = rays.jacobian(c, points)
    scaled = (weights / sd)[:, None, None] * jacobian
    reach = np.vstack([scaled.reshape(-1, grid.size), rows]) @ space.directions
    inverse = _inverse(reach.T @ reach, len(p), grid)
    spread = _data_spread(rays, c, points, noise, scaled @ space.directions,
                          weights / sd, point_motion, pose_covariance)  # fmt: skip
    soft = rows @ space.directions
    spread += soft.T @ soft
    covariance = space.directions @ inverse @ spread @ inverse @ space.directions.T
    share = np.trace(inverse @ (soft.T @ soft)) / max(len(free), 1)
    return ShapeFit(
        c, costs, rays.residuals(c, points), converged, sd, covariance, float(share)
    )


def camera_of_shape(viewer, grid, coefficients, quantity):
    """The SplineMirrorCamera of a shape that was found.

    Raises CalibrationError where part of the mirror lies behind the viewer, as between
    features, or beyond them, where nothing holds a spline.
    """
    try:
        return SplineMirrorCamera.on_grid(viewer, grid, coefficients, quantity)
    except InputError as fault:
        raise CalibrationError(
            f"mirror shape: {fault}; use fewer knots, a smaller deflection, features "
            "that reach the mirror's edges, or a prior",
            code="behind-camera",
        ) from fault


def ray_sd(p, grid, quantity, coefficients, covariance):
    """Standard deviation (N,) of scene directions, radians, root mean square of the two
    ways across the ray, at p (N, 2); NaN outside the knots.

    covariance: (K, K) of the coefficients.
    """
    J = RayPoints(p, grid, quantity).direction_jacobian(coefficients)
    return np.sqrt(np.einsum("nik,kl,nil->n", J, covariance, J) / 2)


def residual_sd(rays, c, points, noise, used=slice(None)):
    """What the noise of p makes of a residual's component, rms, mm: that of a flat
    mirror, in which a ray runs straight on. One for all: the cost stays the thesis's
    sum of squared distances.
    """
    S, _ = rays.surface(c)
    path = np.linalg.norm(S, axis=1) + np.linalg.norm(points - S, axis=1)
    return float(np.sqrt(np.mean((path * noise)[used] ** 2)))


def _data_spread(rays, c, points, noise, reach, weights, motion, pose_covariance):
    """(F, F): covariance of half the gradient, from corner noise and grid pose.

    reach: (N, 3, F), Jacobian of the weighted residuals.
    """
    change = rays.picture_jacobian(c, points) * (weights * noise)[:, None, None]
    gradient = np.einsum("nif,nij->fnj", reach, change).reshape(reach.shape[2], -1)
    spread = gradient @ gradient.T
    if pose_covariance is not None:
        moved = weights[:, None, None] * (rays.across(c) @ motion)
        common = np.einsum("nif,nij->fj", reach, moved)
        spread = spread + common @ pose_covariance @ common.T
    return spread


def stacked(parts, size):
    """Rows (R, K) and values (R,), each over its standard deviation."""
    rows = [part.rows / np.reshape(part.sd, (-1, 1)) for part in parts]
    values = [part.values / part.sd for part in parts]
    return np.vstack([np.zeros((0, size)), *rows]), np.concatenate([[], *values])


def _inverse(normal, count, grid):
    scale = np.sqrt(np.maximum(np.diag(normal), 1e-300))
    eigen, vectors = np.linalg.eigh(normal / np.outer(scale, scale))
    if not eigen[0] > OPEN * eigen[-1]:
        raise CalibrationError(
            f"mirror shape: {count} features leave {np.sum(eigen <= OPEN * eigen[-1])}"
            f" of {grid.size} coefficients open; give features in all knot intervals, "
            "fewer knots, or a prior",
            code="open-coefficients",
        )
    return (vectors / eigen) @ vectors.T / np.outer(scale, scale)
