"""Trials of this page, their conditions and constants."""

import numpy as np

from chapters.shared.general import measure
from raxel.calibration import (
    BoardView,
    bundle_adjust_fixed_centre,
    linear_as_printed,
    linear_well_conditioned,
    pixels_on_board,
    rays_from_known_motion,
    sample_boards,
    solve_coefficients,
    three_point_depths,
)
from raxel.cameras import pixel_grid
from raxel.errors import CalibrationError
from raxel.evaluation import angular_residual
from raxel.geometry import (
    angle_between_rotations,
    intersect_rays_plane,
    inverse_pose,
    on_plane,
    pose,
    rotation_from_vector,
    transform,
)
from repro.run import Plan, crossed, experiment

# The boards that Algorithm 1 is run on: chessboards in drawn poses.


SIZE_PX = 240
COLUMNS, ROWS = 25, 21
PITCH_MM = 30.0
DISTANCE_MM = 450.0
SHIFT_MM = 150.0
TILT_DEG = 30.0
BOARDS = 8


def board_points():
    """Return the corners (N, 2) of the board, its centre at the origin, mm."""
    x, y = np.meshgrid(np.arange(COLUMNS), np.arange(ROWS))
    middle = [(COLUMNS - 1) / 2, (ROWS - 1) / 2]
    return PITCH_MM * (np.column_stack([x.ravel(), y.ravel()]) - middle)


def draw_poses(rng):
    """Return poses T_camera_grid (n, 4, 4), tilted and shifted in all directions."""
    angles = np.radians(rng.uniform(-TILT_DEG, TILT_DEG, (BOARDS, 3)))
    shift = rng.uniform(-SHIFT_MM, SHIFT_MM, (BOARDS, 3))
    return pose(rotation_from_vector(angles), shift + [0.0, 0.0, DISTANCE_MM])


# Every real solution of the three equations (2.26), for any anchor points.
#
# Grunert's formulas, which the library uses, assume pairs of opposite sign and
# require a common anchor. A test of the pairs needs a solver that does not assume
# them. Here one depth is eliminated after the other: with x = lambda_l fixed, two
# of the equations are monic quadratics in y = lambda_m and z = lambda_n alone, so
# every polynomial in y and z reduces to the basis 1, y, z, y z. The third
# equation, times each of the basis, must vanish: a 4 x 4 matrix whose determinant
# is a polynomial of degree 8 in x.


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


@experiment("exp_c2_pose_eight", artefact="sec_2_4_2")
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


# The two linear systems of section 2.4.1, written out row by row.
#
# The library solves the linear stage differently. Here the matrices A (2.24)
# and D (2.25) are built from the corrected rows, to test the stated ranks.
# Unknowns and coefficients are counted from one, as in print; an array holds
# unknown i at index i - 1.


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


# Linear stage of section 2.4.1 on data without noise: trials and plans.


WRONG_MM = 1.0

SCENES = {"quick": 10, "full": 100}

LINEAR_SETTINGS = {
    "scene": SCENE,
    "rays": 999,
    "grids": "as in the simulation of section 2.5.1",
    "rank_tolerance": RANK_TOLERANCE,
}


def unit_of(points):
    """Return a length (mm) that scales the points of the base grid to order 1."""
    return np.sqrt(np.mean(np.sum(points[0] ** 2, axis=1)))


def rank_a_trial(condition, rng):
    """Return the rank of A and its relative singular values, in one scene."""
    points, _, _ = scene_points(rng)
    A, _ = matrix_a(scaled_coefficients(points / unit_of(points)))
    values = singular_values(A)
    return {"unknowns": A.shape[1], "rank": rank_of(values), "smallest": values[-1]}


@experiment("exp_c2_rank_A", artefact="sec_2_4_1")
def rank_of_a(effort):
    """Singular values of A (2.24) in random noise-free scenes."""
    return Plan(rank_a_trial, [{}], SCENES[effort], LINEAR_SETTINGS)


def rank_d_trial(condition, rng):
    """Return rank and null vectors of D, for two bases of A's null space."""
    points, _, _ = scene_points(rng)
    coefficients = scaled_coefficients(points / unit_of(points))
    a, basis = solution_space(*matrix_a(coefficients))
    mixed = rng.normal(size=(2, 2)) @ basis
    out = {}
    for name, used in (("orthonormal", basis), ("any", mixed)):
        D, _ = matrix_d(a, used, coefficients)
        values = singular_values(D)
        out[name] = {
            "rank": rank_of(values),
            "fifth": values[4],
            "sixth": values[5],
            "null_entry": null_entries(D),
            "l1_l2_column": np.linalg.norm(D[:, 2]) / np.linalg.norm(D[:, 3]),
        }
    return out


@experiment("exp_c2_rank_D", artefact="sec_2_4_1")
def rank_of_d(effort):
    """Singular values and null vectors of D (2.25), the same way."""
    return Plan(rank_d_trial, [{}], SCENES[effort], LINEAR_SETTINGS)


def exact_trial(condition, rng):
    """Return the errors of the linear stage on exact data, for each form."""
    points, centre, poses = scene_points(rng)
    side = np.sign(centre[2])
    forms = {
        "corrected": lambda: linear_as_printed(*points, side=side, tz="corrected"),
        "tz_printed": lambda: linear_as_printed(*points, side=side),
        "well_conditioned": lambda: linear_well_conditioned(points, side=side),
    }
    out = {name: _linear_errors(form, centre, poses) for name, form in forms.items()}
    unit = unit_of(points)
    u, coefficients = solve_u(points / unit)
    for name, printed in (("corrected", False), ("printed", True)):
        square = depth_squared(u, coefficients, printed)
        out[f"{name}_negative"] = bool(square < 0)
        depth = unit * np.sqrt(square) if square >= 0 else np.nan
        out[f"{name}_depth_mm"] = abs(depth - abs(centre[2]))
    return out


@experiment("exp_c2_linear_exact", artefact="sec_2_4_1")
def exact_data(effort):
    """The linear stage on exact data, in three forms of its formulas."""
    return Plan(exact_trial, [{}], SCENES[effort], LINEAR_SETTINGS)


def _linear_errors(form, centre, poses):
    try:
        found = form()
    except CalibrationError as error:
        return {"failed": error.code}
    return {
        "centre_mm": np.linalg.norm(found.centre - centre),
        **pose_errors(found.T_base_grid, poses),
    }


def pose_errors(found, true):
    """Return the largest error of translations (mm) and of rotations (rad)."""
    shift = np.linalg.norm((found - true)[:, :3, 3], axis=1)
    turn = angle_between_rotations(found[:, :3, :3], true[:, :3, :3])
    return {"translation_mm": shift.max(), "rotation_rad": turn.max()}


def no_motion_trial(condition, rng):
    """Return poses from intersections alone, and results of the two-pose method.

    T_1 of the two-pose method is right, or wrong by 1 mm along a random
    direction.
    """
    points, centre, poses = scene_points(rng)
    way = rng.normal(size=3)
    way *= WRONG_MM / np.linalg.norm(way)
    out = {"two_pose_deg": {}}
    true = on_plane(points[0]) - centre
    true /= np.linalg.norm(true, axis=1, keepdims=True)
    for name, error in (("right", np.zeros(3)), ("wrong", way)):
        known = poses[:2].copy()
        known[1, :3, 3] += error
        found = rays_from_known_motion(points[:2], known)
        # Lines: the grids of this scene may cross within the view.
        cosine = np.sum(found.directions * true, axis=1)
        sine = np.linalg.norm(np.cross(found.directions, true), axis=1)
        angle = np.arctan2(sine, np.abs(cosine))
        out["two_pose_deg"][name] = np.nanmedian(np.degrees(angle))
    try:
        start = linear_well_conditioned(points)
        adjusted = bundle_adjust_fixed_centre(
            points, np.ones(points.shape[:2], bool), start.centre, start.T_base_grid
        )
    except CalibrationError as error:
        return out | {"failed": error.code}
    errors = pose_errors(adjusted.T_base_grid, poses)
    return out | {
        "pose_mm": errors["translation_mm"],
        "pose_rad": errors["rotation_rad"],
    }


@experiment("exp_c2_generic_no_motion", artefact="alg_1")
def no_motion(effort):
    """Poses from intersections alone, compared with the two-pose method."""
    settings = LINEAR_SETTINGS | {"error_put_on_T_1_mm": 1.0}
    return Plan(no_motion_trial, [{}], SCENES[effort], settings)


# Outcome of each of the six steps of Algorithm 1, on projected boards.
#
# A camera looks at chessboards; their corners are projected, not detected,
# so there is no noise. The library calibrates from the corners alone, and the
# truth is used only to score each step.


SAMPLES = 20_000


def view_board(camera, T_camera_grid):
    """Return a BoardView of the corners inside the image; NaN for the others."""
    points = board_points()
    seen = camera.project(transform(T_camera_grid, on_plane(points)))
    inside = seen.valid & camera.in_image(seen.pixels)
    pixels = np.where(inside[:, None], seen.pixels, np.nan)
    return BoardView(pixels, points, COLUMNS, ROWS)


def overlap(views):
    """Return for step 1 the shares of pixels on at least one and three boards."""
    boards = np.zeros((SIZE_PX, SIZE_PX), int)
    for view in views:
        pixels, _ = pixels_on_board(view, SIZE_PX, SIZE_PX)
        boards[pixels[:, 1], pixels[:, 0]] += 1
    return {
        "boards": len(views),
        "one": np.mean(boards >= 1),
        "three": np.mean(boards >= 3),
    }


def locating(camera, views, grids):
    """Return for step 2 the pixels located on boards, and their median error in mm."""
    errors = []
    for view, T_camera_grid in zip(views, grids, strict=True):
        pixels, points = pixels_on_board(view, SIZE_PX, SIZE_PX)
        rays = camera.rays(pixels.astype(float))
        hits = intersect_rays_plane(rays.origins, rays.directions, T_camera_grid)
        errors.append(np.linalg.norm(points - hits.points, axis=1))
    errors = np.concatenate(errors)
    return {"pixels": len(errors), "median_mm": np.median(errors)}


def first_three(views, used, truth):
    """Run steps 3 and 4 on the first three boards of the calibration."""
    samples = sample_boards(views, SIZE_PX, SIZE_PX, SAMPLES)
    points, seen = samples.points[used[:3]], samples.seen[used[:3]]
    start = linear_well_conditioned(points, seen)
    adjusted = bundle_adjust_fixed_centre(points, seen, start.centre, start.T_base_grid)
    observed = seen[:, seen.sum(axis=0) >= 2].sum()
    rms = np.sqrt(adjusted.costs[[0, -1]] / observed)
    return {
        "linear": {"pose_mm": largest_shift(start.T_base_grid, truth[:3])},
        "bundle": {
            "start_mm": rms[0],
            "end_mm": rms[1],
            "pose_mm": largest_shift(adjusted.T_base_grid, truth[:3]),
        },
    }


def largest_shift(poses, truth):
    """Return the largest distance (mm) of estimated grid origins from the true ones."""
    return np.linalg.norm((poses - truth)[:, :3, 3], axis=1).max()


def scored_table(camera, table):
    """Return for step 6 the matrices in the table, and the error of its rays."""
    pixels = pixel_grid(SIZE_PX, SIZE_PX)
    true, found = camera.rays(pixels), table.rays(pixels)
    both = true.valid & found.valid
    matrices = table.pluecker().reshape(-1, 4, 4)[both]
    turned = angular_residual(found.directions[both], true.directions[both])
    middle = np.array([[SIZE_PX / 2, SIZE_PX / 2], [SIZE_PX / 2 + 1, SIZE_PX / 2]])
    a, b = camera.rays(middle).directions
    return {
        "matrices": int(np.isfinite(matrices).all(axis=(1, 2)).sum()),
        "share": table.share_with_ray,
        "median_deg": np.degrees(np.median(turned)),
        "largest_deg": np.degrees(turned.max()),
        "pixel_deg": np.degrees(np.linalg.norm(a - b)),
    }
