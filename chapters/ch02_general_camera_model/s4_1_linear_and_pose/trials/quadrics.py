"""Every real solution of the three equations (2.26), for any anchor points.

Grunert's formulas, which the library uses, assume pairs of opposite sign and
require a common anchor. A test of the pairs needs a solver that does not assume
them. Here one depth is eliminated after the other: with x = lambda_l fixed, two
of the equations are monic quadratics in y = lambda_m and z = lambda_n alone, so
every polynomial in y and z reduces to the basis 1, y, z, y z. The third
equation, times each of the basis, must vanish: a 4 x 4 matrix whose determinant
is a polynomial of degree 8 in x.
"""

import numpy as np

from raxel.calibration import three_point_depths
from raxel.geometry import on_plane, pose, rotation_from_vector, transform
from repro.run.experiment import experiment
from repro.run.outcomes import Plan, crossed

PAIRS = ((0, 1), (0, 2), (1, 2))
DEGREE = 8
# Order of the rays l, m, n. Different solutions may have nearly the same depth
# along one ray, and rounding then merges their roots; along another ray they
# differ.
ORDERS = ([0, 1, 2], [1, 2, 0], [2, 0, 1])
STEPS = 15
REAL = 1e-7  # relative size of an imaginary part that is rounding
AGREEMENT = 1e-10  # relative error of a squared distance that is a solution
SAME = 1e-6  # relative distance at which two solutions are one


def real_solutions(anchors, directions, points):
    """Return depths (K, 3) of all real solutions of (2.26), K <= 8.

    anchors, directions: (3, 3), unit directions; points: (3, 2), mm.
    """
    anchors, unit = np.asarray(anchors, float), _size(directions, points)
    size = unit + np.ptp(anchors, axis=0).max()
    problem = anchors / size, np.asarray(directions), points / size
    starts = np.concatenate([_starts(order, problem) for order in ORDERS])
    found = []
    for depths in _polished(starts, problem):
        if not _among(depths, found):
            found.append(depths)
    return size * np.array(found).reshape(-1, 3)


def _starts(order, problem):
    """Complex depths (8, 3), by elimination in this order of the rays."""
    ordered = [part[order] for part in problem]
    depths = np.empty((DEGREE, 3), complex)
    for k, x in enumerate(_roots(ordered)):
        depths[k, order] = _others(x, ordered)
    return depths


def _roots(problem):
    """Roots of the determinant: 8 first depths, most of them complex.

    Its values on the unit circle give the coefficients (by Fourier
    transform).
    """
    turn = np.exp(2j * np.pi * np.arange(2 * DEGREE) / (2 * DEGREE))
    determinants = np.linalg.det(np.stack([_eliminant(x, *problem) for x in turn]))
    coefficients = np.fft.fft(determinants)[: DEGREE + 1].real
    return np.roots(coefficients[::-1])


def paired_share(depths):
    """Return the share of solutions (K, 3) whose negative is a solution too."""
    return np.mean([_among(-one, depths) for one in depths])


def agreement(depths, others):
    """Return whether two sets of solutions, (K, 3) and (L, 3), are the same."""
    return len(depths) == len(others) and all(_among(one, others) for one in depths)


def _size(directions, points):
    """Length of the order of the depths: gap over sine of two rays."""
    directions, points = np.asarray(directions), np.asarray(points)
    sizes = [
        np.linalg.norm(points[i] - points[j])
        / np.linalg.norm(np.cross(directions[i], directions[j]))
        for i, j in PAIRS
    ]
    return np.median(sizes)


def _equations(anchors, directions, points):
    """(2.26) for l, m: s^2 + t^2 - 2 c s t + 2 e s - 2 f t + g = 0."""
    for i, j in PAIRS:
        apart = anchors[i] - anchors[j]
        gap = points[i] - points[j]
        yield (
            directions[i] @ directions[j],
            apart @ directions[i],
            apart @ directions[j],
            apart @ apart - gap @ gap,
        )


def _eliminant(x, anchors, directions, points):
    """The 4 x 4 matrix whose determinant vanishes at a solution's x."""
    (c1, e1, f1, g1), (c2, e2, f2, g2), (c, e, f, g) = _equations(
        anchors, directions, points
    )
    # y^2 + p y + q = 0 and z^2 + r z + s = 0.
    p, q = -2 * (c1 * x + f1), x * x + 2 * e1 * x + g1
    r, s = -2 * (c2 * x + f2), x * x + 2 * e2 * x + g2
    one = np.eye(4)
    # Multiplication by y and by z in the basis 1, y, z, y z.
    Y = np.array([one[1], -q * one[0] - p * one[1], one[3],
                  -q * one[2] - p * one[3]])  # fmt: skip
    Z = np.array([one[2], one[3], -s * one[0] - r * one[2],
                  -s * one[1] - r * one[3]])  # fmt: skip
    return Y @ Y + Z @ Z - 2 * c * Y @ Z + 2 * e * Y - 2 * f * Z + g * one


def _others(x, problem):
    """Depths (3,) of the solution with first depth x: the null vector."""
    null = np.linalg.svd(_eliminant(x, *problem))[2][3]
    return np.array([x, null[1] / null[0], null[2] / null[0]])


def _polished(depths, problem):
    """Newton on (2.26) in complex numbers, (M, 3); the real ones found.

    Roots that are close together start off the real axis by the square
    root of the rounding, and find back to it.
    """
    for _ in range(STEPS):
        error, jacobian = _errors(depths, *problem)
        step = np.linalg.pinv(jacobian, rcond=1e-14) @ error[..., None]
        depths = depths - step[..., 0]
        size = 1 + np.abs(depths).max(axis=1)
        if np.all(np.abs(step[..., 0]).max(axis=1) < 1e-14 * size):
            break
    error, _ = _errors(depths, *problem)
    limit = AGREEMENT * np.sum(np.ptp(problem[2], axis=0) ** 2)
    good = np.abs(error).max(axis=1) < limit
    imaginary = np.abs(depths.imag).max(axis=1)
    good &= imaginary < REAL * np.abs(depths).max(axis=1)
    return depths[good].real


def _errors(depths, anchors, directions, points):
    """Errors (M, 3) of (2.26) at depths (M, 3), and Jacobians (M, 3, 3)."""
    corners = anchors + depths[..., None] * directions
    error = np.zeros((len(depths), 3), complex)
    jacobian = np.zeros((len(depths), 3, 3), complex)
    for k, (i, j) in enumerate(PAIRS):
        apart, gap = corners[:, i] - corners[:, j], points[i] - points[j]
        error[:, k] = np.sum(apart**2, axis=1) - gap @ gap
        jacobian[:, k, i] = 2 * apart @ directions[i]
        jacobian[:, k, j] = -2 * apart @ directions[j]
    return error, jacobian


def _among(depths, found):
    return any(
        np.abs(depths - other).max() < SAME * (1e-3 + np.abs(other).max())
        for other in found
    )


# Random triplets

POINT_MM, ANCHOR_MM = 150.0, 40.0
TURN_RAD = 0.6


def draw_triplet(rng, anchors):
    """Anchors and unit directions (3, 3), points (3, 2), depths (3,)."""
    turn = rotation_from_vector(TURN_RAD * rng.normal(size=3))
    shift = rng.uniform([-200, -200, 150], [200, 200, 900])
    points = rng.uniform(-POINT_MM, POINT_MM, (3, 2))
    corners = transform(pose(turn, shift), on_plane(points))
    starts = np.zeros((3, 3))
    if anchors == "distinct":
        starts = rng.uniform(-ANCHOR_MM, ANCHOR_MM, (3, 3))
    depths = np.linalg.norm(corners - starts, axis=1)
    return starts, (corners - starts) / depths[:, None], points, depths


def triplet_trial(condition, rng):
    """Real solutions of one random triplet: number, and share in pairs."""
    anchors, directions, points, depths = draw_triplet(rng, condition["anchors"])
    found = real_solutions(anchors, directions, points)
    out = {
        "solutions": len(found),
        "paired_share": paired_share(found) if len(found) else None,
        "truth_found": _among(depths, found),
        "ahead": int(np.all(found > 0, axis=1).sum()),
    }
    if condition["anchors"] == "common":
        grunert = three_point_depths(directions[None], points[None])[0]
        grunert = grunert[np.isfinite(grunert).all(axis=1)]
        out["grunert_agrees"] = agreement(found, grunert)
    return out


TRIPLETS = {"quick": 100, "full": 1000}


@experiment("exp_c2_pose_eight", artefact="sec_2_4_2", shards={"full": 4})
def triplets(effort):
    """Every real solution of (2.26) for random triplets of rays."""
    conditions = crossed(anchors=("common", "distinct"))
    settings = {
        "points": "three in a square of 300 mm",
        "pose": "150 to 900 mm away, turned by about 35 deg (SD 0.6 rad on each axis)",
        "distinct_anchors": "each within a cube of 80 mm",
        "solver": "elimination to a polynomial of degree 8, any anchors",
    }
    return Plan(triplet_trial, conditions, TRIPLETS[effort], settings)
