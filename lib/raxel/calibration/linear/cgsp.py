"""Linear stage of CGSP: camera centre and grid poses from rays (thesis 4.1.2).

CGSP is the thesis's central generic calibration by a synthetic pinhole camera, whose
image plane is the base grid. World = base grid (grid 0), z = 0. Reflection in the base
plane is an exact second solution, which data cannot exclude: ``side`` is the sign of
C_z. With grid axes x right, y down, z into the board in the camera's view, C_z < 0.
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import ArrayLike

from raxel.errors import CalibrationError, InputError
from raxel.geometry.homography import homography_dlt, normalising, robust_start
from raxel.geometry.homography_stream import across, fit_homography, floating, kronecker
from raxel.geometry.poses import nearest_rotation, pose

# Pairs of rays in RANSAC, as in the thesis.
N_RANSAC_PAIRS = 20_000
MIN_N_COMMON_RAYS = 4  # rays common to two grids
N_WEIGHTING_ROUNDS = 2  # a third round changes nothing
# Inlier threshold over the spread of the base's points.
MAX_THRESHOLD_FRACTION = 0.5
MIN_INLIER_FRACTION = 0.5  # of the rays common to two grids


class CgspSolution(NamedTuple):
    """Camera centre and grid poses of CGSP's linear stage, in the base frame.

    Attributes
    ----------
    centre
        (3,), camera centre.
    T_base_grid
        (n, 4, 4), poses of the grids, the first the identity.
    degeneracy
        Third over first singular value of the system for the centre. It tends to 0 as
        grids become parallel. Below about 0.03 the centre is unreliable.
    margin
        Third singular value over the noise of the coefficients. Below 5 the grids are
        indistinguishable from parallel ones.
    homographies
        (n, 3, 3), from each grid to the base, the first the identity.
    inliers
        (n, N) bool, rays that the homography of a grid was fitted to. For the base,
        those of any.
    """

    centre: np.ndarray
    T_base_grid: np.ndarray
    degeneracy: float
    margin: float
    homographies: np.ndarray
    inliers: np.ndarray


def linear_cgsp(
    points: np.ndarray,
    seen: np.ndarray | None = None,
    *,
    side: int = -1,
    pinhole: str = "sturm-maybank",
    robust: str | float | None = None,
    rng: np.random.Generator | None = None,
    weights: np.ndarray | str | None = None,
    subset: int = N_RANSAC_PAIRS,
) -> CgspSolution:
    """Return camera centre and grid poses by CGSP's linear stage.

    A grid uses every ray that it shares with the base. No ray needs to meet all grids.
    Points in single precision are not copied. Memory: about 20 bytes per ray in
    addition to the points, with weights 30.

    Parameters
    ----------
    points
        (n, N, 2), n >= 3: where N rays meet every grid, mm. Grid 0 is the base.
    seen
        (n, N) bool. None: where the points are finite.
    side
        Sign of C_z.
    pinhole
        A name of PINHOLE_METHODS.
    robust
        None fits all points. "ransac" rejects pairs that do not agree with the
        homography of their grid, by the noise of the data. A number is the standard
        deviation of this noise (mm, on the base grid, per axis).
    rng
        Random generator of numpy, required with `robust`.
    weights
        (n, N), factors of the equations of grids 1 to n-1. "image noise": two more
        rounds with those of `image_noise_weights`.
    subset
        Number of random rays among which `robust` searches. All others are judged by
        what these agree on.

    Returns
    -------
    CgspSolution
        Centre and poses in the base frame, mm.

    Raises
    ------
    CalibrationError
        Fewer than three grids ("too-few-grids"), fewer than four common rays
        ("no-overlap"), more than half outliers ("too-many-outliers"), grids parallel to
        the base or to each other, no real solution ("negative-square"), points behind
        the centre ("behind-centre"). The message names the grid.
    ValueError
        An argument does not fit.

    References
    ----------
    Thesis (4.2) to (4.14).
    """
    points = floating(points)
    if len(points) < 3:
        raise CalibrationError(
            f"linear stage: found {len(points)} grids; give three or more",
            code="too-few-grids",
        )
    if robust is not None and rng is None:
        raise ValueError("robust: rng is missing; give a numpy Generator")
    finite = np.isfinite(points[..., 0]) & np.isfinite(points[..., 1])
    seen = finite if seen is None else np.asarray(seen, bool) & finite
    by_noise = isinstance(weights, str)
    if by_noise and weights != "image noise":
        raise ValueError(f"weights: found {weights!r}; give an array or 'image noise'")
    fits = []
    for k in range(1, len(points)):
        factors = None if by_noise or weights is None else weights[k]
        fits.append(homography_to_base(points, seen, k, robust, rng, factors, subset))
    return solve_homographies(
        points,
        fits,
        side=side,
        pinhole=pinhole,
        rounds=N_WEIGHTING_ROUNDS if by_noise else 0,
    )


def homography_to_base(
    points, seen, k, robust=None, rng=None, weights=None, subset=N_RANSAC_PAIRS
):
    """HomographyFit (4.2) from grid k to the base; weights (N,), else as `linear_cgsp`.

    Raises CalibrationError for too few common rays and more than half outliers.
    """
    both = seen[0] & seen[k]
    common = np.flatnonzero(both)
    if len(common) < MIN_N_COMMON_RAYS:
        raise CalibrationError(
            f"linear stage: grid {k} and the base (grid 0) share {len(common)} rays; "
            f"give at least {MIN_N_COMMON_RAYS} (grids must overlap in the image)",
            code="no-overlap",
        )
    try:
        if robust is None:
            few = common[:: max(1, len(common) // subset)]
            start, limit = homography_dlt(points[k, few], points[0, few]), np.inf
        else:
            few = common
            if len(common) > subset:
                few = np.sort(rng.choice(common, subset, replace=False))
            sigma = None if robust == "ransac" else robust
            start, limit = robust_start(points[k, few], points[0, few], rng, sigma)
            _check_threshold(limit, points[0, few], k)
        fit = fit_homography(
            points[k], points[0], start, use=both, limit=limit, weights=weights
        )
    except InputError as error:
        raise CalibrationError(
            f"linear stage: grid {k} and the base: {error}", code=error.code
        ) from None
    if fit.count < MIN_INLIER_FRACTION * len(common):
        raise CalibrationError(
            f"linear stage: grid {k} and the base: {len(common) - fit.count} of "
            f"{len(common)} common rays are outliers of the best homography; check the "
            "matches (or the camera is not central)",
            code="too-many-outliers",
        )
    return fit


def _check_threshold(limit, base, k):
    """Reject a threshold as large as the spread of unrelated points."""
    spread = np.sqrt(np.mean((base - np.median(base, axis=0)) ** 2))
    if limit > MAX_THRESHOLD_FRACTION * spread:
        raise CalibrationError(
            f"linear stage: grid {k} and the base agree with no homography (threshold "
            f"{limit:.3g}, spread of points {spread:.3g}); check the matches",
            code="too-many-outliers",
        )


def solve_homographies(points, fits, *, side=-1, pinhole="sturm-maybank", rounds=0):
    """CgspSolution from the HomographyFits of grids 1 to n-1, by (4.6) to (4.14).

    rounds: number of refits of the homographies to the same rays, with the weights of
    `image_noise_weights`; other arguments and errors as `linear_cgsp`.
    """
    solution = _solution(points, fits, side, pinhole)
    for _ in range(rounds):
        fits = [
            fit_homography(
                points[k],
                points[0],
                fit.H,
                use=fit.inliers,
                weights=image_noise_weights(
                    points[0], points[k], fit.H, solution.centre
                ),
            )
            for k, fit in enumerate(fits, start=1)
        ]
        solution = _solution(points, fits, side, pinhole)
    return solution


def image_noise_weights(
    base: np.ndarray, points: np.ndarray, H: np.ndarray, centre: ArrayLike
) -> np.ndarray:
    """Return weights that make the equations of the DLT equally uncertain.

    Only the direction of a ray has an error, the same for every ray. The error moves
    its point on the base by its range s. Away from the plane's normal, the factor is
    s sqrt(1 + m^2), m the tangent of the angle of incidence. The equation contains this
    times (H q)_z.

    Parameters
    ----------
    base, points
        (N, 2), where rays meet the base and another grid.
    H
        (3, 3), homography from the grid to the base.
    centre
        (3,), camera centre in the base frame.

    Returns
    -------
    ndarray
        (N,), weights.
    """
    return _weigh(base, points, np.ascontiguousarray(H[2]), np.asarray(centre, float))


@numba.njit(cache=True)
def _weigh(base, points, row, centre):
    weights = np.empty(len(base))
    for i in range(len(base)):
        x = (base[i, 0] - centre[0]) / centre[2]
        y = (base[i, 1] - centre[1]) / centre[2]
        square = x * x + y * y
        height = row[0] * points[i, 0] + row[1] * points[i, 1] + row[2]
        reach = height * centre[2]
        weights[i] = 1 / np.sqrt(reach * reach * (1 + square) * (1 + square / 2))
    return weights


def _solution(points, fits, side, pinhole):
    base = normalising(_some(points[0], np.any([f.inliers for f in fits], axis=0)))
    homographies, noise = [], []
    for k, fit in enumerate(fits, start=1):
        H, sd = _normalised(fit, base, normalising(_some(points[k], fit.inliers)))
        homographies.append(H)
        noise.append(sd)
    homographies = np.stack(homographies)
    centre, degeneracy, margin = centre_of(homographies, max(noise), side, pinhole)
    centre = (centre - [*base[:2, 2], 0.0]) / base[0, 0]
    poses = [np.eye(4)]
    for k, fit in enumerate(fits, start=1):
        poses.append(grid_pose(fit.H, centre, _in_front(fit, points[k])))
    inliers = np.stack([fit.inliers for fit in fits])
    return CgspSolution(
        centre,
        np.stack(poses),
        degeneracy,
        margin,
        np.stack([np.eye(3)] + [fit.H for fit in fits]),
        np.concatenate([inliers.any(axis=0)[None], inliers]),
    )


def _some(points, use):
    """Points (M, 2) of the rays in use: all, or an even subset of many."""
    picked = np.flatnonzero(use)
    return points[picked[:: max(1, len(picked) // N_RANSAC_PAIRS)]]


def _normalised(fit, base, grid):
    """H (3, 3) between normalised frames, scaled, and the noise of its entries."""
    back = np.linalg.inv(grid)
    H = base @ fit.H @ back
    change = across(H.ravel()) @ kronecker(base, back.T)
    size = np.sqrt(np.sum(H[:, :2] ** 2) / 2)
    noise = np.sqrt(np.trace(change @ fit.covariance @ change.T)) / size
    return scaled(H), noise


def _in_front(fit, points):
    """Mean sign of (H q)_z over the points (N, 2) of a grid."""
    picked = _some(points, fit.inliers)
    return float(np.mean(np.sign(picked @ fit.H[2, :2] + fit.H[2, 2])))


# Pinhole camera whose image plane is the base grid: its centre and grid poses. The rays
# of any central camera meet the base grid in an image without distortion, and the
# homographies from the other grids to this image suffice for a plane-based pinhole
# calibration (thesis 4.1.1). ``PINHOLE_METHODS`` contains two such methods: name ->
# function(homographies) -> (x, y, square of C_z). - ``sturm-maybank``: two linear
# equations for the image of the absolute conic per homography, (4.6) to (4.10). P.
# Sturm and S. Maybank, CVPR 1999, doi:10.1109/CVPR.1999.786974. - ``circle``: each
# homography restricts the centre to a circle; the result is the point nearest to all
# circles, weighted by the tilt of their grids. From the centre, the vanishing points of
# any two perpendicular directions are at a right angle. The thesis also used Wang and
# Liu (2006), whose method it does not describe; the circle is another way to use the
# vanishing line. Homographies map (x, y, 1) on a grid to the base plane, both in any
# unit.


# Singular-value ratio below which a system is degenerate, also without noise.
DEGENERACY_TOL = 1e-9
# Third singular value over the noise of the coefficients.
MIN_NOISE_RATIO = 5.0
# Fraction of a grid's points behind the centre.
MAX_BEHIND_FRACTION = 0.25


def scaled(H):
    """Homographies (..., 3, 3) with |h_1|^2 + |h_2|^2 = 2, for equal weights."""
    size = np.sqrt(np.sum(H[..., :2] ** 2, axis=(-2, -1)) / 2)
    return H / size[..., None, None]


def conic_rows(H: np.ndarray) -> np.ndarray:
    """Return rows of (4.8) and (4.9) for (w_11, w_13, w_23, w_33) of (4.6).

    (4.9) is doubled: a rotation of the grid in its own plane then only rotates the pair
    of rows.

    Parameters
    ----------
    H
        (..., 3, 3), homographies.

    Returns
    -------
    ndarray
        (..., 2, 4), rows.

    References
    ----------
    Thesis (4.6) to (4.9).
    """

    def row(g, h):
        return np.stack(
            [
                g[0] * h[0] + g[1] * h[1],
                g[0] * h[2] + g[2] * h[0],
                g[1] * h[2] + g[2] * h[1],
                g[2] * h[2],
            ],
            axis=-1,
        )

    first, second = (np.moveaxis(H[..., k], -1, 0) for k in (0, 1))
    rows = row(first, first) - row(second, second), 2 * row(first, second)
    return np.stack(rows, axis=-2)


def conic_system(homographies: np.ndarray) -> np.ndarray:
    """Return the matrix of (4.8) and (4.9) of homographies, scaled.

    Parameters
    ----------
    homographies
        (..., n - 1, 3, 3).

    Returns
    -------
    ndarray
        (..., 2 (n - 1), 4).

    References
    ----------
    Thesis (4.8), (4.9).
    """
    rows = conic_rows(scaled(homographies))
    return rows.reshape(*rows.shape[:-3], -1, 4)


def sturm_maybank(
    homographies: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return x, y and the square of z of the centre.

    Parameters
    ----------
    homographies
        (..., n - 1, 3, 3), at least two, coordinates of about unit size.

    Returns
    -------
    x, y, square : ndarray
        (...), coordinates of the centre and square of C_z.

    References
    ----------
    Thesis (4.6) to (4.10); P. Sturm and S. Maybank, CVPR 1999,
    doi:10.1109/CVPR.1999.786974.
    """
    null = np.linalg.svd(conic_system(homographies))[2][..., 3, :]
    w_11, w_13, w_23, w_33 = np.moveaxis(null, -1, 0)
    x, y = -w_13 / w_11, -w_23 / w_11
    return x, y, w_33 / w_11 - x**2 - y**2


def circle_of(H: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """Return the circle on which one homography puts the centre.

    The circle is perpendicular to the base plane and to the axis, the direction of the
    grid's vanishing line.

    Parameters
    ----------
    H
        (3, 3), homography from the grid to the base.

    Returns
    -------
    v_0 : ndarray
        (2,), centre of the circle, in the base plane.
    axis : ndarray
        (2,), unit vector.
    radius : float
        Radius, in the unit of the base.
    """
    d = H[2, :2]
    length = np.hypot(*d)
    along = (H[:2, 1] * d[0] - H[:2, 0] * d[1]) / length
    v_0 = H[:2, :2] @ d / length**2
    radius = np.hypot(*along) / length
    return v_0, along / np.hypot(*along), radius


def circle(homographies: np.ndarray) -> tuple[float, float, float]:
    """Return x, y and the square of z of the nearest point to the circles.

    Being on a circle is linear in x, y and S = |C|^2: in the circle's plane, and
    S - 2 v_0 . (x, y) = radius^2 - v_0^2. Either equation is scaled to a distance. It
    is weighted by the squared length of (h_31, h_32), the tilt. The less a grid is
    tilted, the less certain is its circle. A grid parallel to the base has none.

    Parameters
    ----------
    homographies
        (n - 1, 3, 3), as `sturm_maybank`, `scaled`.

    Returns
    -------
    x, y, square : float
        Coordinates of the centre and square of C_z.
    """
    rows, values = [], []
    for H in homographies:
        weight = H[2, 0] ** 2 + H[2, 1] ** 2
        if weight == 0:
            continue
        v_0, axis, radius = circle_of(H)
        rows.append(weight * np.array([*axis, 0.0]))
        values.append(weight * (axis @ v_0))
        share = weight / (2 * radius)
        rows.append(share * np.array([*(-2 * v_0), 1.0]))
        values.append(share * (radius**2 - v_0 @ v_0))
    x, y, square = np.linalg.lstsq(np.array(rows), np.array(values), rcond=None)[0]
    return x, y, square - x**2 - y**2


PINHOLE_METHODS = {"sturm-maybank": sturm_maybank, "circle": circle}


def centre_of(homographies, noise, side=-1, pinhole="sturm-maybank"):
    """The centre (3,) in the base frame, its degeneracy and its margin.

    homographies: (n - 1, 3, 3), two or more, `scaled`, coordinates of about unit size;
    noise: standard deviation of their entries, as a length; side: sign of C_z; pinhole:
    a name of PINHOLE_METHODS. degeneracy: third over first singular value of (4.8) and
    (4.9) for all grids; margin: the third over the noise.

    Raises CalibrationError for grids that are parallel, to the base or to each other,
    within the noise, and where C_z is not real; ValueError for an unknown side or
    method.
    """
    if pinhole not in PINHOLE_METHODS:
        raise ValueError(
            f"pinhole: found {pinhole!r}; give one of {[*PINHOLE_METHODS]}"
        )
    if side not in (-1, 1):
        raise ValueError(f"side: found {side!r}; give -1 or 1, the sign of C_z")
    degeneracy, margin = _determination(homographies, noise)
    if degeneracy < DEGENERACY_TOL or margin < MIN_NOISE_RATIO:
        raise CalibrationError(
            f"linear stage: {_parallel(homographies, noise)} (singular-value ratio "
            f"{degeneracy:.1e}); tilt the grids differently"
        )
    x, y, square = PINHOLE_METHODS[pinhole](homographies)
    if not square > 0:
        raise CalibrationError(
            "linear stage: C_z^2 is negative (noisy points, or a non-central camera); "
            "tilt the grids more",
            code="negative-square",
        )
    centre = np.array([x, y, side * np.sqrt(square)])
    return centre, float(degeneracy), float(margin)


def margins_of(homographies, noise):
    """Margins (...) of `centre_of`, NaN where it rejects the grids.

    homographies: (..., n - 1, 3, 3), as there; noise: (...). Sturm and Maybank's method
    determines whether C_z is real.
    """
    degeneracy, margin = _determination(homographies, noise)
    square = sturm_maybank(homographies)[2]
    rejected = (
        (degeneracy < DEGENERACY_TOL) | (margin < MIN_NOISE_RATIO) | ~(square > 0)
    )
    return np.where(rejected, np.nan, margin)


def _determination(homographies, noise):
    """Degeneracy and margin, as in `centre_of`."""
    singular = np.linalg.svd(conic_system(homographies), compute_uv=False)
    # Exact points leave rounding only.
    margin = singular[..., 2] / np.maximum(noise, 1e-15)
    return singular[..., 2] / singular[..., 0], margin


def _parallel(homographies, noise):
    """Description of the grids that are parallel within the noise."""
    tilts = np.hypot(homographies[:, 2, 0], homographies[:, 2, 1])
    floor = MIN_NOISE_RATIO * max(noise, DEGENERACY_TOL)
    flat = [str(k) for k, tilt in enumerate(tilts, start=1) if tilt < floor]
    if flat:
        return f"parallel to the base within the noise: grid {', '.join(flat)}"
    return "the grids are parallel to each other within the noise"


def grid_pose(H: np.ndarray, centre: np.ndarray, in_front: float) -> np.ndarray:
    """Return the pose of a grid by (4.11) to (4.14), with the signs of the errata.

    Parameters
    ----------
    H
        (3, 3), homography from the grid to the base.
    centre
        (3,), camera centre in the base frame.
    in_front
        Mean sign of (H q)_z over the points q of the grid. These are on the side of the
        centre where the base plane is.

    Returns
    -------
    ndarray
        (4, 4), pose `T_base_grid`.

    Raises
    ------
    CalibrationError
        Points are on both sides of the centre ("behind-centre").

    References
    ----------
    Thesis (4.11) to (4.14).
    """
    if abs(in_front) < 1 - 2 * MAX_BEHIND_FRACTION:
        raise CalibrationError(
            "linear stage: points of a grid are on both sides of the camera centre; "
            "check the matches",
            code="behind-centre",
        )
    x, y, z = centre
    M = np.array([[-z, 0.0, x], [0.0, -z, y], [0.0, 0.0, 1.0]])
    G = np.linalg.solve(M, H)
    sign = -np.sign(z) * np.sign(in_front)
    s = sign / np.mean(np.linalg.norm(G[:, :2], axis=0))
    return pose(nearest_rotation(s * G[:, :2]), s * G[:, 2] + centre)
