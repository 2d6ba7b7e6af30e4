"""Residuals of corrected chessboards, and the experiments of Figs 4.7 to 4.9."""

from functools import partial

import numpy as np

from chapters.ch04_central_generic.s3_3_correction.trials.calibrations import (
    ALL_SETS,
    METHODS,
    STEP,
    SWEPT_METHODS,
    calibrated,
    decoded_points,
)
from chapters.ch04_central_generic.s3_3_correction.trials.scenes import (
    lines_trial,
    pictures_trial,
)
from chapters.shared.bench_noise import BENCH, NOISES, SWEPT_NOISES
from chapters.shared.central_sets import GRID_SETS, RIGS, SEEDS, SMALL, grid_conditions
from chapters.shared.decoding_errors import DecodingErrors
from raxel.calibration.pose.grid_pose import synthetic_plane_normal
from raxel.calibration.views.boards import board_views
from raxel.evaluation.distortion import distortion_residual
from raxel.features.boards import detect_boards
from raxel.sets import load_set
from repro.run.experiment import experiment
from repro.run.outcomes import Plan
from repro.run.rendered import rendered_set

MIN_CORNERS = 12  # corners with a ray
COLUMNS_OF_SEAM = 2
QUINTILES = 5
FIELDS = ("x_mm", "y_mm", "dx_mm", "dy_mm", "angle_deg", "radial_mm", "seam")


def cut_across(directions):
    """Return crossings (N, 2) of rays with their perpendicular plane, and angles (N,).

    directions: (N, 3). The plane is at distance 1, with the normal of (4.24). NaN
    behind it.
    """
    normal = synthetic_plane_normal(directions)
    across = np.linalg.svd(normal[None])[2][1:]
    height = directions @ normal
    with np.errstate(divide="ignore", invalid="ignore"):
        points = directions @ across.T / height[:, None]
    points[height <= 0] = np.nan
    return points, np.arccos(np.clip(height, -1, 1))


def corner_residuals(found, lattice, view, scale):
    """Return rows FIELDS of a board's corners that have a ray, or None.

    view: BoardView, mm; scale: from its image's pixels to the calibration's.
    The homography maps the corrected view to the metric grid, so that residuals
    are in mm on the board.
    """
    places = lattice.places((view.pixels + 0.5) * scale - 0.5)
    rays = found.camera.rays(places)
    if np.count_nonzero(rays.valid) < MIN_CORNERS:
        return None
    metric = np.asarray(view.points, float)
    image, angle = cut_across(rays.directions[rays.valid])
    residual = distortion_residual(metric[rays.valid], image)
    outward = metric[rays.valid] - metric[rays.valid].mean(axis=0)
    length = np.linalg.norm(outward, axis=1)
    radial = np.sum(residual * outward, axis=1) / np.maximum(length, 1e-9)
    seam = beside_seam(found.sources, places, view)[rays.valid]
    return np.column_stack(
        [metric[rays.valid], residual, np.degrees(angle), radial, seam]
    )


def beside_seam(sources, places, view):
    """Return corners (N,) within two columns of one calibrated by other grids."""
    height, width = sources.shape
    u, v = np.round(places).astype(int).T
    bits = sources[np.clip(v, 0, height - 1), np.clip(u, 0, width - 1)]
    rows = bits.reshape(-1, view.columns)
    beside = np.zeros(rows.shape, bool)
    for shift in range(1, COLUMNS_OF_SEAM + 1):
        differs = rows[:, shift:] != rows[:, :-shift]
        beside[:, shift:] |= differs
        beside[:, :-shift] |= differs
    return beside.ravel()


def statistics(rows):
    """Return mean and SD of residual lengths, and the measures of the claims."""
    lengths = np.hypot(rows[:, 2], rows[:, 3])
    seam = rows[:, 6] > 0
    out = {
        "corners": len(rows),
        "mean_mm": lengths.mean(),
        "sd_mm": lengths.std(ddof=1),
        "radial_bias": radial_bias(rows, lengths),
        "skew_spearman": spearman(rows[:, 4], lengths),
        "corners_at_seams": int(np.count_nonzero(seam)),
    }
    if seam.any() and not seam.all():
        out["seam_ratio"] = lengths[seam].mean() / lengths[~seam].mean()
    return out


def radial_bias(rows, lengths):
    """Return the largest mean radial residual of a radius quintile, over the RMS."""
    radius = np.hypot(*(rows[:, :2] - rows[:, :2].mean(axis=0)).T)
    order = np.argsort(radius)
    means = [part.mean() for part in np.array_split(rows[order, 5], QUINTILES)]
    return float(np.max(np.abs(means)) / np.sqrt(np.mean(lengths**2)))


def spearman(a, b):
    """Return the rank correlation; ties are rare in measured numbers."""
    return float(np.corrcoef(*(np.argsort(np.argsort(v)) for v in (a, b)))[0, 1])


def seed_trial(condition, rng):
    """Return residuals of all boards of a rendered run, by method."""
    rig, seed = condition["rig"], condition["seed"]
    grids = rendered_set(rig, seed)
    boards = load_set(rendered_set(boards_of(rig), seed))
    scale = load_set(grids).width / boards.width
    noises = NOISES | SWEPT_NOISES
    lattice, points = decoded_points(grids, condition["step"], rng, noises)
    views = board_views(boards, detect_boards(boards))
    out = {"boards": len(boards.views), "boards_found": len(views)}
    for noise, seen in points.items():
        methods = SWEPT_METHODS if noise in SWEPT_NOISES else tuple(METHODS)
        found = calibrated(grids, lattice, seen, rng, methods)
        out[noise] = by_method(found, lattice, views, scale)
        if noise != BENCH:
            for method in out[noise].values():
                method.pop("field", None)  # one is drawn
    return out


def by_method(calibrations, lattice, views, scale):
    """Return residuals of all boards by each method with a calibration."""
    out = {}
    for method, found in calibrations.items():
        if isinstance(found, str):
            out[method] = {"failed": found}
            continue
        fields = (corner_residuals(found, lattice, v, scale) for v in views)
        kept = [rows for rows in fields if rows is not None]
        out[method] = {
            "boards": len(kept),
            "calibrated_share": float(np.mean(found.camera.mask)),
            **statistics(np.concatenate(kept)),
            "field": largest(kept),
        }
    return out


def boards_of(rig):
    """Return the rig that renders the boards for a rig that renders grids."""
    small = SMALL["quick"]
    return rig.removesuffix(small) + "-boards" + small * rig.endswith(small)


def largest(fields):
    """Return the board with most corners that have a ray, for Fig. 4.9."""
    return max(fields, key=len)


# Of the vectors of Fig. 4.9; at the thesis's factor of 15 they would be invisible.
MAGNIFIED = 40
LINES = {"quick": 2, "full": 50}
LINES_STEP = {"quick": 4, "full": 12}


@experiment("fig_4_9_boards", artefact="fig_4_9", rendered=ALL_SETS, shards={"full": 2})
def boards(effort):
    """Plan corrected chessboards of the rendered runs of both cameras."""
    cases = [case | {"step": STEP[effort]} for case in grid_conditions(effort)]
    return Plan(seed_trial, cases, 1, {"step_px": STEP[effort], "magnified": MAGNIFIED})


@experiment(
    "fig_4_7_pictures", artefact="fig_4_7", rendered=GRID_SETS, shards={"full": 2}
)
def pictures(effort):
    """Plan two frames of a room by each camera, original and corrected."""
    cases = [
        {"camera": camera, "rig": name + SMALL[effort], "step": STEP[effort]}
        for camera, name in RIGS.items()
    ]
    return Plan(pictures_trial, cases, 1, {"step_px": STEP[effort]})


@experiment(
    "fig_4_7_lines",
    artefact="fig_4_7",
    rendered=GRID_SETS,
    shards={"full": 2},
    needs=("table_4_3_errors",),
)
def lines(effort, results):
    """Plan redrawn calibrations of both cameras: edges and field of view."""
    step = LINES_STEP[effort]
    cases = [
        {
            "camera": camera,
            "rig": name + SMALL[effort],
            "seeds": list(SEEDS[effort]),
            "step": step,
        }
        for camera, name in RIGS.items()
    ]
    errors = DecodingErrors.by_rig(results["table_4_3_errors"])
    trial = partial(lines_trial, errors=errors)
    return Plan(trial, cases, LINES[effort], {"step_px": step})
