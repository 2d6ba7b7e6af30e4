"""Shape of a mirror from viewing and scene directions, linearly (5.8-5.25).

The bisector of the two directions is the mirror's normal, and the surface's tangents
are at right angles to it: two linear equations for the spline's coefficients from each
pair. They leave its size open, which known mirror points or a clamp settle.
Sources: Swaminathan, Nayar, Grossberg 2003; Halstead et al. 1996,
doi:10.1145/237170.237272.
"""

import numpy as np

from raxel.calibration.mirror.clamp import TRUNCATION, clamped
from raxel.cameras.mirrors.spline_surface import depth_rows, sense
from raxel.errors import CalibrationError

# Of the largest singular value: what is below says nothing but rounding.
RANK = 1e-10


def reflection_normals(viewing, scene):
    """Unit normals (N, 3) into the mirror (5.8), of directions (N, 3).

    viewing: from the camera to the mirror; scene: from the mirror to the scene. One
    that points the other way gives a tangent in place of the normal (E-5.03).
    """
    viewing, scene = _unit(viewing), _unit(scene)
    return _unit(viewing - scene)


def orthogonality_rows(p, normals, grid, quantity):
    """Rows (2N, K) whose products with the coefficients vanish (5.15, 5.16).

    p: (N, 2) normalised image coordinates; normals: (N, 3) unit. First the N rows of
    the derivative by x, then those by y. A residual is S_x . N, mm, for the quantity
    "distance", and S_z^2 times smaller for "inverse depth".
    """
    B, B_x, B_y = depth_rows(grid, p, quantity)
    along = sense(quantity) * (np.sum(p * normals[:, :2], axis=1) + normals[:, 2])
    return np.vstack(
        [
            normals[:, :1] * B + along[:, None] * B_x,
            normals[:, 1:2] * B + along[:, None] * B_y,
        ]
    )


def shape_up_to_scale(p, normals, grid, quantity, *, equilibrate=True):
    """Coefficients (K,) of unit length from normals alone, all in front (5.15, 5.16).

    p: (N, 2); normals: (N, 3). The smallest singular vector, also where misfit gives
    the matrix full rank; equilibrate: columns are brought to one length first. Raises
    CalibrationError where directions leave more open than the size.
    """
    A = orthogonality_rows(p, normals, grid, quantity)
    scale = _column_lengths(A) if equilibrate else np.ones(grid.size)
    _, size, Vt = np.linalg.svd(A / scale, full_matrices=len(A) < grid.size)
    rank = np.count_nonzero(size > RANK * size[0])
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
    p, normals, grid, quantity, clamp, *, truncation=TRUNCATION, further=None
):
    """Coefficients (K,) from normals and a Clamp, by least squares (5.22-5.25).

    p: (N, 2) normalised image coordinates; normals: (N, 3) unit; clamp, truncation:
    see `clamped`; further: rows (R, K) and values (R,) of more equations, such as a
    prior's, in the unit of `orthogonality_rows`. Columns are equilibrated. Raises
    CalibrationError where coefficients are left open.
    """
    space = clamped(grid, clamp, truncation)
    A = orthogonality_rows(p, normals, grid, quantity)
    values = np.zeros(len(A))
    if further is not None:
        A, values = np.vstack([A, further[0]]), np.append(values, further[1])
    M = A @ space.directions
    scale = _column_lengths(M)
    gap = values - A @ space.particular
    free, _, rank, _ = np.linalg.lstsq(M / scale, gap, rcond=RANK)
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
