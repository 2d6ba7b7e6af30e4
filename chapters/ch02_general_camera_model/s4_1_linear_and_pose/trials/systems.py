"""The two linear systems of section 2.4.1, written out row by row.

The library solves the linear stage differently. Here the matrices A (2.24)
and D (2.25) are built from the corrected rows, to test the stated ranks.
Unknowns and coefficients are counted from one, as in print; an array holds
unknown i at index i - 1.
"""

import numpy as np

from chapters.shared.three_planes import measure
from raxel.calibration import solve_coefficients
from raxel.geometry import inverse_pose

UNKNOWNS_U = 14
UNKNOWNS_V = ("l1", "l2", "l1 l2", "l1^2", "l2^2", "C_z^2", "s2", "s3")
# Indices of v that determine a solution: l1, l2 and (lambda_k C_z)^2.
SOUGHT = (0, 1, 6, 7)
# A singular value below this share of the largest counts as zero.
RANK_TOLERANCE = 1e-9
SCENE = {
    "law": "lens",
    "fov_deg": 60,
    "noise": 0.0,
    "domain": "mm",
    "extent": "unbounded",
}


def rows_of_one_grid():
    """Return the rows of (2.24) for one grid.

    The unknown with entry 1; the coefficient i of V' or M' that multiplies
    C_y (u_2) or C_x (u_1), and which of the two; the right-hand side: "first"
    is V' or M', "second" W' or N', and its coefficient.
    """
    return (
        (7, 4, 2, "first", 7),
        (8, 5, 2, "first", 8),
        (4, 6, 2, "first", 9),
        (5, 4, 1, "second", 7),
        (6, 5, 1, "second", 8),
        (3, 6, 1, "second", 9),
    )


def scene_points(rng):
    """Return what 999 rays see of three tilted grids without noise, and the truth.

    Returns points (3, N, 2), centre (3,) and T_base_grid (3, 4, 4), mm.
    """
    data, _ = measure(SCENE, rng)
    T_base_camera = inverse_pose(data.grids[0])
    return data.points, T_base_camera[:3, 3], T_base_camera @ data.grids


def scaled_coefficients(points):
    """Return V', W', M', N' of (2.15) to (2.18) from points, (4, 9).

    The common scale is the least-squares ratio over the three shared
    entries, which (2.16) and (2.18) take from the first alone.
    """
    found = []
    for other in points[1:]:
        v, w, _ = solve_coefficients(points[0], other)
        found += [v, w * (v[3:6] @ w[:3]) / (w[:3] @ w[:3])]
    return np.array(found)


def matrix_a(coefficients):
    """Return A (12, 14) and x (12,) of A u = x (2.24), rows corrected."""
    A, x = np.zeros((12, UNKNOWNS_U)), np.zeros(12)
    for grid, (first, second) in enumerate((coefficients[:2], coefficients[2:])):
        for place, (unknown, i, centre, side, right) in enumerate(rows_of_one_grid()):
            row = 6 * grid + place
            A[row, unknown + 6 * grid - 1] = 1.0
            A[row, centre - 1] = -first[i - 1]
            vector = first if side == "first" else second
            x[row] = vector[right - 1]
    return A, x


def solution_space(A, x):
    """u = a + l1 b + l2 c (2.20): a (14,), orthonormal b and c (2, 14)."""
    return np.linalg.lstsq(A, x, rcond=None)[0], np.linalg.svd(A)[2][12:]


def matrix_d(a, basis, coefficients):
    """Return D (6, 8) and y (6,) of D v = y (2.25), from orthonormality."""
    rows, right = [], []
    for grid, vector in enumerate((coefficients[0], coefficients[2])):
        i = 5 + 6 * grid
        for p, q in ((i, i + 1), (i, i), (i + 1, i + 1)):
            row, constant = _quadratic(a, basis, p, q)
            norm = [0.0, 0.0]
            norm[grid] = -float(p == q)
            shared = vector[3 + p - i] * vector[3 + q - i]
            rows.append([*row, shared, *norm])
            right.append(-constant)
    return np.array(rows), np.array(right)


def _quadratic(a, basis, p, q):
    """u_p u_q + u_(p+2) u_(q+2): of l1, l2, l1 l2, l1^2, l2^2; constant."""
    b, c = basis

    def dot(f, g):
        return sum(f[p + n - 1] * g[q + n - 1] for n in (0, 2))

    row = [
        dot(a, b) + dot(b, a),
        dot(a, c) + dot(c, a),
        dot(b, c) + dot(c, b),
        dot(b, b),
        dot(c, c),
    ]
    return row, dot(a, a)


def column_sizes(matrix):
    """Return norms (n,) that scale the columns of A or D to order one.

    Columns hold quantities of different units. In D the column of l1 l2
    may be zero but for rounding, and takes the norm of that of l1^2.
    """
    size = np.linalg.norm(matrix, axis=0)
    if len(size) == len(UNKNOWNS_V):
        size[2] = size[3]
    return np.where(size > 0, size, 1.0)


def singular_values(matrix):
    """Return singular values over the largest, columns scaled to order one."""
    values = np.linalg.svd(matrix / column_sizes(matrix), compute_uv=False)
    return values / values[0]


def rank_of(values):
    """Return the number of relative singular values that are not zero."""
    return int(np.sum(values > RANK_TOLERANCE))


def null_entries(matrix):
    """Return the largest entry of a null vector of D on the unknowns sought.

    Relative to the vector's norm, columns scaled to order one.
    """
    size = column_sizes(matrix)
    null = np.linalg.svd(matrix / size)[2][5:]
    return float(np.abs(null[:, list(SOUGHT)]).max())


def solve_u(points):
    """u (14,) of (2.20), coefficients (4, 9), from points alone."""
    coefficients = scaled_coefficients(points)
    a, basis = solution_space(*matrix_a(coefficients))
    D, y = matrix_d(a, basis, coefficients)
    size = column_sizes(D)
    v = np.linalg.lstsq(D / size, y, rcond=RANK_TOLERANCE)[0] / size
    return a + v[0] * basis[0] + v[1] * basis[1], coefficients


def depth_squared(u, coefficients, printed):
    """Return C_z^2 of (2.23): numerator u5 u6 + u7 u8; printed, u6 u6 + u7 u8."""
    first = u[5] if printed else u[4]
    v = coefficients[0]
    return -(first * u[5] + u[6] * u[7]) / (v[3] * v[4])
