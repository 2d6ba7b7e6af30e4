"""Caustics: closest approaches of neighbouring rays of a camera."""

import numpy as np

# Five-point central difference: offsets in steps, and weights.
STENCIL = ((-2, 1 / 12), (-1, -2 / 3), (1, 2 / 3), (2, -1 / 12))
# Relative size below which a determinant or a difference of two roots is rounding.
RELATIVE_TOL = 1e-9
DOUBLE_ROOT_TOL = 1e-6


def caustic_points(camera, pixels, step=0.25):
    """Points (N, 2, 3) of the two caustic sheets on the rays of pixels (N, 2).

    The ray map is X(u, v, s) = O + s D. Its Jacobian is singular where, seen along the
    ray, [O_u + s D_u, O_v + s D_v] has no area: a quadratic in s. Sheet 0 is the root
    with the smaller s, so it is farther back on the ray; s is negative for the
    virtual caustic behind a convex mirror. Derivatives are five-point differences of
    `camera.rays` over +-2 `step` pixels, with an error of order step^4.
    NaN where the pixel or a neighbour has no ray, where the roots are complex (the rays
    twist) or at infinity; a single finite root is sheet 0. A central camera's caustic
    is its centre, twice.
    Source: Swaminathan, Grossberg, Nayar 2006, Non-single viewpoint catadioptric
    cameras: geometry and analysis, International Journal of Computer Vision 66(3).
    """
    pixels = np.asarray(pixels, float)
    origins, directions, _ = camera.rays(pixels)
    first, second = _axes_across(directions)
    spread, turn = np.empty((2, len(pixels), 2, 2))
    for k, unit in enumerate(np.eye(2)):
        moved = [camera.rays(pixels + n * step * unit) for n, _ in STENCIL]
        weighted = [
            (w / step, rays) for (_, w), rays in zip(STENCIL, moved, strict=True)
        ]
        dO = sum(w * (rays.origins - origins) for w, rays in weighted)
        dD = sum(w * (rays.directions - directions) for w, rays in weighted)
        for matrix, change in ((spread, dO), (turn, dD)):
            matrix[:, 0, k] = np.sum(change * first, axis=1)
            matrix[:, 1, k] = np.sum(change * second, axis=1)
    s = _singular_steps(spread, turn)
    return origins[:, None] + s[:, :, None] * directions[:, None]


def _axes_across(directions):
    """Two unit vectors (N, 3) perpendicular to each direction and to each other."""
    unit = np.eye(3)[np.argmin(np.abs(np.nan_to_num(directions)), axis=1)]
    first = np.cross(directions, unit)
    with np.errstate(invalid="ignore"):
        first = first / np.linalg.norm(first, axis=1, keepdims=True)
    return first, np.cross(directions, first)


def _singular_steps(A, B):
    """Steps s (N, 2), ascending, where A + s B is singular; A, B (N, 2, 2).

    They are the eigenvalues of -B^-1 A. For a central camera that is a multiple of the
    identity. Its eigenvalues, unlike the roots of the quadratic, are as accurate as the
    differences.
    """
    with np.errstate(all="ignore"):
        det = B[:, 0, 0] * B[:, 1, 1] - B[:, 0, 1] * B[:, 1, 0]
        size = np.sum(B**2, axis=(1, 2))
        adjugate = np.empty_like(B)
        adjugate[:, 0, 0], adjugate[:, 1, 1] = B[:, 1, 1], B[:, 0, 0]
        adjugate[:, 0, 1], adjugate[:, 1, 0] = -B[:, 0, 1], -B[:, 1, 0]
        M = -adjugate @ A
        middle = (M[:, 0, 0] + M[:, 1, 1]) / 2
        half = (M[:, 0, 0] - M[:, 1, 1]) / 2
        square = half**2 + M[:, 0, 1] * M[:, 1, 0]
        near = square >= -((DOUBLE_ROOT_TOL * np.abs(middle)) ** 2)
        gap = np.sqrt(np.where(near, np.maximum(square, 0), np.nan))
        whole = np.abs(det) > RELATIVE_TOL * size
        two = np.stack([middle - gap, middle + gap], axis=1) / det[:, None]
        two.sort(axis=1)
        # B singular: one root is infinite and the linear equation is left.
        det_A = A[:, 0, 0] * A[:, 1, 1] - A[:, 0, 1] * A[:, 1, 0]
        bent = np.abs(middle) > RELATIVE_TOL * np.sqrt(size * np.sum(A**2, axis=(1, 2)))
        one = np.where(bent, det_A / (2 * middle), np.nan)
        single = np.stack([one, np.full_like(one, np.nan)], axis=1)
        return np.where(whole[:, None], two, single)
