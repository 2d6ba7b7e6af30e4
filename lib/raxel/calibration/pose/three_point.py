"""Pose of a planar grid from calibrated rays: three points, RANSAC, refinement.

The standard generic method computes the depths of three points along their rays from
the three distances between them on the grid (thesis 2.26), for rays with one common
origin. More points select among the solutions. The pose with the most inliers can then
be refined by minimising the ray-point distances (4.18), the step that section 4.2.2
mentions.

Source of RANSAC: Fischler and Bolles 1981, doi:10.1145/358669.358692.
"""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.errors import CalibrationError
from raxel.geometry.homography import best_hypothesis, checked_generator
from raxel.geometry.least_squares import descend, gauss_newton
from raxel.geometry.poses import pose, rotation_from_vector

# Grunert's solution of the three-point problem, for many triples at once. The depths
# of three points along their rays follow from the three distances between them
# (thesis 2.26, rays with one origin). Eliminating two depths leaves a quartic.
# Source: Haralick, Lee, Ottenberg, Nölle 1994, doi:10.1007/BF02028352.


REAL_ROOT_TOL = 1e-3  # rounding moves a double root off the real axis by its root
DISTANCE_TOL = 1e-7  # relative error of the squared distances of an accepted solution


def three_point_depths(
    directions: np.ndarray, points: np.ndarray
) -> NDArray[np.float64]:
    """Return all real depths of three points on three rays with one common origin.

    A pair of solutions may be behind the origin. Triples with coincident points have no
    solution.

    Parameters
    ----------
    directions
        (M, 3, 3), three unit vectors for each of M triples.
    points
        (M, 3, 2), points on the grid.

    Returns
    -------
    NDArray
        (M, 8, 3), at most eight solutions, in pairs of opposite sign (k and k + 4).
        NaN for those that do not exist.

    References
    ----------
    Thesis (2.26); Haralick, Lee, Ottenberg, Nölle 1994, doi:10.1007/BF02028352.
    """
    cosines = np.stack(
        [
            np.einsum("mi,mi->m", directions[:, j], directions[:, k])
            for j, k in ((1, 2), (0, 2), (0, 1))
        ],
        axis=1,
    )
    gaps = np.stack([points[:, 1] - points[:, 2], points[:, 0] - points[:, 2]], axis=1)
    gaps = np.concatenate([gaps, (points[:, 0] - points[:, 1])[:, None]], axis=1)
    squares = np.sum(gaps**2, axis=2)
    distinct = np.min(squares, axis=1) > 1e-24 * np.max(squares, axis=1)
    depths = np.full((len(points), 4, 3), np.nan)
    if np.any(distinct):
        depths[distinct] = _grunert(cosines[distinct], squares[distinct])
    return np.concatenate([depths, -depths], axis=1)


def _grunert(cosines, squares):
    """Four depth triples (M, 4, 3), first depth positive, NaN where not real.

    cosines, squares: (M, 3), of the angles and lengths opposite points 1, 2, 3.
    """
    ca, cb, cg = cosines.T
    a, b, c = squares.T
    v = _quartic_roots(_grunert_coefficients(cosines, squares))
    real = np.abs(v.imag) <= REAL_ROOT_TOL * (1 + np.abs(v))
    v = np.where(real, v.real, np.nan)
    ca, cb, cg, a, b, c = (x[:, None] for x in (ca, cb, cg, a, b, c))
    r = (a - c) / b
    with np.errstate(divide="ignore", invalid="ignore"):
        below = 2 * (cg - v * ca)
        u = ((r - 1) * v**2 - 2 * r * cb * v + 1 + r) / below
        s_1 = np.sqrt(b / (1 + v**2 - 2 * v * cb))
        # Where the divisor vanishes, v is a double root: its two u differ in sign of
        # the square root of the third distance's equation.
        root = np.sqrt(np.maximum(cg**2 - 1 + c / s_1**2, 0.0))
        sign = np.array([1.0, -1.0, 1.0, -1.0])
        u = np.where(np.abs(below) < 1e-5, cg + sign * root, u)
        depths = np.stack([s_1, u * s_1, v * s_1], axis=2)
    return _polished(depths, cosines, squares)


def _grunert_coefficients(cosines, squares):
    """Coefficients (M, 5) of the quartic in v = s_3 / s_1, highest power first."""
    ca, cb, cg = cosines.T
    a, b, c = squares.T
    r, s = (a - c) / b, (a + c) / b
    return np.stack(
        [
            (r - 1) ** 2 - 4 * c / b * ca**2,
            4 * (r * (1 - r) * cb - (1 - s) * ca * cg + 2 * c / b * ca**2 * cb),
            2
            * (
                r**2
                - 1
                + 2 * r**2 * cb**2
                + 2 * (b - c) / b * ca**2
                - 4 * s * ca * cb * cg
                + 2 * (b - a) / b * cg**2
            ),
            4 * (-r * (1 + r) * cb + 2 * a / b * cg**2 * cb - (1 - s) * ca * cg),
            (1 + r) ** 2 - 4 * a / b * cg**2,
        ],
        axis=1,
    )


def _quartic_roots(coefficients):
    """Roots (M, 4), complex, as eigenvalues of companion matrices; sorted by value.

    A vanishing leading coefficient moves a root to infinity: it is kept finite.
    """
    size = np.max(np.abs(coefficients), axis=1, keepdims=True)
    monic = coefficients / np.where(size > 0, size, 1.0)
    lead = monic[:, :1]
    lead = np.where(np.abs(lead) < 1e-14, 1e-14, lead)
    companion = np.zeros((len(monic), 4, 4))
    companion[:, 0] = -monic[:, 1:] / lead
    companion[:, [1, 2, 3], [0, 1, 2]] = 1.0
    return np.sort_complex(np.linalg.eigvals(companion))


def _polished(depths, cosines, squares):
    """A few damped Newton steps on the distance equations; NaN where they fail.

    depths: (M, 4, 3); the equation opposite point k involves the other two depths.
    """
    present = np.isfinite(depths).all(axis=2)
    s = np.where(present[..., None], depths, 1.0)
    cosine, square = cosines[:, None], squares[:, None]
    first, second = [1, 0, 0], [2, 2, 1]
    equation = [0, 1, 2]
    for _ in range(4):
        d, e = s[..., first], s[..., second]
        gap = d**2 + e**2 - 2 * d * e * cosine - square
        jacobian = np.zeros((*s.shape, 3))
        jacobian[..., equation, first] = 2 * (d - e * cosine)
        jacobian[..., equation, second] = 2 * (e - d * cosine)
        transposed = np.swapaxes(jacobian, 2, 3)
        normal = transposed @ jacobian
        # A double root has a singular Jacobian: a small damping keeps it finite.
        size = np.trace(normal, axis1=2, axis2=3)[..., None, None]
        normal = normal + 1e-12 * (size + 1e-300) * np.eye(3)
        s = s - np.linalg.solve(normal, transposed @ gap[..., None])[..., 0]
    d, e = s[..., first], s[..., second]
    gap = np.abs(d**2 + e**2 - 2 * d * e * cosine - square)
    holds = np.all(gap <= DISTANCE_TOL * np.max(square, axis=2, keepdims=True), axis=2)
    return np.where((present & holds)[..., None], s, np.nan)


N_SCORING_POINTS = 1000  # points that score a trial pose
COST_TOL = 1e-12  # relative decrease of the cost at convergence


class RayPose(NamedTuple):
    """Pose of a grid from the rays of a central camera.

    Attributes
    ----------
    T_camera_grid
        (4, 4), pose of the grid in the camera frame of the rays.
    inliers
        (N,) bool, pairs that agree with the pose.
    rms
        Root mean square error of the inliers, a length (metric "ray-point") or rad
        ("angle").
    behind
        Number of rays that were excluded because a synthetic plane does not meet them.
    """

    T_camera_grid: np.ndarray
    inliers: np.ndarray
    rms: float
    behind: int = 0


def pose_of_triples(
    directions: np.ndarray, points: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return poses from triples whose points are in front, on their rays.

    Parameters
    ----------
    directions
        (M, 3, 3), three unit vectors for each of M triples.
    points
        (M, 3, 2), points on the grid.

    Returns
    -------
    poses : ndarray
        (K, 4, 4), poses `T_camera_grid`.
    triples : ndarray
        (K,) int, index of the triple that gave each pose.
    """
    depths = three_point_depths(directions, points)
    triple, solution = np.nonzero(np.all(depths > 0, axis=2))
    corners = depths[triple, solution][:, :, None] * directions[triple]
    flat = np.concatenate([points, np.zeros((len(points), 3, 1))], axis=2)[triple]
    to_camera, from_grid = _triangle_frames(corners), _triangle_frames(flat)
    sound = np.isfinite(to_camera).all((1, 2)) & np.isfinite(from_grid).all((1, 2))
    rotation = to_camera[sound] @ np.swapaxes(from_grid[sound], 1, 2)
    shift = corners[sound].mean(axis=1)
    shift = shift - np.einsum("kij,kj->ki", rotation, flat[sound].mean(axis=1))
    return pose(rotation, shift), triple[sound]


def pose_three_point_ransac(
    directions: ArrayLike,
    points: ArrayLike,
    rng: np.random.Generator,
    threshold: float,
    *,
    metric: str = "ray-point",
    confidence: float = 0.999,
    most_trials: int = 2000,
) -> RayPose:
    """Return a grid pose in the presence of wrong pairs, by three points and RANSAC.

    The pose is that of the standard method, without refinement. Samples of three are
    drawn until one of inliers alone has occurred with probability `confidence`. The
    pose with the least truncated squared error wins.

    Parameters
    ----------
    directions
        (N, 3), unit vectors of rays with one common origin, N >= 3.
    points
        (N, 2), points on the grid.
    rng
        Random generator of numpy.
    threshold
        Largest error of an inlier: a length for metric "ray-point", rad for "angle".
    metric
        "ray-point" (4.18) or "angle".
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
        No triple gives a pose ("no-pose"), or the arrays do not fit ("shape",
        "too-few-points", "not-finite").

    References
    ----------
    Thesis (2.26); Fischler and Bolles 1981, doi:10.1145/358669.358692.
    """
    checked_generator("pose", rng)
    directions, points = checked_rays(directions, points)
    judges = rng.permutation(len(points))[:N_SCORING_POINTS]

    def propose(count):
        picks = _spread_triples(points, rng, count)
        return pose_of_triples(directions[picks], points[picks])[0]

    best = best_hypothesis(
        propose,
        lambda T: _errors(directions[judges], points[judges], T, metric) ** 2,
        threshold**2,
        sample_size=3,
        confidence=confidence,
        most_trials=most_trials,
        batch=64,
    )
    if best is None:
        raise CalibrationError(
            "pose from rays: no three points give a pose (collinear points, or wrong "
            "rays); check the assignment of points to rays",
            code="no-pose",
        )
    return _judged(directions, points, best, threshold, metric)


def pose_of_spread_triples(
    directions: ArrayLike, points: ArrayLike, count: int = 10
) -> np.ndarray:
    """Return a start pose without random numbers: least median angle (robust).

    All triples of `count` points far from each other are tried.

    Parameters
    ----------
    directions
        (N, 3), unit vectors of rays with one common origin, N >= 3.
    points
        (N, 2), points on the grid.
    count
        Number of points whose triples are tried.

    Returns
    -------
    ndarray
        (4, 4), pose `T_camera_grid`.

    Raises
    ------
    CalibrationError
        No triple gives a pose ("no-pose"), or the arrays do not fit ("shape",
        "too-few-points", "not-finite").
    """
    directions, points = checked_rays(directions, points)
    chosen = _spread_points(points, count)
    picks = chosen[np.array(list(itertools.combinations(range(len(chosen)), 3)))]
    poses, _ = pose_of_triples(directions[picks], points[picks])
    if len(poses) == 0:
        raise CalibrationError(
            "pose from rays: no three points give a pose; check the assignment of "
            "points to rays",
            code="no-pose",
        )
    errors = _errors(directions, points, poses, "angle")
    return poses[np.argmin(np.median(errors, axis=1))]


def refine_pose_ray_point(
    directions: ArrayLike,
    points: ArrayLike,
    T_camera_grid: ArrayLike,
    *,
    origins: ArrayLike | None = None,
    weights: ArrayLike | None = None,
    iterations: int = 50,
) -> tuple[np.ndarray, float]:
    """Return the pose that minimises the sum of squared ray-point distances.

    With weights 1 / distance the error becomes the sine of the angle. Method:
    Levenberg-Marquardt with an analytic Jacobian.

    Parameters
    ----------
    directions
        (N, 3), unit vectors of the rays, N >= 3.
    points
        (N, 2), points on the grid.
    T_camera_grid
        (4, 4), start.
    origins
        (3,) or (N, 3), where the rays begin. None: the origin of the frame.
    weights
        (N,), factor of each distance. None: all 1.
    iterations
        Largest number of steps.

    Returns
    -------
    T_camera_grid : ndarray
        (4, 4), refined pose.
    cost : float
        Sum of the squared weighted distances at the end.

    Raises
    ------
    CalibrationError
        The arrays do not fit ("shape", "too-few-points", "not-finite").

    References
    ----------
    Thesis (4.18).
    """
    directions, points = checked_rays(directions, points)
    origins = np.zeros(3) if origins is None else np.asarray(origins, float)
    weights = np.ones(len(points)) if weights is None else np.asarray(weights, float)
    directions, points = (np.array(a, order="C") for a in (directions, points))
    T = np.array(T_camera_grid, float)
    T, costs, _ = descend(
        lambda T: gauss_newton(
            *_ray_point_parts(directions, points, T, origins, weights)
        ),
        moved_pose,
        T,
        iterations=iterations,
        tolerance=COST_TOL,
        rounding=1e-28 * np.sum(weights**2) * np.max(np.abs(points)) ** 2,
    )
    return T, float(costs[-1])


def pose_from_rays(
    directions: ArrayLike,
    points: ArrayLike,
    rng: np.random.Generator,
    threshold: float,
    *,
    metric: str = "ray-point",
) -> RayPose:
    """Return the refined "standard pose": RANSAC, then refinement on its inliers.

    The refinement minimises ray-point distances. With metric "angle" the refined error
    is the sine of the angle. There are two rounds, as refinement may gain inliers.

    Parameters
    ----------
    directions
        (N, 3), unit vectors of rays with one common origin, N >= 3.
    points
        (N, 2), points on the grid.
    rng
        Random generator of numpy.
    threshold
        Largest error of an inlier: a length for metric "ray-point", rad for "angle".
    metric
        "ray-point" (4.18) or "angle".

    Returns
    -------
    RayPose
        Pose `T_camera_grid` and its inliers.

    Raises
    ------
    CalibrationError
        As `pose_three_point_ransac`.

    References
    ----------
    Thesis (2.26), (4.18) and section 4.2.2.

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.calibration import pose_from_rays
    >>> x, y = np.meshgrid(np.arange(5) * 20.0, np.arange(4) * 20.0)
    >>> points = np.column_stack([x.ravel(), y.ravel()])
    >>> p = np.column_stack([points, np.zeros(20)]) + [-40, -30, 400]
    >>> directions = p / np.linalg.norm(p, axis=1, keepdims=True)
    >>> found = pose_from_rays(directions, points, np.random.default_rng(0), 1.0)
    >>> [round(float(t)) for t in found.T_camera_grid[:3, 3]]
    [-40, -30, 400]
    """
    directions, points = checked_rays(directions, points)
    found = pose_three_point_ransac(directions, points, rng, threshold, metric=metric)
    for _ in range(2):
        right = found.inliers
        if np.count_nonzero(right) < 4:
            break
        weights = None
        if metric == "angle":
            weights = 1.0 / _distances(points[right], found.T_camera_grid[None])[0]
        refined, _ = refine_pose_ray_point(
            directions[right], points[right], found.T_camera_grid, weights=weights
        )
        found = _judged(directions, points, refined, threshold, metric)
    return found


def ray_point_system(
    directions: ArrayLike,
    points: ArrayLike,
    T_camera_grid: np.ndarray,
    origins: np.ndarray,
    weights: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Return residuals and Jacobian of the weighted ray-point distances.

    The residual of a point is its component perpendicular to its ray. The pose moves as
    R exp([w]x), t + R s.

    Parameters
    ----------
    directions
        (N, 3), unit vectors of the rays.
    points
        (N, 2), points on the grid.
    T_camera_grid
        (4, 4), pose of the grid.
    origins
        (3,) or (N, 3), where the rays begin.
    weights
        (N,), factor of each distance.

    Returns
    -------
    residuals : ndarray
        (3N,), in the unit of the grid.
    jacobian : ndarray
        (3N, 6), columns: w (rad), s.

    References
    ----------
    Thesis (4.18).
    """
    directions, points = (np.array(a, float, order="C") for a in (directions, points))
    residuals, jacobian = _ray_point_parts(
        directions, points, T_camera_grid, origins, weights
    )
    return residuals, jacobian()


def _ray_point_parts(directions, points, T, origins, weights):
    """Residuals (3N,), and a function that returns the Jacobian (3N, 6)."""
    p = placed_points(points, T) - origins

    def jacobian():
        # The same product as all of R times the motion of a point in its plane.
        turned = T[:3, :2] @ np.stack([-points[:, 1], points[:, 0]])
        return _jacobian_across(points, turned, T[:3, :3].copy(), directions, weights)

    return _across(p, directions, weights), jacobian


@numba.njit(cache=True)
def _across(p, directions, weights):
    """Components of points p (N, 3) across the rays, times weights (N,): (3N,)."""
    found = np.empty((len(p), 3))
    for n in range(len(p)):
        along = p[n, 0] * directions[n, 0] + p[n, 2] * directions[n, 2]
        along += p[n, 1] * directions[n, 1]
        for i in range(3):
            found[n, i] = (p[n, i] - along * directions[n, i]) * weights[n]
    return found.ravel()


@numba.njit(cache=True)
def _jacobian_across(points, turned, R, directions, weights):
    """Change of `_across` with the pose, (3N, 6); turned (3, N): with the rotation
    about the grid's normal."""
    J, motion = np.empty((len(points), 3, 6)), np.empty((3, 6))
    motion[:, 3:] = R
    for n in range(len(points)):
        for i in range(3):
            motion[i, 0] = R[i, 2] * points[n, 1]
            motion[i, 1] = R[i, 2] * -points[n, 0]
            motion[i, 2] = turned[i, n]
        a, b, c = directions[n]
        for k in range(6):
            along = a * motion[0, k] + b * motion[1, k] + c * motion[2, k]
            for i in range(3):
                errors = motion[i, k] - directions[n, i] * along
                J[n, i, k] = errors * weights[n]
    return J.reshape(-1, 6)


def placed_points(points: np.ndarray, T_camera_grid: np.ndarray) -> np.ndarray:
    """Return grid points (N, 2) in the camera frame, (N, 3).

    Parameters
    ----------
    points
        (N, 2), points on the grid.
    T_camera_grid
        (4, 4), pose of the grid.

    Returns
    -------
    ndarray
        (N, 3), points in the camera frame.
    """
    return points @ T_camera_grid[:3, :2].T + T_camera_grid[:3, 3]


def motion_of_points(points: np.ndarray, T_camera_grid: np.ndarray) -> np.ndarray:
    """Return how grid points move in the camera frame with their pose.

    The pose moves as R exp([w]x), t + R s.

    Parameters
    ----------
    points
        (N, 2), points on the grid.
    T_camera_grid
        (4, 4), pose of the grid.

    Returns
    -------
    ndarray
        (N, 3, 6), columns: w (rad), s.
    """
    motion = np.empty((len(points), 3, 6))
    x, y = points.T[:, :, None]
    R_1, R_2, R_3 = T_camera_grid[:3, :3].T
    motion[:, :, 0], motion[:, :, 1] = y * R_3, -x * R_3
    motion[:, :, 2], motion[:, :, 3:] = x * R_2 - y * R_1, T_camera_grid[:3, :3]
    return motion


def moved_pose(T: np.ndarray, step: np.ndarray) -> np.ndarray:
    """Return the pose (4, 4) after a step (w, s): R exp([w]x), t + R s.

    Parameters
    ----------
    T
        (4, 4), pose.
    step
        (6,), rotation vector w (rad) and shift s.

    Returns
    -------
    ndarray
        (4, 4), moved pose.
    """
    rotation = T[:3, :3]
    return pose(
        rotation @ rotation_from_vector(step[:3]), T[:3, 3] + rotation @ step[3:]
    )


def _triangle_frames(corners):
    """Right-handed frames (K, 3, 3), in columns, of triangles of corners (K, 3, 3)."""
    first = corners[:, 1] - corners[:, 0]
    normal = np.cross(first, corners[:, 2] - corners[:, 0])
    size = np.linalg.norm(first, axis=1, keepdims=True)
    area = np.linalg.norm(normal, axis=1, keepdims=True)
    flat = ~(area > 1e-9 * size**2)
    first = first / np.where(flat, np.nan, size)
    normal = normal / np.where(flat, np.nan, area)
    return np.stack([first, np.cross(normal, first), normal], axis=2)


def _spread_triples(points, rng, count):
    """Index triples (count, 3), the widest half of twice as many random ones."""
    picks = rng.integers(0, len(points), size=(2 * count, 3))
    a, b = points[picks[:, 1]] - points[picks[:, 0]], points[picks[:, 2]]
    b = b - points[picks[:, 0]]
    area = np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    return picks[np.argsort(-area, kind="stable")[:count]]


def _spread_points(points, count):
    """Indices of up to count points, each the farthest from the previous ones."""
    chosen = [int(np.argmax(np.sum((points - points.mean(axis=0)) ** 2, axis=1)))]
    nearest = np.full(len(points), np.inf)
    while len(chosen) < min(count, len(points)):
        gap = np.sum((points - points[chosen[-1]]) ** 2, axis=1)
        nearest = np.minimum(nearest, gap)
        chosen.append(int(np.argmax(nearest)))
    return np.array(chosen)


def _distances(points, poses):
    """Distances (K, N) of grid points from the origin under K poses."""
    p = points @ np.swapaxes(poses[:, :3, :2], 1, 2) + poses[:, None, :3, 3]
    return np.sqrt(np.einsum("kni,kni->kn", p, p))


def _errors(directions, points, poses, metric):
    """Errors (K, N) of grid points under K poses, as `ray_errors`."""
    p = points @ np.swapaxes(poses[:, :3, :2], 1, 2) + poses[:, None, :3, 3]
    return ray_errors(directions, p, metric)


def ray_errors(directions: np.ndarray, p: np.ndarray, metric: str) -> np.ndarray:
    """Return the errors of points that should be in front, on their rays.

    Parameters
    ----------
    directions
        (N, 3), unit vectors of rays from the origin.
    p
        (K, N, 3), points under K poses.
    metric
        "ray-point": distances in the unit of p, infinite for points behind the origin.
        "angle": rad.

    Returns
    -------
    ndarray
        (K, N), errors.

    Raises
    ------
    ValueError
        The metric is neither of the two.

    References
    ----------
    Thesis (4.18).
    """
    if metric not in ("ray-point", "angle"):
        raise ValueError(f"metric: found {metric!r}; give 'ray-point' or 'angle'")
    along, across = _along_and_across(
        np.ascontiguousarray(p), np.ascontiguousarray(directions)
    )
    if metric == "angle":
        return np.arctan2(across, along)
    return np.where(along > 0, across, np.inf)


@numba.njit(cache=True)
def _along_and_across(p, directions):
    """Parts (K, N) of points p (K, N, 3) along unit directions (N, 3) and across."""
    along, across = np.empty(p.shape[:2]), np.empty(p.shape[:2])
    for k in range(p.shape[0]):
        for n in range(p.shape[1]):
            x, y, z = p[k, n]
            a, b, c = directions[n]
            s = x * a + z * c + y * b
            x, y, z = x - s * a, y - s * b, z - s * c
            along[k, n] = s
            across[k, n] = np.sqrt(x * x + y * y + z * z)
    return along, across


def _judged(directions, points, T, threshold, metric):
    errors = _errors(directions, points, T[None], metric)[0]
    inliers = errors < threshold
    rms = np.sqrt(np.mean(errors[inliers] ** 2)) if inliers.any() else np.inf
    return RayPose(T, inliers, float(rms))


def checked_rays(
    directions: ArrayLike, points: ArrayLike
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return rays (N, 3) and points (N, 2) as float arrays, checked.

    Parameters
    ----------
    directions
        (N, 3), unit vectors of the rays.
    points
        (N, 2), points on the grid.

    Returns
    -------
    directions : NDArray
        (N, 3), float64.
    points : NDArray
        (N, 2), float64.

    Raises
    ------
    CalibrationError
        Shapes do not fit ("shape"), there are fewer than three points
        ("too-few-points"), or values are not finite ("not-finite").
    """
    directions, points = np.asarray(directions, float), np.asarray(points, float)
    if directions.shape != (len(points), 3) or points.shape[1:] != (2,):
        raise CalibrationError(
            f"pose from rays: found directions {directions.shape} and points"
            f" {points.shape}; give (N, 3) and (N, 2)",
            code="shape",
        )
    if len(points) < 3:
        raise CalibrationError(
            f"pose from rays: found {len(points)} points with rays; give three or more",
            code="too-few-points",
        )
    if not (np.isfinite(directions).all() and np.isfinite(points).all()):
        raise CalibrationError(
            "pose from rays: rays and points must be finite; remove NaN and infinity",
            code="not-finite",
        )
    return directions, points
