"""Table 4.1: two poses of an active grid and a calibrated perspective camera."""

from functools import partial

import numpy as np

from chapters.ch04_central_generic.s2_pose.trials.estimators import (
    all_estimates,
    scored,
)
from chapters.shared.active_grid_sets import seen_grids, true_camera
from chapters.shared.bench_noise import NOISES, SWEPT_NOISES
from chapters.shared.decoding_errors import (
    DecodingErrors,
    drawn_lattices,
    lattice_rays,
    measured_errors,
    true_lattice,
)
from chapters.shared.rigs import rig_named
from raxel.calibration.parametric.zhang import calibrate_zhang
from raxel.calibration.views.boards import board_views
from raxel.cameras import PerspectiveCamera
from raxel.features.boards import detect_boards
from raxel.geometry import fit_pose, inverse_pose, on_plane, transform
from raxel.sets import load_set
from repro.run.experiment import experiment
from repro.run.outcomes import Plan, crossed
from repro.run.rendered import rendered_set

GRID = {"quick": "kodak-megaplus-small", "full": "kodak-megaplus"}
BOARDS = {"quick": "kodak-boards-small", "full": "kodak-boards"}
SEEDS = {"quick": (0,), "full": (0, 1, 2)}
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
SETTINGS = {
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
    for grid in seen_grids(folder, threads=1):
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
def rendered_seeds(effort):
    """Plan rendered runs, from images to errors."""
    conditions = crossed(
        grid=[GRID[effort]], boards=[BOARDS[effort]], seed=SEEDS[effort]
    )
    return Plan(rendered_trial, conditions, 1, SETTINGS)


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


def measured_seeds(results, effort):
    """Return (calibrated camera, decoding errors) of every rendered run."""
    rendered = results["table_4_1_rendered"]
    rig = rig_named(GRID[effort])
    seeds = []
    for seed in SEEDS[effort]:
        trials = rendered.select(seed=seed)
        K, radial = (trials.arrays(f"zhang.{name}")[0] for name in ("K", "radial"))
        camera = PerspectiveCamera(K, radial, rig.camera.width, rig.camera.height)
        seeds.append((camera, DecodingErrors.read(trials, "decoding.")))
    return seeds


@experiment(
    "table_4_1_redrawn",
    artefact="table_4_1",
    shards={"full": 2},
    inputs=KODAK_RIGS,
    needs=("table_4_1_rendered",),
)
def redrawn_seeds(effort, results):
    """Plan scenes with the decoding errors of the rendered ones."""
    trial = partial(
        redrawn_trial, rig_name=GRID[effort], seeds=measured_seeds(results, effort)
    )
    return Plan(trial, [{}], SCENES[effort], SETTINGS)
