"""Grunert's solution of the three-point problem, for many triples at once.

The depths of three points along their rays follow from the three distances between
them (thesis 2.26, rays with one origin). Eliminating two depths leaves a quartic.
Source: Haralick, Lee, Ottenberg, Nölle 1994, doi:10.1007/BF02028352.
"""

import numpy as np

NEARLY_REAL = 1e-3  # a double root leaves the real axis by the root of the rounding
AGREEMENT = 1e-7  # relative error of the squared distances of an accepted solution


def three_point_depths(directions, points):
    """All real depths of three points on three rays of one origin (2.26).

    directions: (M, 3, 3), three unit vectors for each of M triples; points: (M, 3, 2)
    on the grid. Returns (M, 8, 3): at most eight solutions, in pairs of opposite sign
    (k and k + 4), NaN for those that are not there. A pair may lie behind the origin;
    triples with coincident points have none.
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
    real = np.abs(v.imag) <= NEARLY_REAL * (1 + np.abs(v))
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

    A vanishing leading coefficient sends a root to infinity: it is kept finite.
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

    depths: (M, 4, 3); the equation opposite point k joins the other two depths.
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
        # A double root has a singular Jacobian: a trace of damping keeps it finite.
        size = np.trace(normal, axis1=2, axis2=3)[..., None, None]
        normal = normal + 1e-12 * (size + 1e-300) * np.eye(3)
        s = s - np.linalg.solve(normal, transposed @ gap[..., None])[..., 0]
    d, e = s[..., first], s[..., second]
    gap = np.abs(d**2 + e**2 - 2 * d * e * cosine - square)
    holds = np.all(gap <= AGREEMENT * np.max(square, axis=2, keepdims=True), axis=2)
    return np.where((present & holds)[..., None], s, np.nan)
