"""The bilinear collinearity constraints of generic calibration (thesis 2.13, 2.14).

A ray through the camera centre C meets the base grid in Q^1 and grid k in Q^k. With the
base grid as world plane z = 0, the 3x3 minors of (2.13) that hold the columns of C, Q^1
and Q^k and the rows yzw or xzw vanish:

    Q1y (v_a . q) + v_b . q = 0        Q1x (w_a . q) + w_b . q = 0

for q = (x, y, 1) on grid k. Table 2.1 lists the nine coefficients of each equation in
the order (j, k) = xx xy xw yx yy yw wx wy ww of the products Q^1_j Q^k_k. Three of the
nine are zero by construction; only the other six are solved for.

Sources: thesis section 2.4.1; P. Sturm and S. Ramalingam, A generic concept for camera
calibration, ECCV 2004, doi:10.1007/978-3-540-24671-8_1.
"""

import numpy as np

from raxel.errors import CalibrationError

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


def table_2_1(centre, T_base_2, T_base_3, row_3="corrected"):
    """The four coefficient vectors of Table 2.1 for three grids.

    row_3: "corrected", or "printed" for the superscripts of t_z as the thesis prints
    them in row i = 3, each one too low (W_3 = -C_z + t_z^1 with t_z^1 = 0, and
    N_3 = -C_z + t_z^2). Returns (4, 9): rows V, W, M, N.
    """
    v, w = coefficient_vectors(centre, T_base_2)
    m, n = coefficient_vectors(centre, T_base_3)
    if row_3 == "printed":
        w[2] = -centre[2]
        n[2] = -centre[2] + T_base_2[2, 3]
    elif row_3 != "corrected":
        raise ValueError(f"row_3: {row_3!r}; expected 'corrected' or 'printed'")
    return np.stack([v, w, m, n])


def solve_coefficients(points_1, points_k, weights=None):
    """Least-squares null vectors (V, W) of (2.14) and the noise in their entries.

    points_1, points_k: (N, 2), N >= 6 rays seen on both grids. weights: (N,) factors of
    the equations. The two 6-column systems are solved apart, as the thesis does, so V
    and W, each (9,) with unit norm, have unrelated scales and signs. noise: the larger
    standard deviation of the two, as a length, estimated from what the points leave
    over.
    Raises CalibrationError where the points do not determine them.
    """
    if len(points_1) < 6:
        raise CalibrationError(
            f"linear stage: {len(points_1)} rays see both grids; at least 6 are needed",
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
            "linear stage: the points common to two grids lie on a line;"
            " use boards that share an area of the image",
            code="degenerate-points",
        )
    vector = np.zeros(9)
    vector[terms] = right[5]
    left_over = singular[5] / np.sqrt(max(len(products) - 5, 1))
    return vector, left_over * np.sqrt(np.sum(singular[:5] ** -2))
