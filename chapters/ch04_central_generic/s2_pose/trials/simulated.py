"""The simulation of section 4.2.2: a further grid and known rays.

Planes tilted against that of (4.24), samples of three and four points, the number of
systems that a pose solves, and the case of Fig. 4.3.
"""

from contextlib import ExitStack, contextmanager
from unittest.mock import patch

import numpy as np

from chapters.ch04_central_generic.s2_pose.trials.estimators import (
    all_estimates,
    by_distances,
    errors_of,
    scored,
)
from chapters.shared.wide_angle import (
    CENTRE_MM,
    RADIUS_PX,
    SETTINGS,
    SIZE_PX,
    T_BASE_CAMERA,
    draw_poses,
    draw_scene,
    radial_lens,
)
from raxel.calibration.pose.grid_pose import (
    GRAZING,
    facing_plane_normal,
    linear_grid_pose,
    synthetic_plane_normal,
)
from raxel.calibration.pose.three_point import pose_of_triples, pose_three_point_ransac
from raxel.errors import CalibrationError
from raxel.geometry import inverse_pose, on_plane, pose, rotation_from_vector, transform
from repro.run.experiment import experiment, experiments
from repro.run.outcomes import Plan

LEVELS = (0.1, 0.25, 0.5, 1.0, 2.0)
DOMAINS = ("px", "mm")
RAYS = ("measured on the base grid", "exact")
POINTS = 999
# RANSAC's threshold in standard deviations of the noise of ray and point.
WIDE = 4 * np.sqrt(2)
SIZES = {
    "usual": {"grid_mm": 1200.0, "distance_mm": 600.0},
    "halved, doubled": {"grid_mm": 600.0, "distance_mm": 1200.0},
}
SIZE_NOISE = 0.5
TRIALS = {"quick": 5, "full": 100}


def normalised(vectors):
    """Return vectors (..., 3) of unit length."""
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def moved(T, shift):
    """Return a pose (4, 4) in a frame with another origin."""
    return pose(T[:3, :3], T[:3, 3] + shift)


# How RANSAC compares a ray and a point, by the question `pose_threshold`.
METRICS = {"length": "ray-point", "angle": "angle"}


def threshold(camera, noise, domain, unit):
    """Return RANSAC's threshold: a ray-point distance at 600 mm, or its angle."""
    away = np.linalg.norm(CENTRE_MM)
    length = WIDE * noise * (away / camera.K[0, 0] if domain == "px" else 1)
    return length if unit == "length" else length / away


def rays_and_points(scene, rays):
    """Return rays (N, 3) calibrated before, and their points on a grid.

    Frame: the base grid's axes, from the camera's centre.
    """
    if rays == "exact":
        return scene.directions, scene.noisy[1]
    return normalised(on_plane(scene.noisy[0]) - CENTRE_MM), scene.noisy[1]


def points_on_grid(T_camera_grid, half_mm, camera, noise, rng):
    """Return rays (N, 3) of noisy pixels and the points (N, 2) that they see."""
    points = np.empty((0, 2))
    while len(points) < POINTS:
        drawn = rng.uniform(-half_mm, half_mm, (2 * POINTS, 2))
        seen = camera.project(transform(T_camera_grid, on_plane(drawn)))
        middle = np.array([camera.width - 1, camera.height - 1]) / 2
        off = np.linalg.norm(seen.pixels - middle, axis=1)
        points = np.concatenate([points, drawn[off <= RADIUS_PX]])
    points = points[:POINTS]
    pixels = camera.project(transform(T_camera_grid, on_plane(points))).pixels
    noisy = pixels + noise * rng.standard_normal(pixels.shape)
    return camera.rays(noisy).directions, points


def size_trial(condition, rng):
    """Return errors on a grid, and on one half as large at twice the distance."""
    camera = radial_lens()
    T = draw_poses(rng, 2)[1]
    out = {}
    for name, size in SIZES.items():
        ahead = T_BASE_CAMERA.copy()
        ahead[2, 3] = size["distance_mm"]
        T_camera_grid = inverse_pose(ahead) @ T
        directions, points = points_on_grid(
            T_camera_grid, size["grid_mm"] / 2, camera, SIZE_NOISE, rng
        )
        mm_per_px = size["distance_mm"] / camera.K[0, 0]
        found = all_estimates(directions, points, rng, WIDE * SIZE_NOISE * mm_per_px)
        out[name] = {
            estimator: scored(pose, T_camera_grid) for estimator, pose in found.items()
        }
    return out


@experiment("exp_c4_real_larger", artefact="fig_4_4")
def real_larger(effort):
    """Plan grids as simulated, and half as large at twice the distance."""
    settings = {"sizes": SIZES, "noise_px": SIZE_NOISE, "points": POINTS}
    return Plan(size_trial, [{}], TRIALS[effort], settings)


TILTS_DEG = (0, 15, 30, 45, 60)
NOISE_PX = 0.5
PLANE_TRIALS = {"quick": 5, "full": 100}


def tilted(normal, rng):
    """Return normals (tilts, 3), rotated from one about a random axis."""
    axis = normalised(np.cross(normal, rng.standard_normal(3)))
    return rotation_from_vector(np.radians(TILTS_DEG)[:, None] * axis) @ normal


def plane_trial(condition, rng):
    """Return errors of the linear pose on planes of every tilt, one scene.

    `common`: with the rays that all planes see; `own`: with those that each
    plane sees.
    """
    scene = draw_scene(radial_lens(), condition["noise"], rng, grids=2)
    directions, points = rays_and_points(scene, "measured on the base grid")
    true = moved(scene.T_base_grid[1], -CENTRE_MM)
    normals = tilted(synthetic_plane_normal(directions), rng)
    seen = (directions @ normals.T > GRAZING).all(axis=1)
    out = {"share_common": np.mean(seen)}
    for kind, used in (("common", seen), ("own", np.ones_like(seen))):
        for tilt, normal in zip(TILTS_DEG, normals, strict=True):
            found = linear_grid_pose(directions[used], points[used], normal=normal)
            out.setdefault(kind, {})[str(tilt)] = errors_of(
                found.T_camera_grid, true
            ) | {"left_out": found.behind / len(directions)}
    return out


@experiments({"exp_c4_plane_orientation": "fig_4_3", "exp_c4_plane_free": "fig_4_3"})
def plane_orientation(effort, identifier):
    """Plan pose errors on planes tilted against that of (4.24)."""
    noise = 0.0 if identifier == "exp_c4_plane_free" else NOISE_PX
    settings = SETTINGS | {"tilts_deg": TILTS_DEG}
    return Plan(plane_trial, [{"noise": noise}], PLANE_TRIALS[effort], settings)


SCENES = {"quick": 5, "full": 100}
DRAWS = 100  # samples of every kind in one scene
MEASURES = ("rotation_deg", "translation_mm")
# Distance of every pair in the image, shares of the width of the view.
APART = {
    "any three points": (0.0, np.inf),
    "close together": (0.0, 0.1),
    "far apart": (0.5, np.inf),
}


def draw_triples(pixels, kind, rng):
    """Return indices (DRAWS, 3) of points with pixel distances of one kind."""
    low, high = (share * SIZE_PX for share in APART[kind])
    found = np.empty((0, 3), int)
    while len(found) < DRAWS:
        first = rng.integers(0, len(pixels), 200)
        gap = np.linalg.norm(pixels[first, None] - pixels, axis=2)
        near = (gap >= low) & (gap <= high) & (gap > 0)
        # Two more at the required distance from the first.
        chance = np.where(near, rng.random(gap.shape), -1.0)
        others = np.argsort(-chance, axis=1)[:, :2]
        picks = np.column_stack([first, others])
        between = np.linalg.norm(pixels[others[:, 0]] - pixels[others[:, 1]], axis=1)
        enough = np.take_along_axis(near, others, axis=1).all(axis=1)
        good = enough & (between >= low) & (between <= high)
        found = np.concatenate([found, picks[good]])
    return found[:DRAWS]


def further_grid(rng):
    """Return rays, points, true pose and pixels of one noisy scene."""
    scene = draw_scene(radial_lens(), NOISE_PX, rng, grids=2)
    rays, points = rays_and_points(scene, "measured on the base grid")
    return rays, points, moved(scene.T_base_grid[1], -CENTRE_MM), scene.pixels


def count_trial(condition, rng):
    """Return the number of triples of every kind without a pose, one scene."""
    rays, points, _, pixels = further_grid(rng)
    out = {}
    for kind in APART:
        picks = draw_triples(pixels, kind, rng)
        _, triple = pose_of_triples(rays[picks], points[picks])
        out[kind] = {"without": int(DRAWS - len(np.unique(triple)))}
    return out


def error_trial(condition, rng):
    """Return errors of the poses of triples of every kind, medians in one scene.

    Either error is the smallest of a triple's solutions; triples without a solution
    count as the worst.
    """
    rays, points, true, pixels = further_grid(rng)
    out = {}
    for kind in APART:
        picks = draw_triples(pixels, kind, rng)
        poses, triple = pose_of_triples(rays[picks], points[picks])
        best = {name: np.full(DRAWS, np.inf) for name in MEASURES}
        for T, k in zip(poses, triple, strict=True):
            for name, error in errors_of(T, true).items():
                best[name][k] = min(best[name][k], error)
        out[kind] = {name: np.median(found) for name, found in best.items()}
    return out


def four_trial(condition, rng):
    """Return how many samples of four points of one scene give a finite pose.

    For the plane of (4.24) and for one that all four rays meet, with the medians of
    the latter's errors.
    """
    rays, points, true, _ = further_grid(rng)
    planes = {"of_4_24": synthetic_plane_normal, "facing": facing_plane_normal}
    finite = dict.fromkeys(planes, 0)
    errors = {name: [] for name in MEASURES}
    for _ in range(DRAWS):
        picks = rng.choice(len(points), 4, replace=False)
        for name, normal in planes.items():
            try:
                found = linear_grid_pose(
                    rays[picks], points[picks], normal=normal(rays[picks])
                )
            except CalibrationError:
                continue
            finite[name] += bool(np.isfinite(found.T_camera_grid).all())
            if name == "facing":
                for measure, error in errors_of(found.T_camera_grid, true).items():
                    errors[measure].append(error)
    return {"finite": finite} | {name: np.median(e) for name, e in errors.items()}


SETTINGS_HERE = SETTINGS | {
    "noise_px": NOISE_PX,
    "samples_per_scene": DRAWS,
    "close_share": APART["close together"][1],
    "far_share": APART["far apart"][0],
}


@experiment("exp_c4_3pt_sensitive", artefact="sec_4_2")
def sensitive(effort):
    """Plan errors of three points close together and far apart."""
    return Plan(error_trial, [{}], SCENES[effort], SETTINGS_HERE)


@experiment("exp_c4_3pt_no_solution", artefact="sec_4_2")
def no_solution(effort):
    """Plan how often three noisy points have no pose."""
    return Plan(count_trial, [{}], SCENES[effort], SETTINGS_HERE)


@experiment("exp_c4_linear_always", artefact="sec_4_2")
def linear_always(effort):
    """Plan how often four noisy points have a linear pose."""
    return Plan(four_trial, [{}], SCENES[effort], SETTINGS_HERE)


COUNTED_POINTS = (100, 999)
SOLVERS = ("eigh", "eigvals", "inv", "lstsq", "qr", "solve", "svd")
METRIC = "ray-point"


@contextmanager
def counted():
    """Yield a list that collects (solver, shape) of all systems that numpy solves.

    The shape is that of the matrices: (rows, columns), or (stack, rows, columns).
    """
    solved = []

    def noting(name):
        solver = getattr(np.linalg, name)

        def solve(matrices, *given, **named):
            solved.append((name, np.shape(matrices)))
            return solver(matrices, *given, **named)

        return solve

    with ExitStack() as stack:
        for name in SOLVERS:
            stack.enter_context(patch.object(np.linalg, name, noting(name)))
        yield solved


def solves_trial(condition, rng):
    """Return the systems that the linear and the standard pose solve in one scene.

    linear.calls: all calls of solvers; linear.systems: those on a matrix with a row for
    each point. three_points.polynomials: of RANSAC's samples. refined.systems: steps of
    the refinement, each of which solves the normal equations (6, 6) of all points.
    """
    count = condition["points"]
    rays, points, _, _ = further_grid(rng)
    given = rays[:count], points[:count]
    limit = threshold(radial_lens(), NOISE_PX, "px", "length")
    with counted() as linear:
        linear_grid_pose(*given)
    with counted() as sampled:
        found = pose_three_point_ransac(*given, rng, limit, metric=METRIC)
    with counted() as refined:
        by_distances(*given, found, limit, METRIC)
    return {
        "linear": {
            "calls": len(linear),
            "systems": sum(shape[-2] >= count for _, shape in linear),
        },
        "three_points": {
            "polynomials": sum(
                int(np.prod(shape[:-2])) for name, shape in sampled if name == "eigvals"
            )
        },
        "refined": {"systems": refined.count(("solve", (6, 6)))},
    }


@experiment("exp_c4_pose_linear_fast", artefact="sec_4_2")
def pose_solves(effort):
    """Plan the systems that both poses solve, with few and many points."""
    conditions = [{"points": count} for count in COUNTED_POINTS]
    return Plan(
        solves_trial, conditions, SCENES[effort], SETTINGS | {"noise_px": NOISE_PX}
    )


COLUMNS, ROWS, PITCH_MM = 5, 4, 60.0
SHIFT_MM = (330.0, 60.0, -40.0)
TURN_DEG = (20.0, -25.0, 10.0)
PLANE_MM = 260.0  # from the centre to the synthetic plane


def lattice():
    """Return points (N, 2) of the drawn grid, centred at the origin."""
    x = PITCH_MM * (np.arange(COLUMNS) - (COLUMNS - 1) / 2)
    y = PITCH_MM * (np.arange(ROWS) - (ROWS - 1) / 2)
    return np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)


def case_trial(condition, rng):
    """Return points, rays, synthetic plane, image and pose of one case."""
    true = pose(rotation_from_vector(np.radians(TURN_DEG)), SHIFT_MM)
    points = lattice()
    there = transform(true, on_plane(points))
    rays = normalised(there - CENTRE_MM)
    normal = synthetic_plane_normal(rays)
    image = CENTRE_MM + PLANE_MM * rays / (rays @ normal)[:, None]
    found = linear_grid_pose(rays, points, normal=normal).T_camera_grid
    return {
        "there": there,
        "rays": rays,
        "normal": normal,
        "image": image,
        "true": true,
        "found": moved(found, CENTRE_MM),
    }


@experiment("fig_4_3_case", artefact="fig_4_3")
def drawn_case(effort):
    """Plan one grid, its image on the synthetic plane, and its pose."""
    return Plan(case_trial, [{}], 1, {"shift_mm": SHIFT_MM, "turn_deg": TURN_DEG})
