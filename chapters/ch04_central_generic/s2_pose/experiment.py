"""Trials of this page, their conditions and constants."""

from contextlib import ExitStack, contextmanager
from functools import partial
from unittest.mock import patch

import numpy as np

from chapters.shared.central import (
    CENTRE_MM,
    NOISES,
    RADIUS_PX,
    SETTINGS,
    SIZE_PX,
    SWEPT_NOISES,
    T_BASE_CAMERA,
    DecodingErrors,
    draw_poses,
    draw_scene,
    drawn_lattices,
    lattice_rays,
    measured_errors,
    radial_lens,
    scored_grids,
    true_camera,
    true_lattice,
)
from chapters.shared.rigs import rig_named
from raxel.calibration import (
    MIN_INCIDENCE_COSINE,
    board_views,
    calibrate_zhang,
    facing_plane_normal,
    grid_pose_ransac,
    linear_grid_pose,
    pose_of_triples,
    pose_three_point_ransac,
    ray_errors,
    refine_pose_angular,
    refine_pose_ray_point,
    synthetic_plane_normal,
)
from raxel.cameras import PerspectiveCamera
from raxel.errors import CalibrationError
from raxel.features import detect_boards
from raxel.geometry import (
    angle_between_rotations,
    fit_pose,
    inverse_pose,
    on_plane,
    rotation_from_vector,
    transform,
)
from raxel.geometry import pose as pose_matrix
from raxel.sets import load_set
from repro.run import Plan, crossed, experiment, experiments
from repro.run.rendered import rendered_set

# The pose estimators that 4.2 compares, on one set of rays and points.


ROUNDS = 20  # of re-estimation, as in `raxel.geometry.homography`
ESTIMATORS = ("three_points", "standard", "cgsp", "cgsp_ransac", "angular")
NAMES = {
    "three_points": "three points + RANSAC",
    "standard": "standard + RANSAC",
    "cgsp": "CGSP",
    "cgsp_ransac": "CGSP + RANSAC",
    "angular": "CGSP + RANSAC, angles refined",
}
# The standard method's pose by the question `standard_pose`.
STANDARD = {"refined": "standard", "as it comes out": "three_points"}


def all_estimates(directions, points, rng, threshold, metric="ray-point"):
    """Return {estimator: pose (4, 4), or the code of its error}.

    directions: (N, 3) rays of one origin; points: (N, 2); threshold: of both
    kinds of RANSAC, mm for metric "ray-point", radians for "angle". Refined
    estimators start from the unrefined ones.
    """
    given = directions, points
    ransac = *given, rng, threshold
    chains = (
        (
            ("three_points", "standard"),
            lambda: pose_three_point_ransac(*ransac, metric=metric),
            lambda found: by_distances(*given, found, threshold, metric),
        ),
        (("cgsp",), lambda: linear_grid_pose(*given)),
        (
            ("cgsp_ransac", "angular"),
            lambda: grid_pose_ransac(*ransac, metric=metric),
            lambda found: by_angles(*given, found),
        ),
    )
    out = {}
    for names, *steps in chains:
        found = None
        for name, step in zip(names, steps, strict=True):
            try:
                found = step() if found is None else step(found)
            except CalibrationError as error:
                out |= dict.fromkeys(names[names.index(name) :], error.code)
                break
            out[name] = found.T_camera_grid
    return out


def by_distances(directions, points, found, threshold, metric):
    """Return a pose with the ray-point distances (4.18) of its inliers minimised.

    Repeats until the inliers no longer change, as the linear re-estimation does.
    """
    T, right = found.T_camera_grid, found.inliers
    for _ in range(ROUNDS):
        T, _ = refine_pose_ray_point(directions[right], points[right], T)
        p = points @ T[:3, :2].T + T[:3, 3]
        now = ray_errors(directions, p[None], metric)[0] < threshold
        if np.array_equal(now, right) or np.count_nonzero(now) < 4:
            break
        right = now
    return found._replace(T_camera_grid=T, inliers=right)


def by_angles(directions, points, found):
    """Return a pose with the angles to its inliers minimised."""
    right = found.inliers
    return refine_pose_angular(directions[right], points[right], found.T_camera_grid)


def scored(found, true):
    """Return errors of a pose, or the reason why it is missing."""
    if isinstance(found, str):
        return {"failed": found}
    return errors_of(found, true)


def errors_of(found, true):
    """Return the angle of R_true^-1 R (deg) and the translation error (mm)."""
    turn = angle_between_rotations(true[:3, :3], found[:3, :3])
    return {
        "rotation_deg": np.degrees(turn),
        "translation_mm": np.linalg.norm(found[:3, 3] - true[:3, 3]),
    }


# Table 4.1: two poses of an active grid and a calibrated perspective camera.


GRID = {"quick": "kodak-megaplus-small", "full": "kodak-megaplus"}
BOARDS = {"quick": "kodak-boards-small", "full": "kodak-boards"}
RUNS = {"quick": (0,), "full": (0, 1, 2)}
KODAK_SETS = {
    "quick": ("kodak-megaplus-small/0", "kodak-boards-small/0"),
    "full": (
        "kodak-megaplus/0",
        "kodak-megaplus/1",
        "kodak-megaplus/2",
        "kodak-boards/0",
        "kodak-boards/1",
        "kodak-boards/2",
    ),
}
KODAK_RIGS = ("data/rigs/kodak-megaplus.yaml", "data/rigs/kodak-megaplus-small.yaml")
SCENES = {"quick": 4, "full": 60}
PAIRS = 20_000
ADDED_OUTLIERS = "0.3 %"
TABULATED = ("bench", "laboratory")  # noise levels
OUTLIERS = {"as decoded": 0.0, ADDED_OUTLIERS: 0.003}
THRESHOLD_MM = 1.0
SCANNED_MM, SCAN_SD_MM = 40.0, 0.1
STEP = 5  # px between neighbours of the lattice of redrawn scenes
PERIODS = 8, 8  # of the sines, across the monitor
KODAK_SETTINGS = {
    "pairs_per_pose": PAIRS,
    "outliers_put_in": OUTLIERS,
    "ransac_threshold_mm": THRESHOLD_MM,
    "scan_sd_mm": SCAN_SD_MM,
}


def with_outliers(points, share, size_mm, rng):
    """Return points (N, 2), a share of them moved anywhere on the monitor."""
    count = round(share * len(points))
    wrong = rng.choice(len(points), count, replace=False)
    points = points.copy()
    points[wrong] = rng.uniform(0, 1, (count, 2)) * size_mm
    return points


def scanned(T, size_mm, rng):
    """Return the pose of a monitor at T as measured by a laser scanner."""
    x, y = (np.arange(SCANNED_MM / 2, s, SCANNED_MM) for s in size_mm)
    flat = on_plane(np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2))
    noise = SCAN_SD_MM * rng.standard_normal(flat.shape)
    return fit_pose(flat, transform(T, flat) + noise)


def errors_at_noises(camera, decoded, true_points, true, step, size_mm, rng):
    """Return {noise: `relative_errors`} at all noise levels.

    decoded, true_points: (2, h, w, 2) mm, of every step-th pixel in both directions;
    true: (2, 4, 4) T_camera_grid. Levels used only by claims have their outliers alone.
    """
    out = {}
    for name, noise in (NOISES | SWEPT_NOISES).items():
        seen = noise.points(decoded, true_points, rng)
        pairs = [chosen_pairs(camera, location, step, rng) for location in seen]
        outliers = OUTLIERS if name in TABULATED else [ADDED_OUTLIERS]
        out[name] = relative_errors(pairs, true, size_mm, rng, outliers)
    return out


def relative_errors(pairs, true, size_mm, rng, outliers=tuple(OUTLIERS)):
    """Return errors of the second pose relative to the first, by every estimator.

    pairs: ((rays (N, 3), points (N, 2)), ...) of both poses; true: (2, 4, 4);
    outliers: which of OUTLIERS.
    """
    first, second = (scanned(T, size_mm, rng) for T in true)
    truth = inverse_pose(first) @ second
    out = {}
    for kind in outliers:
        share = OUTLIERS[kind]
        found = [
            all_estimates(
                rays, with_outliers(points, share, size_mm, rng), rng, THRESHOLD_MM
            )
            for rays, points in pairs
        ]
        out[kind] = {
            name: relative(*(f[name] for f in found), truth) for name in found[0]
        }
    return out


def relative(first, second, truth):
    """Return errors of a pair of poses, or the reason why one is missing."""
    missing = [pose for pose in (first, second) if isinstance(pose, str)]
    return scored(missing[0] if missing else inverse_pose(first) @ second, truth)


def calibrated_camera(rig, seed):
    """Return Zhang's calibration from the rendered boards of one run."""
    boards = load_set(rendered_set(rig, seed))
    found = detect_boards(boards, say=lambda line: None)
    return calibrate_zhang(board_views(boards, found), boards.width, boards.height)


def rendered_trial(condition, rng):
    """Return the errors of a rendered run, and statistics of its decoding."""
    calibration = calibrated_camera(condition["boards"], condition["seed"])
    camera = calibration.camera
    folder = rendered_set(condition["grid"], condition["seed"])
    size_mm = np.array(load_set(folder).target.monitor_mm)
    seen = []
    every, shape = lattice_rays(true_camera(folder), 1)
    for grid in scored_grids(folder, threads=1):
        _, cosine = true_lattice(every, shape, grid.T_camera_grid, size_mm)
        seen.append((grid, cosine))
    true = np.stack([grid.T_camera_grid for grid, _ in seen])
    errors = measured_errors(seen, PERIODS, size_mm)
    found = [np.isfinite(g.decoded.location[..., 0]).sum() for g, _ in seen]
    locations = np.stack([grid.decoded.location for grid, _ in seen]).astype(float)
    true_points = np.stack([grid.points for grid, _ in seen])
    return {
        "errors": errors_at_noises(
            camera, locations, true_points, true, 1, size_mm, rng
        ),
        "decoding": errors._asdict(),
        "pixels": np.mean(found),
        "zhang": {
            "K": camera.K,
            "radial": np.asarray(camera.radial),
            "rms_px": calibration.rms_px,
        },
    }


def chosen_pairs(camera, location, step, rng):
    """Return (rays (N, 3), points (N, 2)) of up to PAIRS pixels that have a point.

    location: (h, w, 2), of every step-th pixel in both directions (`lattice_rays`).
    """
    v, u = np.nonzero(np.isfinite(location).all(axis=2))
    keep = rng.permutation(len(u))[:PAIRS]
    v, u = v[keep], u[keep]
    pixels = step * np.column_stack([u, v]).astype(float) + step // 2
    return camera.rays(pixels).directions, location[v, u]


@experiment("table_4_1_rendered", artefact="table_4_1", rendered=KODAK_SETS)
def rendered_runs(effort):
    """Plan rendered runs, from images to errors."""
    conditions = crossed(
        grid=[GRID[effort]], boards=[BOARDS[effort]], seed=RUNS[effort]
    )
    return Plan(rendered_trial, conditions, 1, KODAK_SETTINGS)


def redrawn_trial(condition, rng, rig_name, seeds):
    """Return the errors of a scene with the decoding errors of a rendered run."""
    rig = rig_named(rig_name)
    camera, errors = seeds[rng.integers(len(seeds))]
    size_mm = np.array(rig.target.monitor_mm)
    true = rig.draw_poses(rng, 2)
    step = 1 if rig.camera.width * rig.camera.height < 4 * PAIRS else STEP
    rays, shape = lattice_rays(rig.camera, step)
    true_points, decoded = drawn_lattices(rays, shape, true, size_mm, step, rng, errors)
    found = errors_at_noises(camera, decoded, true_points, true, step, size_mm, rng)
    return {"errors": found}


def measured_runs(results, effort):
    """Return (calibrated camera, decoding errors) of every rendered run."""
    rendered = results["table_4_1_rendered"]
    rig = rig_named(GRID[effort])
    seeds = []
    for seed in RUNS[effort]:
        trials = rendered.select(seed=seed)
        K, radial = (trials.arrays(f"zhang.{name}")[0] for name in ("K", "radial"))
        camera = PerspectiveCamera(K, radial, rig.camera.width, rig.camera.height)
        seeds.append((camera, DecodingErrors.read(trials, "decoding.")))
    return seeds


@experiment(
    "table_4_1_redrawn",
    artefact="table_4_1",
    inputs=KODAK_RIGS,
    needs=("table_4_1_rendered",),
)
def redrawn_runs(effort, results):
    """Plan scenes with the decoding errors of the rendered ones."""
    trial = partial(
        redrawn_trial, rig_name=GRID[effort], seeds=measured_runs(results, effort)
    )
    return Plan(trial, [{}], SCENES[effort], KODAK_SETTINGS)


# The simulation of section 4.2.2: a further grid and known rays.
#
# Planes tilted against that of (4.24), samples of three and four points, the number of
# systems that a pose solves, and the case of Fig. 4.3.


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
    return pose_matrix(T[:3, :3], T[:3, 3] + shift)


# How RANSAC compares a ray and a point, by the question `pose_threshold`.
METRICS = {"length": "ray-point", "angle": "angle"}


def ransac_threshold(camera, noise, domain, unit):
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
    seen = (directions @ normals.T > MIN_INCIDENCE_COSINE).all(axis=1)
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


SIMULATED_SCENES = {"quick": 5, "full": 100}
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
    return Plan(error_trial, [{}], SIMULATED_SCENES[effort], SETTINGS_HERE)


@experiment("exp_c4_3pt_no_solution", artefact="sec_4_2")
def no_solution(effort):
    """Plan how often three noisy points have no pose."""
    return Plan(count_trial, [{}], SIMULATED_SCENES[effort], SETTINGS_HERE)


@experiment("exp_c4_linear_always", artefact="sec_4_2")
def linear_always(effort):
    """Plan how often four noisy points have a linear pose."""
    return Plan(four_trial, [{}], SIMULATED_SCENES[effort], SETTINGS_HERE)


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
    limit = ransac_threshold(radial_lens(), NOISE_PX, "px", "length")
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
        solves_trial,
        conditions,
        SIMULATED_SCENES[effort],
        SETTINGS | {"noise_px": NOISE_PX},
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
    true = pose_matrix(rotation_from_vector(np.radians(TURN_DEG)), SHIFT_MM)
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
