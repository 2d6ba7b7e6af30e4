"""Shape of a bent mirror from scene points whose places are known (5.2.2, 5.29).

The sum of squared ray-point distances falls by Levenberg-Marquardt steps in the free
unknowns of the clamp's subspace, so that the clamp stays exactly; where its place is
uncertain, its equations count with stated weights instead. A prior may be added: then
squares are told in standard deviations, of the residuals by the noise of the corners.
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
ROUNDING_SIGMAS = 1e-9  # standard deviations: residuals of points that fit exactly
# Of the normal matrix's largest eigenvalue, after scaling: below it is nothing.
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
    if not eigen[0] > MIN_EIGENVALUE_RATIO * eigen[-1]:
        raise CalibrationError(
            f"mirror shape: {count} features leave {np.sum(eigen <= MIN_EIGENVALUE_RATIO * eigen[-1])}"
            f" of {grid.size} coefficients open; give features in all knot intervals, "
            "fewer knots, or a prior",
            code="open-coefficients",
        )
    return (vectors / eigen) @ vectors.T / np.outer(scale, scale)


# Shape of a mirror from viewing and scene directions, linearly (5.8-5.25). The
# bisector of the two directions is the mirror's normal, and the surface's tangents
# are at right angles to it: two linear equations for the spline's coefficients from
# each pair. They leave its size open, which known mirror points or a clamp settle.
# Sources: Swaminathan, Nayar, Grossberg 2003; Halstead et al. 1996,
# doi:10.1145/237170.237272.


# Of the largest singular value: what is below says nothing but rounding.
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
    *,
    equilibrate: bool = True,
) -> NDArray[np.float64]:
    """Estimate the coefficients up to scale from normals alone.

    The solution is the smallest singular vector, also where misfit gives the matrix
    full rank.

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
    equilibrate : bool
        Whether columns are brought to one length first.

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
    scale = _column_lengths(A) if equilibrate else np.ones(grid.size)
    _, size, Vt = np.linalg.svd(A / scale, full_matrices=len(A) < grid.size)
    rank = np.count_nonzero(size > RANK_TOL * size[0])
    if rank < grid.size - 1:
        raise CalibrationError(
            f"mirror shape: {len(p)} directions leave {grid.size - rank} of {grid.size}"
            " coefficients open; give more of them, spread over all knot intervals, or"
            " fewer knots",
            code="open-coefficients",
        )
    c = Vt[grid.size - 1] / scale
    values = depth_rows(grid, p, quantity)[0] @ c
    if not (np.all(values > 0) or np.all(values < 0)):
        raise CalibrationError(
            "mirror shape: part of the mirror comes out behind the camera; the"
            " directions do not belong together",
            code="behind-camera",
        )
    return c * np.sign(values[0]) / np.linalg.norm(c)


def scaled_to_points(coefficients, grid, quantity, points):
    """The coefficients (K,) at the scale at which the mirror meets points (N, 3) best.

    points: of the mirror, viewer's frame, mm, such as the places where viewing and
    scene rays meet (5.2.1); those outside the knots do not count.
    """
    points = np.asarray(points, float)
    p = points[:, :2] / points[:, 2:]
    inside = grid.inside(p)
    if not inside.any():
        raise CalibrationError(
            "mirror shape: no point of the mirror lies in its knots",
            code="outside-knots",
        )
    found = depth_rows(grid, p[inside], quantity)[0] @ coefficients
    depth = found if quantity == "distance" else 1 / found
    # Points on the same viewing ray: their depths compare as they do.
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
            f"{M.shape[1] - rank} of {grid.size} coefficients open; give features in "
            "all knot intervals, or fewer knots",
            code="open-coefficients",
        )
    return space.coefficients(free / scale)


def _column_lengths(A):
    length = np.linalg.norm(A, axis=0)
    return np.where(length > 0, length, 1.0)


def _unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


# How much of a shape next to the outermost knots is a guess. Two questions that need
# no truth. How uncertain are rays at the knots, by the covariance? And how would they
# turn at the ends if the mirror bent there as evenly as a sheet does? Residuals
# answer neither: beyond the last feature a spline goes on as the misfit of that
# feature says, multiplied, and fits all the same.


# Standard deviations of rays at the knots, degrees: flagged, and refused.
WARN_SD_DEG, MAX_SD_DEG = 0.3, 5.0
# By how much rays at an end turn where a prior of PRIOR_MM is put upon the shape, mean
# over N_EDGE_POINTS places, degrees: flagged, and refused. Chosen on seeds that judge nothing,
# geometries A and B on both benches. There each of the 17 ends whose rays were 1.5
# degrees off or more, on average, is flagged, and each of the 14 beyond 2 refused.
WARN_SWING_DEG, MAX_SWING_DEG = 3.0, 5.0
PRIOR_MM, N_EDGE_POINTS = 0.1, 5


def edge_flags(grid, quantity, fit, widening, evenly, swinging_deg):
    """By how much rays at an end would turn at most (degrees), and flags (list of text)
    for what is a guess of a ShapeFit, next to knots and ends.

    widening: of its covariance, by the misfit; evenly: PriorRows of a mirror that bends
    so; swinging_deg: the turn from which on the shape is rejected. Raises
    CalibrationError, naming the place, where it is anything.
    """
    c, covariance = fit.coefficients, fit.covariance
    flags = uncertain_knots(grid, quantity, c, covariance)
    turns = turns_if_even(grid, quantity, c, widening * covariance, evenly)
    return max(turns.values(), default=0.0), flags + swinging_ends(turns, swinging_deg)


def uncertain_knots(grid, quantity, coefficients, covariance):
    """Flags (list of text) where rays next to a knot are uncertain.

    Raises CalibrationError where they are anything.
    """
    u, v = np.meshgrid(*grid.breaks)
    places = grid.unturned(np.column_stack([u.ravel(), v.ravel()]))
    sd = np.degrees(ray_sd(places, grid, quantity, coefficients, covariance))
    worst = np.argmax(sd)
    text = (
        f"rays next to knot {worst % len(grid.breaks[0])} along u, "
        f"{worst // len(grid.breaks[0])} along v, are uncertain by {sd[worst]:.2g} "
        "degrees"
    )
    if not sd[worst] < MAX_SD_DEG:
        raise CalibrationError(
            f"mirror shape: {text}; give features there, fewer knots, or a prior",
            code="uncertain-shape",
        )
    return [text] if sd[worst] > WARN_SD_DEG else []


def swinging_ends(turns, limit_deg):
    """Flags (list of text) for outermost knot intervals that bend as no sheet does.

    turns: of `turns_if_even`. Raises CalibrationError where an end is a guess: its rays
    would turn by limit_deg or more.
    """
    flags = []
    for (axis, _, place), turn in turns.items():
        text = (
            f"the {place} knot interval along {axis}: rays would turn by {turn:.2g} "
            "degrees if the mirror bent there as evenly as a sheet"
        )
        if not turn < limit_deg:
            raise CalibrationError(
                f"mirror shape: {text}; give features that reach the edge, fewer "
                "knots, or a prior, and see that board, viewer and clamp stayed",
                code="swinging-end",
            )
        if turn > WARN_SWING_DEG:
            flags.append(f"{text}; few features")
    return flags


def turns_if_even(grid, quantity, coefficients, covariance, evenly):
    """{one of ENDS: degrees} by which rays at that end turn if a prior joins the shape.

    covariance: (K, K), widened by the misfit; evenly: as `edge_flags` has it. Along an
    axis of one interval there is no such end.
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
    """N_EDGE_POINTS places (n, 2) of the knots' box, turned, along one of its ends."""
    axis, place = "uv".index(end[0]), end[1]
    other = grid.breaks[1 - axis]
    found = np.empty((N_EDGE_POINTS, 2))
    found[:, axis] = grid.breaks[axis][place]
    found[:, 1 - axis] = np.linspace(other[0], other[-1], N_EDGE_POINTS)
    return found
