"""Section 4.1.2: minimal rays, gross outliers, and the precision of the SVD."""

import numpy as np

from chapters.shared.central import (
    CENTRE_MM,
    SETTINGS,
    SIDE,
    draw_poses,
    draw_scene,
    radial_lens,
)
from raxel.calibration import linear_cgsp
from raxel.errors import CalibrationError
from raxel.geometry import (
    angle_between_rotations,
    apply_homography,
    normalising,
    pose,
    rotation_from_vector,
)
from repro.run import Plan, crossed, experiment

TRIALS = {"quick": 20, "full": 200}
MIN_TILT_DEG = 5.0
MIN_AREA = 0.1  # of the mean squared distance from the centroid
RANK_TOLERANCE = 1e-9
STEP = 1e-6
TRIPLES = ((0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3))


def equations(source, target, T_s, T_t):
    """Rows (2 N, 9) of the direct linear transform, for points mapped by T (3, 3)."""
    s = np.pad(apply_homography(T_s, source), ((0, 0), (0, 1)), constant_values=1.0)
    x, y = apply_homography(T_t, target).T[..., None]
    zero = np.zeros_like(s)
    return np.block([[s, zero, -x * s], [zero, s, -y * s]])


def rank_of(matrix):
    """Numerical rank, with columns of unit length."""
    values = np.linalg.svd(matrix / np.linalg.norm(matrix, axis=0), compute_uv=False)
    return int(np.count_nonzero(values > RANK_TOLERANCE * values[0]))


def tilted(T_base_grid):
    """Whether all grids are tilted against each other."""
    normals = T_base_grid[:, :3, 2]
    cosine = np.abs(normals @ normals.T)[np.triu_indices(3, 1)]
    return cosine.max() < np.cos(np.radians(MIN_TILT_DEG))


def spread(points):
    """Whether four points (4, 2) have no three nearly on one line."""
    size = np.mean(np.sum((points - points.mean(axis=0)) ** 2, axis=1))
    areas = []
    for triple in TRIPLES:
        a, b = points[triple[1:], :] - points[triple[0]]
        areas.append(abs(a[0] * b[1] - a[1] * b[0]) / 2)
    return min(areas) >= MIN_AREA * size


def draw_minimal(rng):
    """A scene without noise and four of its rays, in general position."""
    while True:
        seen = draw_scene(radial_lens(), 0.0, rng)
        picks = rng.choice(seen.points.shape[1], 4, replace=False)
        if tilted(seen.T_base_grid) and spread(seen.points[0, picks]):
            return seen.T_base_grid, seen.points[:, picks]


def minimal_trial(condition, rng):
    """Centre and poses from three or four rays; the ranks of the equations."""
    T_base_grid, points = draw_minimal(rng)
    points = points[:, : condition["rays"]]
    base = points[0]
    ranks = [
        rank_of(equations(p, base, normalising(p), normalising(base)))
        for p in points[1:]
    ]
    try:
        found = linear_cgsp(points, side=SIDE)
    except CalibrationError:
        return {"rank": min(ranks), "length_mm": None, "angle_rad": None}
    shifts = (found.T_base_grid - T_base_grid)[:, :3, 3]
    turns = angle_between_rotations(
        found.T_base_grid[:, :3, :3], T_base_grid[:, :3, :3]
    )
    off = np.linalg.norm([*shifts, found.centre - CENTRE_MM], axis=1)
    return {"rank": min(ranks), "length_mm": off.max(), "angle_rad": turns.max()}


@experiment("exp_c4_min_triplets", artefact="sec_4_1_2")
def ray_counts(effort):
    """Three and four rays, in scenes without noise."""
    return Plan(minimal_trial, crossed(rays=(3, 4)), TRIALS[effort], SETTINGS)


def homography_entries(parameters):
    """Both homographies, (18,), of centre, two rotation vectors, two shifts."""
    centre, first, second = np.split(parameters, [3, 9])
    x, y, z = centre
    M = np.array([[-z, 0.0, x], [0.0, -z, y], [0.0, 0.0, 1.0]])
    entries = []
    for grid in (first, second):
        T = pose(rotation_from_vector(grid[:3]), grid[3:])
        H = M @ (T[:3, [0, 1, 3]] - np.outer(centre, [0.0, 0.0, 1.0]))
        entries.append((H / np.linalg.norm(H)).ravel())
    return np.concatenate(entries)


def parameters_trial(condition, rng):
    """Rank of the derivatives of both homographies by all unknowns.

    Lengths are in units of the distance, so that all unknowns are of order one.
    """
    unit = CENTRE_MM[2]
    truth = [CENTRE_MM / unit]
    for T in draw_poses(rng)[1:]:
        truth += [rng.normal(size=3), T[:3, 3] / unit]
    truth = np.concatenate(truth)
    columns = [
        (homography_entries(truth + d) - homography_entries(truth - d)) / (2 * STEP)
        for d in STEP * np.eye(len(truth))
    ]
    values = np.linalg.svd(np.array(columns), compute_uv=False)
    return {
        "unknowns": len(truth),
        "determined": int(np.count_nonzero(values > 1e-5 * values[0])),
        "least": values[-1] / values[0],
    }


@experiment("sec_4_1_2_unknowns", artefact="sec_4_1_2")
def unknowns(effort):
    """Number of unknowns that two homographies determine."""
    return Plan(parameters_trial, [{}], TRIALS[effort], SETTINGS)


SHARE = 0.05


def spoil(points, share, rng):
    """Points with a share of random ones in the box of each grid, and their mask."""
    wrong = rng.random(points.shape[:2]) < share
    low, high = points.min(axis=1), points.max(axis=1)
    anywhere = rng.uniform(low[:, None], high[:, None], points.shape)
    return np.where(wrong[..., None], anywhere, points), wrong


def centre_and_solution(points, **options):
    """Distance (mm) of the estimated from the true centre, and the solution."""
    try:
        found = linear_cgsp(points, side=SIDE, **options)
    except CalibrationError:
        return None, None
    return float(np.linalg.norm(found.centre - CENTRE_MM)), found


PAIRS = 20_000
NOISE_PX = 0.5
PRECISION_TRIALS = {"quick": 3, "full": 50}


def homography_in(precision, source, target, normalised):
    """H (3, 3) by the SVD of all equations, in one precision throughout."""
    T_s = T_t = np.eye(3)
    if normalised:
        T_s, T_t = normalising(source), normalising(target)
    rows = equations(source, target, T_s, T_t).astype(precision)
    right = np.linalg.svd(rows, full_matrices=False)[2]
    H = right[8].reshape(3, 3).astype(float)
    return np.linalg.solve(T_t, H @ T_s)


def precision_trial(condition, rng):
    """RMS residuals (mm) of single and double precision, and true errors."""
    seen = draw_scene(radial_lens(), condition["noise_px"], rng, grids=2, rays=PAIRS)
    base, own = seen.noisy
    out = {}
    for name, precision in (("single", np.float32), ("double", np.float64)):
        H = homography_in(precision, own, base, condition["normalised"])
        gaps = apply_homography(H, own) - base
        true = apply_homography(H, seen.points[1]) - seen.points[0]
        for what, gap in (("residual", gaps), ("error", true)):
            out[f"{name}_{what}_mm"] = float(np.sqrt(np.mean(np.sum(gap**2, axis=1))))
    return out


@experiment("exp_c4_svd_precision", artefact="ext_svd_precision")
def precisions(effort):
    """20 000 pairs, exact and with noise, normalised and not."""
    conditions = crossed(noise_px=(NOISE_PX, 0.0), normalised=(True, False))
    settings = SETTINGS | {"rays_per_trial": PAIRS}
    return Plan(precision_trial, conditions, PRECISION_TRIALS[effort], settings)
