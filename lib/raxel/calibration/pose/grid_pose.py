"""Pose of a planar grid from the calibrated rays of a central camera, linearly.

The rays intersect a freely chosen plane, the synthetic image plane of section 4.2.1.
There the grid's image is a homography of the grid for any lens, and the pose follows as
for a pinhole camera (4.22, 4.23). All points are used at once, so RANSAC can estimate
the pose from all inliers without iteration. The last step, not in the thesis, minimises
the angles between rays and points.

Frame: that of the rays, with the camera's centre as its origin.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.calibration.pose.three_point import (
    COST_TOL,
    N_SCORING_POINTS,
    RayPose,
    checked_rays,
    moved_pose,
    ray_errors,
)
from raxel.errors import CalibrationError, InputError
from raxel.geometry.homography import (
    homography_dlt,
    homography_ransac,
    refit_to_inliers,
)
from raxel.geometry.least_squares import descend, gauss_newton
from raxel.geometry.poses import nearest_rotation, pose, tangent_bases

# Cosine to the plane's normal below which a ray counts as behind the plane: its point
# on the plane would be a hundred times farther away than the plane.
MIN_INCIDENCE_COSINE = 0.01
ROUNDING_RAD = 1e-15  # angles between exact rays and points


class AngularPose(NamedTuple):
    """Pose of a grid that minimises the angles between rays and points.

    Attributes
    ----------
    T_camera_grid
        (4, 4), pose of the grid in the camera frame of the rays.
    covariance
        (6, 6) of (w, s), the error of the pose as R exp([w]x), t + R s, in rad and the
        unit of the grid.
    rms
        Root mean square angle between ray and point, rad.
    iterations
        Number of steps that lowered the error.
    """

    T_camera_grid: np.ndarray
    covariance: np.ndarray
    rms: float
    iterations: int


def synthetic_plane_normal(directions: ArrayLike) -> NDArray[np.float64]:
    """Return the normal of the plane that is most nearly perpendicular to the rays.

    The normal is the dominant eigenvector of the sum of r r^T. It minimises the squared
    sines of the angles to the rays (E-4.07). Its sign puts most rays in front.

    Parameters
    ----------
    directions
        (N, 3), unit vectors of the rays.

    Returns
    -------
    NDArray
        (3,), unit normal.

    References
    ----------
    Thesis (4.24).
    """
    directions = np.asarray(directions, float)
    normal = np.linalg.eigh(directions.T @ directions)[1][:, 2]
    ahead = np.count_nonzero(directions @ normal > 0)
    return normal if 2 * ahead >= len(directions) else -normal


def facing_plane_normal(directions: ArrayLike) -> NDArray[np.float64]:
    """Return the normal of a synthetic plane that most rays meet in front.

    The result is that of (4.24) where no ray leads away from its plane. Rays in a wide
    ring have their dominant eigenvector across the ring. Their normal is the mean
    direction or another eigenvector, whichever loses the fewest rays.

    Parameters
    ----------
    directions
        (N, 3), unit vectors of the rays.

    Returns
    -------
    NDArray
        (3,), unit normal.

    References
    ----------
    Thesis (4.24).
    """
    directions = np.asarray(directions, float)
    axes = np.linalg.eigh(directions.T @ directions)[1].T[::-1]
    mean = directions.mean(axis=0)
    mean /= max(np.linalg.norm(mean), 1e-300)
    candidates = np.stack([synthetic_plane_normal(directions), mean, *axes, *-axes])
    seen = np.count_nonzero(directions @ candidates.T > MIN_INCIDENCE_COSINE, axis=0)
    return candidates[np.argmax(seen)]


def linear_grid_pose(
    directions: ArrayLike,
    points: ArrayLike,
    *,
    normal: ArrayLike | None = None,
    metric: str = "ray-point",
) -> RayPose:
    """Return the pose of a grid from all points, by the linear method of CGSP.

    Rays that do not meet the synthetic plane in front of the camera are excluded and
    counted.

    Parameters
    ----------
    directions
        (N, 3), unit vectors of rays with one common origin, camera frame.
    points
        (N, 2), points on the grid, N >= 4.
    normal
        (3,), normal of the synthetic image plane. None: `facing_plane_normal`.
    metric
        Error that `rms` measures: "ray-point" (4.18), in the unit of the grid, or
        "angle", in rad.

    Returns
    -------
    RayPose
        Pose `T_camera_grid`, with every ray that was used as an inlier.

    Raises
    ------
    CalibrationError
        Fewer than four points are in front of the plane ("too-few-rays"), the normal is
        zero or not finite ("normal"), the arrays do not fit ("shape",
        "too-few-points", "not-finite"), or the points determine no pose.

    References
    ----------
    Thesis (4.19) to (4.24).

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.calibration import linear_grid_pose
    >>> points = np.array([[0, 0], [100, 0], [0, 100], [100, 100], [50, 20]])
    >>> p = np.column_stack([points, np.zeros(5)]) + [-50, -40, 500]
    >>> directions = p / np.linalg.norm(p, axis=1, keepdims=True)
    >>> found = linear_grid_pose(directions, points)
    >>> [round(float(t)) for t in found.T_camera_grid[:3, 3]]
    [-50, -40, 500]
    """
    directions, points = checked_rays(directions, points)
    axes, image, ahead = _synthetic_image(directions, normal)
    H = _refusing(homography_dlt, points[ahead], image[ahead])
    return _found(directions, points, axes @ H, ahead, ahead, metric)


def grid_pose_ransac(
    directions: ArrayLike,
    points: ArrayLike,
    rng: np.random.Generator,
    threshold: float,
    *,
    metric: str = "ray-point",
    normal: ArrayLike | None = None,
    confidence: float = 0.999,
    most_trials: int = 2000,
) -> RayPose:
    """Return the pose of a grid in the presence of wrong pairs, by CGSP with RANSAC.

    Samples of four points give homographies, which are scored on up to N_SCORING_POINTS
    points. The best is re-estimated linearly from all its inliers until they no longer
    change.

    Parameters
    ----------
    directions
        (N, 3), unit vectors of rays with one common origin, camera frame.
    points
        (N, 2), points on the grid, N >= 4.
    rng
        Random generator of numpy.
    threshold
        Largest error of an inlier: a length for metric "ray-point", rad for "angle".
    metric
        "ray-point" (4.18) or "angle".
    normal
        (3,), normal of the synthetic image plane. None: `facing_plane_normal`.
    confidence
        Probability that one sample contains inliers alone.
    most_trials
        Largest number of samples.

    Returns
    -------
    RayPose
        Pose `T_camera_grid` and its inliers.

    Raises
    ------
    CalibrationError
        As `linear_grid_pose`, also for fewer than four inliers.

    References
    ----------
    Thesis (4.19) to (4.24).

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.calibration import grid_pose_ransac
    >>> x, y = np.meshgrid(np.arange(5) * 20.0, np.arange(4) * 20.0)
    >>> points = np.column_stack([x.ravel(), y.ravel()])
    >>> p = np.column_stack([points, np.zeros(20)]) + [-40, -30, 400]
    >>> directions = p / np.linalg.norm(p, axis=1, keepdims=True)
    >>> points[3] += 25
    >>> found = grid_pose_ransac(directions, points, np.random.default_rng(0), 1.0)
    >>> np.flatnonzero(~found.inliers).tolist()
    [3]
    """
    directions, points = checked_rays(directions, points)
    axes, image, ahead = _synthetic_image(directions, normal)
    chosen = np.flatnonzero(ahead)
    judges = np.sort(rng.permutation(chosen)[:N_SCORING_POINTS])

    def errors_of(which):
        return lambda H: _errors(directions[which], points[which], axes @ H, metric)

    H, _ = _refusing(
        homography_ransac,
        points[judges],
        image[judges],
        threshold,
        rng,
        squared_errors=lambda H: errors_of(judges)(H) ** 2,
        confidence=confidence,
        most_trials=most_trials,
    )
    H, right = _refusing(
        refit_to_inliers,
        H,
        points[chosen],
        image[chosen],
        lambda H: errors_of(chosen)(H[None])[0] < threshold,
    )
    inliers = np.zeros(len(points), bool)
    inliers[chosen[right]] = True
    return _found(directions, points, axes @ H, inliers, ahead, metric)


def refine_pose_angular(
    directions: ArrayLike,
    points: ArrayLike,
    T_camera_grid: ArrayLike,
    *,
    sigma: ArrayLike | None = None,
    most: int = 50,
) -> AngularPose:
    """Return the pose that minimises the squared angles between rays and points.

    For image noise of a camera with even magnification, the result is the maximum
    likelihood estimate. Method: Levenberg-Marquardt with an analytic Jacobian. Not in
    the thesis.

    Parameters
    ----------
    directions
        (N, 3), unit vectors of rays with one common origin, N >= 4.
    points
        (N, 2), points on the grid, without wrong pairs.
    T_camera_grid
        (4, 4), start, such as a linear pose.
    sigma
        Standard deviation of each angle in each of its two directions, rad, a number or
        (N,). Each angle is divided by its own. None: equal and unknown, estimated from
        the residual angles.
    most
        Largest number of steps.

    Returns
    -------
    AngularPose
        Pose, covariance, RMS angle and number of steps.

    Raises
    ------
    CalibrationError
        The points do not determine the pose ("degenerate-points"), there are fewer than
        four ("too-few-points"), sigma does not fit ("sigma"), or the arrays do not fit
        ("shape", "not-finite").
    """
    directions, points = checked_rays(directions, points)
    if len(points) < 4:
        raise CalibrationError(
            f"pose from rays: found {len(points)} points; give four or more to refine",
            code="too-few-points",
        )
    if sigma is not None and not (
        np.shape(sigma) in ((), (len(points),)) and np.all(np.asarray(sigma) > 0)
    ):
        raise CalibrationError(
            f"pose from rays: field 'sigma': found shape {np.shape(sigma)}; give one "
            f"number or {len(points)}, all above 0",
            code="sigma",
        )
    weights = np.ones(len(points)) / (1.0 if sigma is None else np.asarray(sigma))
    across = tangent_bases(directions)

    def system(T):
        residual, jacobian = angular_system(directions, across, points, T)
        whitened = jacobian * weights[:, None, None]
        return (residual * weights[:, None]).ravel(), lambda: whitened.reshape(-1, 6)

    T, costs, _ = descend(
        lambda T: gauss_newton(*system(T)),
        moved_pose,
        np.array(T_camera_grid, float),
        iterations=most,
        tolerance=COST_TOL,
        rounding=ROUNDING_RAD**2 * np.sum(weights**2),
    )
    residual, jacobian = angular_system(directions, across, points, T)
    jacobian = (jacobian * weights[:, None, None]).reshape(-1, 6)
    return AngularPose(
        T,
        _covariance(jacobian.T @ jacobian, len(jacobian), costs[-1], sigma),
        float(np.sqrt(np.mean(np.sum(residual**2, axis=1)))),
        len(costs) - 1,
    )


def angular_system(
    directions: np.ndarray,
    across: np.ndarray,
    points: np.ndarray,
    T_camera_grid: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Return residuals and Jacobian of the angles from rays to points.

    A residual points from the ray to the point on the sphere. Its length is the angle
    between them, in rad.

    Parameters
    ----------
    directions
        (N, 3), unit vectors of the rays.
    across
        (N, 3, 2), two directions perpendicular to each ray, from `tangent_bases`.
    points
        (N, 2), points on the grid.
    T_camera_grid
        (4, 4), pose of the grid.

    Returns
    -------
    residuals : ndarray
        (N, 2), rad.
    jacobian : ndarray
        (N, 2, 6), columns as `motion_of_points`.
    """
    axes = np.concatenate([across, directions[:, :, None]], axis=2).reshape(-1, 9)
    # Columns of the pose, (4, 3, N), in frames with the ray as the last axis.
    R_1, R_2, R_3, t = (T_camera_grid[:3].T @ axes.T.reshape(3, -1)).reshape(4, 3, -1)
    x, y = points.T
    p, d = (
        R_1 * x + R_2 * y + t,
        np.stack([R_3 * y, -R_3 * x, R_2 * x - R_1 * y, R_1, R_2, R_3]),
    )
    errors, along = np.hypot(p[0], p[1]), p[2]
    square = errors**2 + along**2
    # angle / sine, and its derivative by sine^2 / 2; by their series near the ray.
    near = errors < 1e-3 * along
    u = np.where(near, errors / np.where(near, along, 1.0), 0.0) ** 2
    far = np.where(near, 1.0, errors)
    factor = np.where(
        near, (1 - u / 3 + u**2 / 5) / along, np.arctan2(errors, along) / far
    )
    slope = np.where(
        near,
        (-2 / 3 + 4 * u / 5 - 6 * u**2 / 7) / along**3,
        (along / square - factor) / far**2,
    )
    change = slope * (p[0] * d[:, 0] + p[1] * d[:, 1]) - d[:, 2] / square
    jacobian = factor * d[:, :2] + p[:2] * change[:, None]
    return (factor * p[:2]).T, jacobian.T


def _synthetic_image(directions, normal):
    """Axes (3, 3) of the synthetic camera in columns, the image (N, 2) on its plane at
    distance 1, and which rays meet that plane in front (N,)."""
    if normal is None:
        normal = facing_plane_normal(directions)
    normal = np.asarray(normal, float)
    if not (normal.shape == (3,) and np.isfinite(normal).all() and normal.any()):
        raise CalibrationError(
            f"pose from rays: normal of the synthetic plane: found {normal}; give "
            "three numbers that are not all zero",
            code="normal",
        )
    normal = normal / np.linalg.norm(normal)
    axes = np.column_stack([tangent_bases(normal[None])[0], normal])
    x = directions @ axes
    ahead = x[:, 2] > MIN_INCIDENCE_COSINE
    if np.count_nonzero(ahead) < 4:
        raise CalibrationError(
            f"pose from rays: {np.count_nonzero(ahead)} of {len(x)} rays meet the "
            "synthetic plane; give four or more",
            code="too-few-rays",
        )
    image = np.full((len(x), 2), np.nan)
    image[ahead] = x[ahead, :2] / x[ahead, 2:]
    return axes, image, ahead


def _metric(G):
    """G ~ [r1 r2 t] (..., 3, 3) at the scale of (4.14): its first columns' mean."""
    size = np.linalg.norm(G[..., :2], axis=-2).mean(axis=-1)
    return G / size[..., None, None]


def _errors(directions, points, G, metric):
    """Errors (m, N) of points under m matrices G ~ [r1 r2 t], with the correct sign."""
    G = _metric(G)
    p = points @ np.swapaxes(G[..., :2], 1, 2) + G[:, None, :, 2]
    # A sample leaves the sign undetermined: most points must be in front.
    along = np.einsum("kni,ni->kn", p, directions)
    behind = np.count_nonzero(along > 0, axis=1) * 2 < p.shape[1]
    return ray_errors(directions, np.where(behind[:, None, None], -p, p), metric)


def _found(directions, points, G, inliers, ahead, metric):
    """(4.12) to (4.14): pose of G ~ [r1 r2 t], with its errors."""
    G = _metric(G)
    along = np.einsum("ni,ni->n", points @ G[:, :2].T + G[:, 2], directions)
    if np.count_nonzero(along[inliers] > 0) * 2 < np.count_nonzero(inliers):
        G = -G
    T = pose(_refusing(nearest_rotation, G[:, :2]), G[:, 2])
    p = (points @ T[:3, :2].T + T[:3, 3])[None]
    errors = ray_errors(directions, p, metric)[0][inliers]
    rms = float(np.sqrt(np.mean(errors**2)))
    return RayPose(T, inliers, rms, int(np.count_nonzero(~ahead)))


def _refusing(estimate, *arguments, **named):
    try:
        return estimate(*arguments, **named)
    except InputError as error:
        raise CalibrationError(f"pose from rays: {error}", code=error.code) from None


def _covariance(normal, equations, cost, sigma):
    """(6, 6), from the final normal matrix (6, 6)."""
    scale = np.sqrt(np.maximum(np.diag(normal), 1e-300))
    values, vectors = np.linalg.eigh(normal / np.outer(scale, scale))
    if not values[0] > 1e-12:
        raise CalibrationError(
            "pose from rays: the points do not determine the pose (collinear or "
            "repeated); give points that span an area",
            code="degenerate-points",
        )
    inverse = (vectors / values) @ vectors.T / np.outer(scale, scale)
    return inverse if sigma is not None else inverse * cost / (equations - 6)
