"""Linear stage of the standard generic method: centre and grid poses from rays.

Two variants of thesis section 2.4.1, both exact on exact data:

- ``linear_as_printed``: the algorithm of (2.15)-(2.25), with misprints corrected and
  with its numerics: original lengths, one ratio for the common scale, C_z through the
  product V'_4 V'_5, t_z through a division by C_y.
- ``linear_well_conditioned``: the same constraints in normalised coordinates, with
  least-squares scales and no division by a quantity that may vanish; any number of
  grids.

World = base grid (grid 0), z = 0. Reflection in the base plane is an exact second
solution, which data cannot exclude: ``side`` is the sign of C_z. With grid axes x
right, y down, z into the board in the camera's view, C_z < 0 (``side=-1``).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from raxel.calibration.linear.cgsp import (
    DEGENERACY_TOL,
    centre_of,
    grid_pose,
    margins_of,
)
from raxel.errors import CalibrationError
from raxel.geometry.poses import nearest_rotation, pose

# The bilinear collinearity constraints of generic calibration (thesis 2.13, 2.14). A
# ray through the camera centre C meets the base grid in Q^1 and grid k in Q^k. With
# the base grid as world plane z = 0, the 3x3 minors of (2.13) that hold the columns
# of C, Q^1 and Q^k and the rows yzw or xzw vanish: Q1y (v_a . q) + v_b . q = 0 Q1x
# (w_a . q) + w_b . q = 0 for q = (x, y, 1) on grid k. Table 2.1 lists the nine
# coefficients of each equation in the order (j, k) = xx xy xw yx yy yw wx wy ww of
# the products Q^1_j Q^k_k. Three of the nine are zero by construction; only the other
# six are solved for. Sources: thesis section 2.4.1; P. Sturm and S. Ramalingam, A
# generic concept for camera calibration, ECCV 2004, doi:10.1007/978-3-540-24671-8_1.


# Positions (0-based) of the coefficients that are not zero by construction.
V_TERMS = np.array([3, 4, 5, 6, 7, 8])  # products with Q1y, then with Q1w
W_TERMS = np.array([0, 1, 2, 6, 7, 8])  # products with Q1x, then with Q1w


def bilinear_products(points_1, points_k):
    """Products Q^1_j Q^k_k of (2.14), in the order of Table 2.1.

    points_1, points_k: (N, 2) locations of N rays on the base grid and on grid k.
    Returns (N, 9).
    """
    q_1 = np.column_stack([points_1, np.ones(len(points_1))])
    q_k = np.column_stack([points_k, np.ones(len(points_k))])
    return (q_1[:, :, None] * q_k[:, None, :]).reshape(-1, 9)


def coefficient_vectors(centre, T_base_grid):
    """Coefficients (V, W) of Table 2.1 for one grid, from a known geometry.

    centre: (3,) camera centre in the base frame. T_base_grid: (4, 4) pose of the grid.
    Returns two (9,) vectors at scale one. For the third grid they are called (M, N).
    """
    centre = np.asarray(centre, float)
    columns = np.asarray(T_base_grid, float)[:3][:, [0, 1, 3]]
    shared = columns[2] - [0.0, 0.0, centre[2]]
    v = np.zeros(9)
    v[3:6] = shared
    v[6:9] = centre[2] * columns[1] - centre[1] * columns[2]
    w = np.zeros(9)
    w[0:3] = shared
    w[6:9] = centre[2] * columns[0] - centre[0] * columns[2]
    return v, w


def table_2_1(
    centre: np.ndarray,
    T_base_2: np.ndarray,
    T_base_3: np.ndarray,
    row_3: str = "corrected",
) -> np.ndarray:
    """Return the four coefficient vectors of Table 2.1 for three grids.

    Parameters
    ----------
    centre
        (3,), camera centre in the base frame.
    T_base_2, T_base_3
        (4, 4), poses of grids 2 and 3.
    row_3
        "corrected", or "printed" for the superscripts of t_z as the thesis prints them
        in row i = 3. Each is one too low there: W_3 = -C_z + t_z^1 with t_z^1 = 0, and
        N_3 = -C_z + t_z^2.

    Returns
    -------
    ndarray
        (4, 9), rows V, W, M, N.

    Raises
    ------
    ValueError
        `row_3` is neither of the two.

    References
    ----------
    Thesis, Table 2.1.
    """
    v, w = coefficient_vectors(centre, T_base_2)
    m, n = coefficient_vectors(centre, T_base_3)
    if row_3 == "printed":
        w[2] = -centre[2]
        n[2] = -centre[2] + T_base_2[2, 3]
    elif row_3 != "corrected":
        raise ValueError(f"row_3: found {row_3!r}; give 'corrected' or 'printed'")
    return np.stack([v, w, m, n])


def solve_coefficients(
    points_1: np.ndarray, points_k: np.ndarray, weights: ArrayLike | None = None
) -> tuple[np.ndarray, np.ndarray, float]:
    """Return least-squares null vectors (V, W) and the noise in their entries.

    The two 6-column systems are solved separately, as the thesis does. The scales and
    signs of V and W are therefore unrelated.

    Parameters
    ----------
    points_1, points_k
        (N, 2), points of N >= 6 rays on the base grid and on grid k.
    weights
        (N,), factors of the equations.

    Returns
    -------
    V, W : ndarray
        (9,) with unit norm.
    noise : float
        Larger standard deviation of the two, as a length, estimated from the residuals.

    Raises
    ------
    CalibrationError
        The points do not determine the vectors ("too-few-rays", "degenerate-points").

    References
    ----------
    Thesis (2.14).
    """
    if len(points_1) < 6:
        raise CalibrationError(
            f"linear stage: {len(points_1)} rays see both grids; give at least 6",
            code="too-few-rays",
        )
    products = bilinear_products(points_1, points_k)
    if weights is not None:
        products = products * np.asarray(weights)[:, None]
    v, noise_v = _null_vector(products, V_TERMS)
    w, noise_w = _null_vector(products, W_TERMS)
    return v, w, max(noise_v, noise_w)


def _null_vector(products, terms):
    # R of the QR factorisation has the same right singular vectors, at 6 x 6.
    triangle = np.linalg.qr(products[:, terms], mode="r")
    _, singular, right = np.linalg.svd(triangle)
    if not singular[4] > 1e-13 * singular[0]:
        raise CalibrationError(
            "linear stage: the points common to two grids are collinear; use boards "
            "that share an area of the image",
            code="degenerate-points",
        )
    vector = np.zeros(9)
    vector[terms] = right[5]
    left_over = singular[5] / np.sqrt(max(len(products) - 5, 1))
    return vector, left_over * np.sqrt(np.sum(singular[:5] ** -2))


# (2.23): a divisor below this share of its natural size is 0 within rounding.
ZERO_TOL = 1e-9


class LinearSolution(NamedTuple):
    """Camera centre and grid poses of the linear stage, in the base frame.

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
        indistinguishable from parallel ones. NaN as printed, which has no such test.
    """

    centre: np.ndarray
    T_base_grid: np.ndarray
    degeneracy: float
    margin: float = np.nan


class Similarity(NamedTuple):
    """Normalised coordinates scale * (x - offset) of the points of one grid."""

    offset: np.ndarray
    scale: float

    def apply(self, points):
        return self.scale * (points - self.offset)

    def matrix(self):
        x, y = -self.scale * self.offset
        return np.array([[self.scale, 0.0, x], [0.0, self.scale, y], [0.0, 0.0, 1.0]])


class GridPair(NamedTuple):
    """Coefficients from the rays common to the base and one grid, at one scale.

    shared = v_a = w_a, v_b, w_b: (3,) each, in normalised coordinates. in_front: mean
    sign of v_a . q over the points, which is that of lambda (P_z - C_z). noise: length
    of the standard deviation of the coefficients.
    """

    shared: np.ndarray
    v_b: np.ndarray
    w_b: np.ndarray
    base: Similarity
    grid: Similarity
    in_front: float
    noise: float

    def homography(self):
        """H (3, 3) from the grid to the base, in normalised coordinates."""
        return np.stack([-self.w_b, -self.v_b, self.shared])


def linear_well_conditioned(
    points: np.ndarray,
    seen: np.ndarray | None = None,
    *,
    side: int = -1,
    weights: np.ndarray | None = None,
) -> LinearSolution:
    """Return camera centre and grid poses by linear least squares.

    A grid uses every ray that it shares with the base. No ray needs to meet all grids.

    Parameters
    ----------
    points
        (n, N, 2), n >= 3: where N rays meet every grid. Grid 0 is the base.
    seen
        (n, N) bool. None: where the points are finite.
    side
        Sign of C_z.
    weights
        (n, N), factors of the equations of grids 1 to n-1.

    Returns
    -------
    LinearSolution
        Centre and poses in the base frame, in the unit of the points.

    Raises
    ------
    CalibrationError
        Too few common rays ("no-overlap", "too-few-rays"), too few grids
        ("too-few-grids"), grids parallel to the base or to each other, no real solution
        ("negative-square"), points behind the centre ("behind-centre").

    References
    ----------
    Thesis section 2.4.1.

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.calibration import linear_well_conditioned
    >>> from raxel.geometry import pose, rotation_from_vector
    >>> x, y = np.meshgrid(np.linspace(-0.3, 0.3, 5), np.linspace(-0.2, 0.2, 4))
    >>> rays = np.column_stack([x.ravel(), y.ravel(), np.ones(20)])
    >>> centre, points = np.array([10.0, 20.0, -500.0]), []
    >>> for w in ([0, 0, 0], [0.4, 0.1, 0], [-0.1, 0.5, 0.2]):
    ...     T = pose(rotation_from_vector(np.array(w, float)), np.zeros(3))
    ...     d, c = rays @ T[:3, :3], centre @ T[:3, :3]
    ...     points.append((c - d * (c[2] / d[:, 2:]))[:, :2])
    >>> solution = linear_well_conditioned(points)
    >>> [round(float(c)) for c in solution.centre]
    [10, 20, -500]
    """
    points = np.asarray(points, float)
    finite = np.isfinite(points).all(axis=-1)
    seen = finite if seen is None else np.asarray(seen, bool) & finite
    base = normalising_similarity(points[0][seen[0]])
    pairs = []
    for k in range(1, len(points)):
        both = seen[0] & seen[k]
        grid = normalising_similarity(points[k][both])
        factors = None if weights is None else weights[k][both]
        pairs.append(grid_pair(points[0][both], points[k][both], base, grid, factors))
    return solve_grid_pairs(pairs, side)


def normalising_similarity(points: np.ndarray) -> Similarity:
    """Return the similarity: centroid to the origin, RMS distance to sqrt(2).

    Parameters
    ----------
    points
        (N, 2), points on a grid.

    Returns
    -------
    Similarity
        Offset and scale.

    Raises
    ------
    CalibrationError
        There is no point ("no-overlap"), or all coincide ("degenerate-points").
    """
    if len(points) == 0:
        raise CalibrationError(
            "linear stage: two grids have no common ray; let them overlap in the image",
            code="no-overlap",
        )
    offset = points.mean(axis=0)
    spread = np.sqrt(np.mean(np.sum((points - offset) ** 2, axis=1)))
    if not spread > 0:
        raise CalibrationError(
            "linear stage: all points of a grid coincide; check the points",
            code="degenerate-points",
        )
    return Similarity(offset, np.sqrt(2.0) / spread)


def grid_pair(points_1, points_k, base, grid, weights=None):
    """Coefficients of one grid at a common scale, from (N, 2) points of common rays.

    V_4..V_6 and W_1..W_3 estimate the same vector: the closest rank-one matrix to the
    pair gives it and both scales at once (instead of the single ratio of 2.16).
    """
    q = grid.apply(points_k)
    v, w, noise = solve_coefficients(base.apply(points_1), q, weights)
    left, singular, right = np.linalg.svd(
        np.column_stack([v[3:6], w[0:3]]), full_matrices=False
    )
    shared = left[:, 0]
    scale_v, scale_w = singular[0] * right[0]
    if min(abs(scale_v), abs(scale_w)) < DEGENERACY_TOL:
        raise CalibrationError(
            "linear stage: the plane of a grid contains the camera centre; move the "
            "grid",
            code="behind-centre",
        )
    v_b, w_b = v[6:9] / scale_v, w[6:9] / scale_w
    # Homographies (-w_b, -v_b, v_a) weigh the same: |h_1|^2 + |h_2|^2 = 2.
    size = np.sqrt(np.sum(shared[:2] ** 2 + v_b[:2] ** 2 + w_b[:2] ** 2) / 2.0)
    in_front = np.mean(np.sign(q @ shared[:2] + shared[2]))
    noise /= min(abs(scale_v), abs(scale_w)) * size
    return GridPair(shared / size, v_b / size, w_b / size, base, grid, in_front, noise)


def solve_grid_pairs(pairs, side=-1):
    """LinearSolution from the GridPairs of two or more grids with one common base."""
    if len(pairs) < 2:
        raise CalibrationError(
            f"linear stage: found {len(pairs) + 1} grids; give three or more",
            code="too-few-grids",
        )
    homographies = np.stack([pair.homography() for pair in pairs])
    noise = max(pair.noise for pair in pairs)
    centre, degeneracy, margin = centre_of(homographies, noise, side)
    base = pairs[0].base
    centre = centre / base.scale + np.append(base.offset, 0.0)
    poses = [np.eye(4)]
    for pair in pairs:
        H = np.linalg.solve(pair.base.matrix(), pair.homography()) @ pair.grid.matrix()
        poses.append(grid_pose(H, centre, pair.in_front))
    return LinearSolution(centre, np.stack(poses), degeneracy, margin)


def margins_of_pairs(pairs, picks):
    """`margin` of the solutions of choices of GridPairs: (T,).

    picks: (T, m) indices of pairs. NaN where they determine no centre.
    """
    homographies = np.stack([pair.homography() for pair in pairs])
    noise = np.array([pair.noise for pair in pairs])
    return margins_of(homographies[picks], noise[picks].max(axis=1))


# ---------------------------------------------------------------------- as printed


def linear_as_printed(
    points_1: np.ndarray,
    points_2: np.ndarray,
    points_3: np.ndarray,
    *,
    side: int = -1,
    tz: str = "printed",
) -> LinearSolution:
    """Return camera centre and grid poses as the thesis prints the method.

    The misprints of 2.14 and 2.23-2.25 are corrected; the numerics are kept. Rotations
    are the nearest ones to the computed columns.

    Parameters
    ----------
    points_1, points_2, points_3
        (N, 2), points of the same N rays on three grids.
    side
        Sign of C_z.
    tz
        "printed" divides by C_y (0/0 where the centre is above the x axis of the base
        grid). "corrected" uses t_z = C_z + V'_6 / lambda instead.

    Returns
    -------
    LinearSolution
        Its degeneracy is the fifth over the first singular value of (2.21).

    Raises
    ------
    CalibrationError
        The method cannot compute a value, with the reason ("zero-division",
        "negative-square", "parallel-grids", "too-few-rays", "degenerate-points").
    ValueError
        `tz` is neither of the two.

    References
    ----------
    Thesis (2.15) to (2.25).
    """
    if tz not in ("printed", "corrected"):
        raise ValueError(f"tz: found {tz!r}; give 'printed' or 'corrected'")
    v, w = _ratio_scaled(*solve_coefficients(points_1, points_2)[:2], "V_4/W_1")
    m, n = _ratio_scaled(*solve_coefficients(points_1, points_3)[:2], "M_4/N_1")
    u, degeneracy = solve_unknowns(v, w, m, n)
    c_z = printed_depth(u, v, side)
    centre = np.array([u[0], u[1], c_z])
    poses = [np.eye(4)]
    for vector, part, points in ((v, u[2:8], points_2), (m, u[8:14], points_3)):
        poses.append(printed_pose(vector, part, centre, points, tz))
    return LinearSolution(centre, np.stack(poses), degeneracy)


def _ratio_scaled(v, w, name):
    """(2.15), (2.16): W to the scale of V by the single ratio V_4 / W_1."""
    if (
        abs(w[0]) < ZERO_TOL * np.abs(w[:2]).max()
        or abs(v[3]) < ZERO_TOL * np.abs(v[3:5]).max()
    ):
        raise CalibrationError(
            f"as printed: the ratio {name} is 0/0 (no rotation about y); use "
            "linear_well_conditioned",
            code="zero-division",
        )
    return v, w * (v[3] / w[0])


def _system_2_24(v, w, m, n):
    """A (12, 14) and x (12,) of (2.24), with the entries in their right places."""
    a = np.zeros((12, 14))
    x = np.zeros(12)
    for grid, (first, second) in enumerate(((v, w), (m, n))):
        row, column = 6 * grid, 2 + 6 * grid
        # u holds, per grid, tx, ty, R11, R12, R21, R22 times lambda C_z.
        for i, (entry_y, entry_x) in enumerate(((4, 2), (5, 3), (1, 0))):
            a[row + i, 1] = a[row + 3 + i, 0] = -first[3 + i]
            a[row + i, column + entry_y] = 1.0
            a[row + 3 + i, column + entry_x] = 1.0
        x[row : row + 3] = first[6:9]
        x[row + 3 : row + 6] = second[6:9]
    return a, x


def solve_unknowns(
    v: np.ndarray, w: np.ndarray, m: np.ndarray, n: np.ndarray
) -> tuple[np.ndarray, float]:
    """Return u of (2.24) by the subspaces (2.20) and (2.22), and the ratio of (2.21).

    Parameters
    ----------
    v, w, m, n
        (9,), coefficient vectors of Table 2.1, at a common scale for each grid.

    Returns
    -------
    u : ndarray
        (14,), unknowns of (2.24).
    degeneracy : float
        Fifth over first singular value of (2.21).

    Raises
    ------
    CalibrationError
        The matrix of (2.21) has a rank below 5 ("parallel-grids").

    References
    ----------
    Thesis (2.20) to (2.24).
    """
    a_matrix, x = _system_2_24(v, w, m, n)
    left, singular, right = np.linalg.svd(a_matrix)
    a = right[:12].T @ ((left.T @ x) / singular)
    b, c = right[12], right[13]
    rows, values = [], []
    for grid, vector in enumerate((v, m)):
        i = 4 + 6 * grid
        for p, q in ((i, i + 1), (i, i), (i + 1, i + 1)):
            rows.append(
                [
                    _cross(a, b, p, q),
                    _cross(a, c, p, q),
                    _cross(b, c, p, q),
                    _cross(b, b, p, q) / 2,
                    _cross(c, c, p, q) / 2,
                    vector[3 + p - i] * vector[3 + q - i],
                    -1.0 if p == q and grid == 0 else 0.0,
                    -1.0 if p == q and grid == 1 else 0.0,
                ]
            )
            values.append(-_cross(a, a, p, q) / 2)
    d = np.array(rows)
    # Units of the unknowns only; column l_1 l_2 is 0 within rounding (a theorem).
    units = np.linalg.norm(d, axis=0)
    units[2] = units[3]
    left, singular, right = np.linalg.svd(d / units, full_matrices=False)
    degeneracy = singular[4] / singular[0]
    if not degeneracy > DEGENERACY_TOL:
        raise CalibrationError(
            "as printed: the matrix of (2.21) has rank below 5 (parallel grids); tilt "
            "the grids against the base and each other",
            code="parallel-grids",
        )
    # The null vectors are 0 at l_1 and l_2, so every solution has their values.
    solution = right[:5].T @ ((left.T @ np.array(values))[:5] / singular[:5]) / units
    return a + solution[0] * b + solution[1] * c, float(degeneracy)


def _cross(f, g, p, q):
    """Coefficient of f g in u_p u_q + (the same entries of the second rotation row)."""
    return f[p] * g[q] + f[q] * g[p] + f[p + 2] * g[q + 2] + f[q + 2] * g[p + 2]


def printed_depth(u: np.ndarray, v: np.ndarray, side: int) -> float:
    """Return C_z of (2.23), numerator u_5 u_6 + u_7 u_8.

    Parameters
    ----------
    u
        (14,), unknowns of (2.24).
    v
        (9,), coefficients V'.
    side
        Sign of C_z.

    Returns
    -------
    float
        C_z, in the unit of the points.

    Raises
    ------
    CalibrationError
        The divisor vanishes ("zero-division"), or C_z^2 is negative
        ("negative-square").

    References
    ----------
    Thesis (2.23).
    """
    product = v[3] * v[4]
    numerator = u[4] * u[5] + u[6] * u[7]
    if abs(product) < ZERO_TOL * (v[3] ** 2 + v[4] ** 2):
        raise CalibrationError(
            "as printed: C_z divides by V'_4 V'_5 = 0 (R_31 or R_32 of grid 2 is 0); "
            "use linear_well_conditioned",
            code="zero-division",
        )
    if not -numerator / product > 0:
        raise CalibrationError(
            f"as printed: C_z^2 = {-numerator / product:.3g} is negative; use "
            "linear_well_conditioned",
            code="negative-square",
        )
    return np.sign(side) * np.sqrt(-numerator / product)


def printed_pose(
    vector: np.ndarray, u: np.ndarray, centre: np.ndarray, points: np.ndarray, tz: str
) -> np.ndarray:
    """Return the pose of one grid by (2.23).

    Parameters
    ----------
    vector
        (9,), coefficients V' or M' of the grid.
    u
        (6,), entries tx, ty, R11, R12, R21, R22 of the grid.
    centre
        (3,), camera centre in the base frame.
    points
        (N, 2), points on the grid.
    tz
        "printed" or "corrected", as `linear_as_printed`.

    Returns
    -------
    ndarray
        (4, 4), pose `T_base_grid`.

    Raises
    ------
    CalibrationError
        t_z as printed divides by C_y = 0 ("zero-division").

    References
    ----------
    Thesis (2.23).
    """
    size = np.sqrt(u[2] ** 2 + u[4] ** 2 + (vector[3] * centre[2]) ** 2)
    heights = points @ vector[3:5] + vector[5]
    scale = -np.sign(np.sum(np.sign(heights))) * size / centre[2]
    factor = scale * centre[2]
    t_x = (u[0] + factor * centre[0]) / factor
    t_y = (u[1] + factor * centre[1]) / factor
    if tz == "corrected":
        t_z = centre[2] + vector[5] / scale
    elif abs(centre[1]) < ZERO_TOL * abs(centre[2]):
        raise CalibrationError(
            "as printed: t_z divides by C_y = 0; use the form tz='corrected'",
            code="zero-division",
        )
    else:
        t_z = (factor * t_y - vector[8]) / (scale * centre[1])
    columns = np.array(
        [
            [u[2] / factor, u[3] / factor],
            [u[4] / factor, u[5] / factor],
            [vector[3] / scale, vector[4] / scale],
        ]
    )
    return pose(nearest_rotation(columns), np.array([t_x, t_y, t_z]))
