"""Section 4.3.2: new grid poses, calibrations from them, and their limits.

Each run is calibrated at the low-noise and at the thesis-matched level. The factor of
the latter is solved from runs of CGSP alone and one printed number (settings.yaml,
decoding_noise).
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np

from chapters.shared.central import (
    LINEAR_GRIDS,
    MATCHED,
    NOISES,
    OMNI,
    RIGS,
    RUNS,
    SMALL,
    SWEPT_NOISES,
    best_lines,
    calibrated,
    crossings,
    drawn_lattices,
    first_points,
    first_points_and_truth,
    lattice_rays,
    measured_errors,
    parameters,
    scatter_of,
    scored_grids,
    shared_rays,
    true_camera,
    true_grids,
    true_grids_of_set,
)
from chapters.shared.methods import LINEAR_STAGES
from chapters.shared.rigs import rig_named
from raxel.calibration import centroid_directions, linear_cgsp, ray_point_distances
from raxel.errors import CalibrationError
from raxel.geometry import on_plane, transform
from repro.run.rendered import rendered_set

# px between the rays of a trial: some thousand of them meet all three grids.
STEPS = {"quick": 4, "full": 9}


class DrawnGrids(NamedTuple):
    """Three grids, and the points where the rays of a pixel lattice meet them.

    true, decoded: (3, N, 2) mm, NaN outside a grid; pixels: (N, 2); T_camera_grid:
    (3, 4, 4).
    """

    true: np.ndarray
    decoded: np.ndarray
    pixels: np.ndarray
    T_camera_grid: np.ndarray


@cache
def _rays_of(rig, step):
    camera = rig_named(rig).camera
    return camera, *lattice_rays(camera, step)


def drawn_grids(rig, step, rng, errors=None):
    """Return the DrawnGrids of a rig, with `DecodingErrors` or exact."""
    camera, rays, shape = _rays_of(rig, step)
    setup = rig_named(rig)
    poses = setup.draw_poses(rng, LINEAR_GRIDS)
    true, decoded = (
        points.reshape(len(poses), -1, 2)
        for points in drawn_lattices(
            rays, shape, poses, setup.target.monitor_mm, step, rng, errors
        )
    )
    v, u = np.mgrid[step // 2 : camera.height : step, step // 2 : camera.width : step]
    pixels = np.column_stack([u.ravel(), v.ravel()]).astype(float)
    return DrawnGrids(true, decoded, pixels, poses)


TRIALS = {"quick": 3, "full": 50}
N_DRAWN = 3000  # points of a scatter in Fig. 4.6
# The sweep of the factor is run for the primary interpretations.
SWEPT_METHODS = ("as_printed", "cgsp")


def rendered_trial(condition, rng):
    """Decode and calibrate a rendered set by each method, and add the true values."""
    folder = rendered_set(condition["rig"], condition["seed"])
    decoded, true_points = first_points_and_truth(folder)
    width = true_camera(folder).width
    out = {}
    for name, noise in NOISES.items():
        points = noise.points(decoded, true_points, rng)
        rays = shared_rays(points, width, rng)
        true = true_grids_of_set(folder, rays.pixels)
        found = calibrated(rays.points, true)
        for method in found.values():
            crossing = method.pop("crossing", None)
            if crossing is not None and name == MATCHED:
                method["crossing"] = crossing[:: max(1, len(crossing) // N_DRAWN)]
        out[name] = found | _of_rays(rays, true)
    return out


def _of_rays(rays, true):
    """Return the numbers of rays and their true parameters."""
    return {
        "true": parameters(true.centre, true.T_base_grid),
        "true_scatter_mm": true.scatter_mm,
        "rays": rays.found,
        "used": len(rays.pixels),
        "left_out": rays.left_out,
    }


def errors_trial(condition, rng):
    """Return the DecodingErrors of all rendered sets of a rig, as arrays."""
    folders = [rendered_set(condition["rig"], seed) for seed in condition["seeds"]]
    rays, shape = lattice_rays(true_camera(folders[0]), 1)
    found = measured_errors(
        (grid, (rays.directions @ grid.T_camera_grid[:3, 2]).reshape(shape))
        for folder in folders
        for grid in scored_grids(folder, count=LINEAR_GRIDS)
    )
    return {name: np.asarray(value) for name, value in found._asdict().items()} | {
        "share_of_outliers": found.outlier_share,
        "correlation": float(found.correlation_px.mean()),
        "stated_x": float(found.stated[0]),
        "stated_y": float(found.stated[1]),
        "bias_mm_rms": float(np.sqrt(np.mean(found.bias_mm**2))),
        "sd_mm_rms": float(np.sqrt(np.mean(found.sd_mm**2))),
    }


def errors_conditions(effort):
    """Return a condition for each rig whose errors are measured."""
    rigs = [rig + SMALL[effort] for rig in RIGS.values()]
    return [{"rig": rig, "seeds": list(RUNS[effort])} for rig in rigs]


def redrawn_trial(condition, rng, errors):
    """Calibrate new grid poses with redrawn decoding errors, as `rendered_trial`.

    The errors are drawn once, and scaled for the thesis-matched level.
    """
    rig = condition["rig"]
    grids = drawn_grids(rig, condition["step"], rng, errors[rig])
    out = {}
    for name, noise in (NOISES | SWEPT_NOISES).items():
        methods = SWEPT_METHODS if name in SWEPT_NOISES else LINEAR_STAGES
        rays = shared_rays(noise.points(grids.decoded, grids.true, rng), 1, rng)
        chosen = grids.pixels[rays.pixels[:, 1].astype(int)]
        true = true_grids(rig_named(rig).camera, grids.T_camera_grid, chosen)
        found = calibrated(rays.points, true, methods=tuple(methods))
        for method in found.values():
            method.pop("crossing", None)  # Fig. 4.6 shows rendered sets only
        out[name] = found | _of_rays(rays, true)
    return out


def redrawn_conditions(effort):
    """Return a condition for each camera."""
    return [
        {"camera": camera, "rig": rig + SMALL[effort], "step": STEPS[effort]}
        for camera, rig in RIGS.items()
    ]


FACTOR_RUNS = {"quick": 3, "full": 36}
MULTIPLIED = (1.0, 2.0, 4.0, 8.0)


def cgsp_trial(condition, rng, errors):
    """Return the mean ray-point error (mm) of unadjusted CGSP.

    mean_mm: for each of MULTIPLIED; chosen_mm: for the solved factor.
    """
    rig, noise = condition["rig"], NOISES[condition["noise"]]
    grids = drawn_grids(rig, condition["step"], rng, errors[rig])

    def mean(factor):
        errors_times = noise._replace(factor=factor)
        return mean_error(errors_times.points(grids.decoded, grids.true, rng), rng)

    return {
        "mean_mm": np.array([mean(factor) for factor in MULTIPLIED]),
        "chosen_mm": mean(noise.factor),
    }


def mean_error(points, rng):
    """Return the mean ray-point error of points (3, N, 2); NaN if CGSP fails."""
    try:
        rays = shared_rays(points, 1, rng)
        found = linear_cgsp(rays.points, side=-1)
    except CalibrationError:
        return np.nan
    seen = np.ones(rays.points.shape[:2], bool)
    directions = centroid_directions(rays.points, seen, found.centre, found.T_base_grid)
    placed = transform(found.T_base_grid, on_plane(rays.points))
    return ray_point_distances(placed, found.centre, directions).mean()


def cgsp_conditions(effort):
    """Return conditions of the mirror camera, with errors as decoded and white."""
    rig, step = RIGS[OMNI] + SMALL[effort], STEPS[effort]
    return [{"rig": rig, "step": step, "noise": noise} for noise in ("bench", "white")]


def solved(result, target_mm, noise):
    """Return the factor at which the median over runs is target_mm, or None.

    Between the factors that are run, medians are interpolated as powers.
    """
    means = np.array(result.arrays("mean_mm", noise=noise))
    medians = np.nanmedian(means, axis=0)
    if not medians[0] <= target_mm <= medians[-1]:
        return None
    logs = np.interp(np.log(target_mm), np.log(medians), np.log(MULTIPLIED))
    return float(np.exp(logs))


# Misalignments of the bracket (mm), and their rigs; all of reduced size.
BRACKETS = {
    0.0: "onevr-d70-aligned-small",
    0.5: "onevr-d70-half-small",
    1.0: "onevr-d70-small",
    2.0: "onevr-d70-double-small",
}
OFFSETS_MM = {"quick": (0.0, 1.0), "full": tuple(BRACKETS)}
# Literals, which the workflow reads without running them.
BRACKET_SETS = {
    "quick": ("onevr-d70-aligned-small/0", "onevr-d70-small/0"),
    "full": (
        "onevr-d70-aligned-small/0", "onevr-d70-half-small/0",
        "onevr-d70-small/0", "onevr-d70-double-small/0",
        "onevr-d70-aligned-small/1", "onevr-d70-half-small/1",
        "onevr-d70-small/1", "onevr-d70-double-small/1",
        "onevr-d70-aligned-small/2", "onevr-d70-half-small/2",
        "onevr-d70-small/2", "onevr-d70-double-small/2",
    ),
}  # fmt: skip


def bracket_trial(condition, rng):
    """Return CGSP's ray-point errors on a rendered set of one misalignment."""
    folder = rendered_set(condition["rig"], condition["seed"])
    rays = shared_rays(first_points(folder), true_camera(folder).width, rng)
    true = true_grids_of_set(folder, rays.pixels)
    found = calibrated(rays.points, true, centrality=False, methods=("cgsp",))
    return found | {
        "true_scatter_mm": true.scatter_mm,
        "used": len(rays.pixels),
        "left_out": rays.left_out,
    }


def bracket_conditions(effort):
    """Return a condition for each misalignment and run."""
    return [
        {"offset_mm": offset, "rig": BRACKETS[offset], "seed": seed}
        for offset in OFFSETS_MM[effort]
        for seed in RUNS[effort]
    ]


def caustic_trial(condition, rng):
    """Return the scatter of noise-free fisheye rays after CGSP, and the caustic's.

    The caustic's spread is the RMS distance, from the point nearest to all true rays,
    of their crossings with the most nearly perpendicular plane through it.
    """
    rig, step = condition["rig"], condition["step"]
    grids = drawn_grids(rig, step, rng)
    seen = np.isfinite(grids.true[..., 0]).all(axis=0)
    points = grids.true[:, seen]
    camera = rig_named(rig).camera
    true = true_grids(camera, grids.T_camera_grid, grids.pixels[seen])
    start = linear_cgsp(points)
    found = crossings(start.centre, best_lines(points, start.T_base_grid))
    exact = crossings(true.centre, best_lines(points, true.T_base_grid))
    return {
        "scatter_mm": scatter_of(found)["rms_mm"],
        "caustic_mm": scatter_of(exact)["rms_mm"],
        "distance_mm": true.scatter_mm,
        "centre_off_mm": float(np.linalg.norm(start.centre - true.centre)),
    }


def caustic_conditions(effort):
    """Return the fisheye's condition; without noise only the poses are random."""
    return [{"rig": RIGS["fisheye"] + SMALL[effort], "step": STEPS[effort]}]
