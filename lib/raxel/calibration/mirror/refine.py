"""Shape of a bent mirror from scene points with known positions (5.2.2, 5.29).

Levenberg-Marquardt minimises the sum of squared ray-point distances in the free
unknowns of the clamp's subspace, which keeps the clamp exactly. If the position of the
clamp is uncertain, its equations are weighted with given standard deviations instead.
With a prior, all terms are in units of standard deviations, those of the residuals from
the noise of the corners.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.calibration.mirror.clamp import (
    TRUNCATION_TOL,
    Clamp,
    FixedLine,
    PriorRows,
    clamped,
    soft_clamp,
)
from raxel.calibration.mirror.observations import ENDS, RayPoints
from raxel.cameras.mirrors.spline import SplineMirrorCamera, depth_rows, sense
from raxel.errors import CalibrationError, InputError
from raxel.geometry.least_squares import descend, gauss_newton
from raxel.geometry.spline_grids import SplineGrid

MAX_N_STEPS, COST_TOL = 50, 1e-7
ROUNDING_SIGMAS = 1e-9  # standard deviations: residuals of an exact fit
# Smallest over largest eigenvalue of the scaled normal matrix: below, undetermined.
MIN_EIGENVALUE_RATIO = 1e-13


class ShapeFit(NamedTuple):
    """Hold the fit of a spline mirror to scene points.

    Attributes
    ----------
    coefficients : ndarray, shape (K,)
        Coefficients of the spline.
    costs : ndarray
        Sum of squares at the start and after each step, in squared standard deviations.
    residuals : ndarray, shape (N, 3)
        Ray-point vectors, mm.
    converged : bool
        Whether the refinement converged.
    sd_mm : float
        Standard deviation assumed for each component of a residual, mm.
    covariance : ndarray, shape (K, K)
        Covariance of the coefficients, from corner noise, grid pose and prior.
    prior_share : float
        Share of all degrees of freedom that the prior determines.
    """

    coefficients: np.ndarray
    costs: np.ndarray
    residuals: np.ndarray
    converged: bool
    sd_mm: float
    covariance: np.ndarray
    prior_share: float


def refine_shape(
    p: NDArray[np.float64],
    points: NDArray[np.float64],
    grid: SplineGrid,
    quantity: str,
    start: NDArray[np.float64],
    *,
    noise: float | NDArray[np.float64],
    clamp: Clamp | FixedLine | None = None,
    prior: PriorRows | None = None,
    weights: ArrayLike | None = None,
    point_motion: NDArray[np.float64] | None = None,
    pose_covariance: NDArray[np.float64] | None = None,
    truncation: float = TRUNCATION_TOL,
) -> ShapeFit:
    """Fit a spline mirror to points seen in its rays.

    Parameters
    ----------
    p : ndarray, shape (N, 2)
        Normalised image coordinates.
    points : ndarray, shape (N, 3)
        Scene points in the frame of the viewing camera, mm.
    grid : SplineGrid
        Grid of the spline.
    quantity : str
        "inverse depth" or "distance"; see `SplineMirrorCamera`.
    start : ndarray, shape (K,)
        Initial coefficients, which are made to keep the clamp.
    noise : float or ndarray, shape (N,)
        Standard deviation of p along each axis, in the unit of p.
    clamp : Clamp, FixedLine or None
        Clamp of the mirror.
    prior : PriorRows or None
        Prior on the bending.
    weights : array_like, shape (N,), or None
        Each multiplies a residual.
    point_motion : ndarray, shape (N, 3, 6), or None
        Change of the points with the grid's pose.
    pose_covariance : ndarray, shape (6, 6), or None
        Covariance of that pose.
    truncation : float
        See `clamped`.

    Returns
    -------
    ShapeFit
        Coefficients with residuals and covariance.

    Raises
    ------
    CalibrationError
        ``open-coefficients``: the data leave coefficients undetermined.
        ``behind-camera``: the start lies in part behind the viewing camera.

    References
    ----------
    Thesis 5.2.2, (5.29).
    """
    rays = RayPoints(p, grid, quantity)
    weights = np.ones(len(p)) if weights is None else np.asarray(weights, float)
    further = [soft_clamp(grid, clamp), prior]
    # Soft equations replace the clamp's subspace.
    space = clamped(grid, clamp if further[0] is None else None, truncation)
    rows, values = stacked([part for part in further if part is not None], grid.size)
    noise = np.broadcast_to(noise, len(p))
    free = space.free(start)
    c = space.coefficients(free)
    if not rays.in_front(c):
        raise CalibrationError(
            "mirror shape: the initial shape is partly behind the camera; give more "
            "features, or check their directions",
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
        iterations=MAX_N_STEPS,
        tolerance=COST_TOL,
        rounding=ROUNDING_SIGMAS**2 * len(p),
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
    """SplineMirrorCamera of an estimated shape.

    Raises CalibrationError where part of the mirror is behind the viewing camera, such
    as in areas without features, where the spline is undetermined.
    """
    try:
        return SplineMirrorCamera.on_grid(viewer, grid, coefficients, quantity)
    except InputError as fault:
        raise CalibrationError(
            f"mirror shape: {fault}; use fewer knots, a smaller deflection, features "
            "up to the mirror's edges, or a prior",
            code="behind-camera",
        ) from fault


def ray_sd(p, grid, quantity, coefficients, covariance):
    """Standard deviation (N,) of scene directions, rad, root mean square of the two
    components perpendicular to the ray, at p (N, 2); NaN outside the knots.

    covariance: (K, K) of the coefficients.
    """
    J = RayPoints(p, grid, quantity).direction_jacobian(coefficients)
    return np.sqrt(np.einsum("nik,kl,nil->n", J, covariance, J) / 2)


def residual_sd(rays, c, points, noise, used=slice(None)):
    """Rms noise of a residual's component, mm, from the noise of p: that of a flat
    mirror, in which rays stay straight. One value for all, so that the cost remains the
    thesis's sum of squared distances.
    """
    S, _ = rays.surface(c)
    path = np.linalg.norm(S, axis=1) + np.linalg.norm(points - S, axis=1)
    return float(np.sqrt(np.mean((path * noise)[used] ** 2)))


def _data_spread(rays, c, points, noise, reach, weights, motion, pose_covariance):
    """(F, F): covariance of half the gradient, from corner noise and grid pose.

    reach: (N, 3, F), Jacobian of the weighted residuals.
    """
    change = rays.image_jacobian(c, points) * (weights * noise)[:, None, None]
    gradient = np.einsum("nif,nij->fnj", reach, change).reshape(reach.shape[2], -1)
    spread = gradient @ gradient.T
    if pose_covariance is not None:
        moved = weights[:, None, None] * (rays.across(c) @ motion)
        common = np.einsum("nif,nij->fj", reach, moved)
        spread = spread + common @ pose_covariance @ common.T
    return spread


def stacked(parts, size):
    """Rows (R, K) and values (R,), divided by their standard deviations."""
    rows = [part.rows / np.reshape(part.sd, (-1, 1)) for part in parts]
    values = [part.values / part.sd for part in parts]
    return np.vstack([np.zeros((0, size)), *rows]), np.concatenate([[], *values])


def _inverse(normal, count, grid):
    scale = np.sqrt(np.maximum(np.diag(normal), 1e-300))
    eigen, vectors = np.linalg.eigh(normal / np.outer(scale, scale))
    if not eigen[0] > MIN_EIGENVALUE_RATIO * eigen[-1]:
        raise CalibrationError(
            f"mirror shape: {count} features leave "
            f"{np.sum(eigen <= MIN_EIGENVALUE_RATIO * eigen[-1])} of {grid.size} "
            "coefficients undetermined; give features in all knot intervals, fewer "
            "knots, or a prior",
            code="open-coefficients",
        )
    return (vectors / eigen) @ vectors.T / np.outer(scale, scale)


# Shape of a mirror from viewing and scene directions, linearly (5.8-5.25). The bisector
# of the two directions is the mirror's normal, and the surface's tangents are
# perpendicular to it: two linear equations for the spline's coefficients from each
# pair. They leave the scale undetermined; known mirror points or a clamp fix it.
# Sources: Swaminathan, Nayar, Grossberg 2003; Halstead et al. 1996,
# doi:10.1145/237170.237272.


# As a fraction of the largest singular value: smaller values are rounding.
RANK_TOL = 1e-10


def reflection_normals(
    viewing: NDArray[np.float64], scene: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the unit normals into the mirror from viewing and scene directions.

    A direction with the opposite sense gives a tangent in place of the normal (E-5.03).

    Parameters
    ----------
    viewing : ndarray, shape (N, 3)
        Directions from the camera to the mirror.
    scene : ndarray, shape (N, 3)
        Directions from the mirror to the scene.

    Returns
    -------
    ndarray, shape (N, 3)
        Unit normals.

    References
    ----------
    Thesis (5.8).

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.calibration import reflection_normals
    >>> viewing, scene = np.array([[0.0, 0.0, 1.0]]), np.array([[1.0, 0.0, 0.0]])
    >>> reflection_normals(viewing, scene).round(4)
    array([[-0.7071,  0.    ,  0.7071]])
    """
    viewing, scene = _unit(viewing), _unit(scene)
    return _unit(viewing - scene)


def orthogonality_rows(
    p: NDArray[np.float64],
    normals: NDArray[np.float64],
    grid: SplineGrid,
    quantity: str,
) -> NDArray[np.float64]:
    """Return rows whose products with the coefficients vanish.

    A residual is S_x . N, mm, for the quantity "distance", and S_z^2 times smaller for
    "inverse depth".

    Parameters
    ----------
    p : ndarray, shape (N, 2)
        Normalised image coordinates.
    normals : ndarray, shape (N, 3)
        Unit normals.
    grid : SplineGrid
        Grid of the spline.
    quantity : str
        "inverse depth" or "distance".

    Returns
    -------
    ndarray, shape (2N, K)
        First the N rows of the derivative by x, then those by y.

    References
    ----------
    Thesis (5.15), (5.16).
    """
    B, B_x, B_y = depth_rows(grid, p, quantity)
    along = sense(quantity) * (np.sum(p * normals[:, :2], axis=1) + normals[:, 2])
    return np.vstack(
        [
            normals[:, :1] * B + along[:, None] * B_x,
            normals[:, 1:2] * B + along[:, None] * B_y,
        ]
    )


def shape_up_to_scale(
    p: NDArray[np.float64],
    normals: NDArray[np.float64],
    grid: SplineGrid,
    quantity: str,
) -> NDArray[np.float64]:
    """Estimate the coefficients up to scale from normals alone.

    The solution is the smallest singular vector of the matrix with columns of one
    length, also where misfit gives it full rank.

    Parameters
    ----------
    p : ndarray, shape (N, 2)
        Normalised image coordinates.
    normals : ndarray, shape (N, 3)
        Unit normals.
    grid : SplineGrid
        Grid of the spline.
    quantity : str
        "inverse depth" or "distance".

    Returns
    -------
    ndarray, shape (K,)
        Coefficients of unit length, all mirror points in front of the camera.

    Raises
    ------
    CalibrationError
        ``open-coefficients``: directions leave more undetermined than the size.
        ``behind-camera``: part of the mirror is behind the camera.

    References
    ----------
    Thesis (5.15), (5.16).
    """
    A = orthogonality_rows(p, normals, grid, quantity)
    scale = _column_lengths(A)
    _, size, Vt = np.linalg.svd(A / scale, full_matrices=len(A) < grid.size)
    rank = np.count_nonzero(size > RANK_TOL * size[0])
    if rank < grid.size - 1:
        raise CalibrationError(
            f"mirror shape: {len(p)} directions leave {grid.size - rank} of "
            f"{grid.size} coefficients undetermined; give more directions in all knot "
            "intervals, or fewer knots",
            code="open-coefficients",
        )
    c = Vt[grid.size - 1] / scale
    values = depth_rows(grid, p, quantity)[0] @ c
    if not (np.all(values > 0) or np.all(values < 0)):
        raise CalibrationError(
            "mirror shape: part of the mirror is behind the camera; check that the "
            "directions belong together",
            code="behind-camera",
        )
    return c * np.sign(values[0]) / np.linalg.norm(c)


def scaled_to_points(coefficients, grid, quantity, points):
    """Coefficients (K,) at the scale at which the mirror fits points (N, 3) best.

    points: of the mirror, frame of the viewing camera, mm, such as intersections of
    viewing and scene rays (5.2.1); those outside the knots do not count.
    """
    points = np.asarray(points, float)
    p = points[:, :2] / points[:, 2:]
    inside = grid.inside(p)
    if not inside.any():
        raise CalibrationError(
            "mirror shape: all mirror points are outside the knots; extend the knots",
            code="outside-knots",
        )
    found = depth_rows(grid, p[inside], quantity)[0] @ coefficients
    depth = found if quantity == "distance" else 1 / found
    # Points on the same viewing ray: compare their depths.
    along = np.sum(p[inside] ** 2, axis=1) + 1
    wanted = points[inside, 2]
    scale = np.sum(along * depth * wanted) / np.sum(along * depth**2)
    return coefficients * scale if quantity == "distance" else coefficients / scale


def shape_with_clamp(
    p: NDArray[np.float64],
    normals: NDArray[np.float64],
    grid: SplineGrid,
    quantity: str,
    clamp: Clamp | FixedLine | None,
    *,
    truncation: float = TRUNCATION_TOL,
    further: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None,
) -> NDArray[np.float64]:
    """Estimate the coefficients from normals and a clamp, by least squares.

    Columns are equilibrated.

    Parameters
    ----------
    p : ndarray, shape (N, 2)
        Normalised image coordinates.
    normals : ndarray, shape (N, 3)
        Unit normals.
    grid : SplineGrid
        Grid of the spline.
    quantity : str
        "inverse depth" or "distance".
    clamp : Clamp, FixedLine or None
        See `clamped`.
    truncation : float
        See `clamped`.
    further : tuple of ndarray, or None
        Rows (R, K) and values (R,) of more equations, such as a prior's, in the unit of
        `orthogonality_rows`.

    Returns
    -------
    ndarray, shape (K,)
        Coefficients.

    Raises
    ------
    CalibrationError
        ``open-coefficients``: coefficients are undetermined.

    References
    ----------
    Thesis (5.22) to (5.25).
    """
    space = clamped(grid, clamp, truncation)
    A = orthogonality_rows(p, normals, grid, quantity)
    values = np.zeros(len(A))
    if further is not None:
        A, values = np.vstack([A, further[0]]), np.append(values, further[1])
    M = A @ space.directions
    scale = _column_lengths(M)
    gap = values - A @ space.particular
    free, _, rank, _ = np.linalg.lstsq(M / scale, gap, rcond=RANK_TOL)
    if rank < M.shape[1]:
        raise CalibrationError(
            f"mirror shape: {len(p)} directions and the clamp leave "
            f"{M.shape[1] - rank} of {grid.size} coefficients undetermined; give "
            "features in all knot intervals, or fewer knots",
            code="open-coefficients",
        )
    return space.coefficients(free / scale)


def _column_lengths(A):
    length = np.linalg.norm(A, axis=0)
    return np.where(length > 0, length, 1.0)


def _unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


# Uncertainty of a shape next to the outermost knots, without ground truth. Two measures
# are used: the uncertainty of rays at the knots from the covariance, and the rotation
# of rays at the ends if the mirror bent there as evenly as a sheet. Residuals show
# neither: beyond the last feature a spline amplifies the misfit of that feature and
# still fits.


# Standard deviations of rays at the knots, degrees: for a warning, and for an error.
WARN_SD_DEG, MAX_SD_DEG = 0.3, 5.0
# Mean rotation of rays at N_EDGE_POINTS points of an end when a prior of PRIOR_MM is
# added, degrees: for a warning, and for an error. Chosen on simulated runs that no
# claim uses, geometries A and B, both noise levels. There each of the 17 ends with a
# mean ray error of 1.5 degrees or more is flagged, and each of the 14 beyond 2 is
# rejected.
WARN_SWING_DEG, MAX_SWING_DEG = 3.0, 5.0
PRIOR_MM, N_EDGE_POINTS = 0.1, 5


def edge_flags(grid, quantity, fit, widening, evenly, swinging_deg):
    """Largest rotation of rays at an end (degrees), and flags (list of text) for
    unreliable parts of a ShapeFit next to knots and ends.

    widening: factor of its covariance by the misfit; evenly: PriorRows of an evenly
    bent mirror; swinging_deg: rotation from which the shape is rejected. Raises
    CalibrationError, naming the position, where the shape is undetermined.
    """
    c, covariance = fit.coefficients, fit.covariance
    flags = uncertain_knots(grid, quantity, c, covariance)
    turns = turns_under_prior(grid, quantity, c, widening * covariance, evenly)
    return max(turns.values(), default=0.0), flags + swinging_ends(turns, swinging_deg)


def uncertain_knots(grid, quantity, coefficients, covariance):
    """Flags (list of text) where rays next to a knot are uncertain.

    Raises CalibrationError where they are undetermined.
    """
    u, v = np.meshgrid(*grid.breaks)
    places = grid.unturned(np.column_stack([u.ravel(), v.ravel()]))
    sd = np.degrees(ray_sd(places, grid, quantity, coefficients, covariance))
    worst = np.argmax(sd)
    text = (
        f"rays next to knot {worst % len(grid.breaks[0])} along u, "
        f"{worst // len(grid.breaks[0])} along v, have a standard deviation of "
        f"{sd[worst]:.2g} "
        "degrees"
    )
    if not sd[worst] < MAX_SD_DEG:
        raise CalibrationError(
            f"mirror shape: {text}; give features there, fewer knots, or a prior",
            code="uncertain-shape",
        )
    return [text] if sd[worst] > WARN_SD_DEG else []


def swinging_ends(turns, limit_deg):
    """Flags (list of text) for outermost knot intervals that bend unlike a sheet.

    turns: of `turns_under_prior`. Raises CalibrationError where an end is unreliable:
    its rays would rotate by limit_deg or more.
    """
    flags = []
    for (axis, _, place), turn in turns.items():
        text = (
            f"the {place} knot interval along {axis}: rays rotate by {turn:.2g} "
            "degrees under a prior of even bending"
        )
        if not turn < limit_deg:
            raise CalibrationError(
                f"mirror shape: {text}; give features up to the edge, fewer knots, or "
                "a prior (or board, camera or clamp moved)",
                code="swinging-end",
            )
        if turn > WARN_SWING_DEG:
            flags.append(f"{text}; few features")
    return flags


def turns_under_prior(grid, quantity, coefficients, covariance, evenly):
    """{one of ENDS: degrees}: rotation of rays at that end when a prior is added.

    covariance: (K, K), widened by the misfit; evenly: as in `edge_flags`. An axis with
    one interval has no such end.
    """
    towards = covariance @ evenly.rows.T
    normal = evenly.rows @ towards + evenly.sd**2 * np.eye(len(evenly.rows))
    gap = evenly.values - evenly.rows @ coefficients
    step = towards @ np.linalg.solve(normal, gap)
    ends = [end for end in ENDS if len(grid.breaks["uv".index(end[0])]) > 2]
    if not ends:
        return {}
    places = grid.unturned(np.concatenate([_along(grid, end) for end in ends]))
    change = RayPoints(places, grid, quantity).direction_jacobian(coefficients) @ step
    angles = np.degrees(np.linalg.norm(change, axis=1)).reshape(
        len(ends), N_EDGE_POINTS
    )
    return dict(zip(ends, angles.mean(axis=1), strict=True))


def _along(grid, end):
    """N_EDGE_POINTS points (n, 2) along one end of the knots' box, rotated."""
    axis, place = "uv".index(end[0]), end[1]
    other = grid.breaks[1 - axis]
    found = np.empty((N_EDGE_POINTS, 2))
    found[:, axis] = grid.breaks[axis][place]
    found[:, 1 - axis] = np.linspace(other[0], other[-1], N_EDGE_POINTS)
    return found
