"""Lines in space in Plücker form: the 4x4 matrix (2.11) and the 6-vector (2.12).

Both forms are homogeneous: only their direction in 16 or 6 dimensions has a meaning.
The 6-vector keeps the thesis's order, which is **not** the usual one: direction first,
then the moment with its sign *reversed*. For finite points A and B

    L = 2 (B - A ; -(A x B)) = 2 (d ; q),    q = d x A = -(A x d),

while textbooks write (d ; A x d). Whoever takes a formula from a book into code that
uses this order changes the sign of the last three entries (errata E-2.03, E-5.12).
"""

import numpy as np

# Row and column of the first term of each entry of (2.12), counted from zero.
ORDER = ((3, 0), (3, 1), (3, 2), (2, 1), (0, 2), (1, 0))


def pluecker_matrix(A, B):
    """Plücker matrix A B^T - B A^T of the line through two distinct points (2.11).

    A, B: (..., 4) homogeneous points, any frame and unit. Returns (..., 4, 4),
    skew-symmetric. Two equal points have no line: their matrix is zero.
    """
    A, B = np.asarray(A, float), np.asarray(B, float)
    product = A[..., :, None] * B[..., None, :]
    return product - np.swapaxes(product, -1, -2)


def pluecker_matrix_of_rays(origins, directions):
    """Plücker matrices of the lines through `origins` along `directions`.

    origins: (..., 3) in the unit of length of the frame; directions: (..., 3), not
    zero. Returns (..., 4, 4). With unit directions, (2.12) of the result is
    2 (d ; -(o x d)).
    """
    origins, directions = np.broadcast_arrays(
        np.asarray(origins, float), np.asarray(directions, float)
    )
    one = np.ones((*origins.shape[:-1], 1))
    return pluecker_matrix(
        np.concatenate([origins, one], axis=-1),
        np.concatenate([directions, 0.0 * one], axis=-1),
    )


def pluecker_vector(M):
    """Plücker 6-vector of a Plücker matrix, in the thesis's order (2.12).

    M: (..., 4, 4). Returns (..., 6): twice the direction, then twice the negated
    moment. The last three entries vanish for a line through the origin.
    """
    M = np.asarray(M, float)
    return np.stack([M[..., i, j] - M[..., j, i] for i, j in ORDER], axis=-1)
