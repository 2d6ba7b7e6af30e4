"""Calibrations of section 4.3.2: from pictures, and from errors drawn again."""

from functools import cache

import numpy as np

from chapters.shared.active_grid_sets import seen_grids, true_camera
from chapters.shared.central_scatter import crossings, scatter_of
from chapters.shared.central_sets import (
    LINEAR_GRIDS,
    RIGS,
    SEEDS,
    SMALL,
    first_points,
    shared_rays,
    true_grids,
    true_grids_of_set,
)
from chapters.shared.decoding_errors import (
    drawn_again,
    lattice_rays,
    measured_errors,
    true_lattice,
)
from chapters.shared.rigs import rig_named
from chapters.shared.three_grids import calibrated, parameters
from raxel.calibration import linear_cgsp
from repro.run.rendered import rendered_set

TRIALS = {"quick": 3, "full": 50}
# px between the rays of a trial: some thousand of them meet all three grids.
STEPS = {"quick": 4, "full": 9}
# Misalignments of the bracket (mm), and their rigs; all of reduced size.
BRACKETS = {
    0.0: "onevr-d70-aligned-small",
    0.5: "onevr-d70-half-small",
    1.0: "onevr-d70-small",
    2.0: "onevr-d70-double-small",
}
OFFSETS_MM = {"quick": (0.0, 1.0), "full": tuple(BRACKETS)}
DRAWN = 3000  # points of a scatter that are drawn
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


def rendered_trial(condition, rng):
    """A rendered set decoded and calibrated by every method, and its true numbers."""
    folder = rendered_set(condition["rig"], condition["seed"])
    rays = shared_rays(first_points(folder), true_camera(folder).width, rng)
    true = true_grids_of_set(folder, rays.pixels)
    found = calibrated(rays.points, true)
    step = max(1, len(rays.pixels) // DRAWN)
    for method in found.values():
        if "crossing" in method:
            method["crossing"] = method["crossing"][::step]
    return found | _of_rays(rays, true)


def _of_rays(rays, true):
    """How many rays there were, and what is true of them."""
    return {
        "true": parameters(true.centre, true.T_base_grid),
        "true_scatter_mm": true.scatter_mm,
        "rays": rays.found,
        "used": len(rays.pixels),
        "left_out": rays.left_out,
    }


def errors_trial(condition, rng):
    """The DecodingErrors of all rendered sets of a rig, as arrays."""
    folders = [rendered_set(condition["rig"], seed) for seed in condition["seeds"]]
    rays, shape = lattice_rays(true_camera(folders[0]), 1)
    found = measured_errors(
        (grid, (rays.directions @ grid.T_camera_grid[:3, 2]).reshape(shape))
        for folder in folders
        for grid in seen_grids(folder, count=LINEAR_GRIDS)
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
    """A condition for each rig whose errors are measured."""
    rigs = [rig + SMALL[effort] for rig in RIGS.values()]
    return [{"rig": rig, "seeds": list(SEEDS[effort])} for rig in rigs]


@cache
def _rays_of(rig, step):
    camera = rig_named(rig).camera
    return camera, *lattice_rays(camera, step)


def drawn_grids(rig, step, rng, errors=None):
    """The three grids of the linear stage set up anew, and what is decoded of them.

    Returns points (3, N, 2) mm with the errors drawn again (none without), pixels
    (N, 2), and T_camera_grid (3, 4, 4); N rays of a lattice of every step-th pixel.
    """
    camera, rays, shape = _rays_of(rig, step)
    setup = rig_named(rig)
    poses = setup.draw_poses(rng, LINEAR_GRIDS)
    points = []
    for T in poses:
        seen, cosine = true_lattice(rays, shape, T, setup.target.monitor_mm)
        if errors is not None:
            seen = drawn_again(errors, seen, cosine, rng, step)
        points.append(seen.reshape(-1, 2))
    v, u = np.mgrid[step // 2 : camera.height : step, step // 2 : camera.width : step]
    return (
        np.array(points),
        np.column_stack([u.ravel(), v.ravel()]).astype(float),
        poses,
    )


def redrawn_trial(condition, rng, errors):
    """Grids set up anew, decoding errors drawn again; as `rendered_trial`."""
    rig = condition["rig"]
    points, pixels, poses = drawn_grids(rig, condition["step"], rng, errors[rig])
    rays = shared_rays(points, 1, rng)
    chosen = pixels[rays.pixels[:, 1].astype(int)]
    true = true_grids(rig_named(rig).camera, poses, chosen)
    found = calibrated(rays.points, true)
    for method in found.values():
        method.pop("crossing", None)  # only rendered sets are drawn
    return found | _of_rays(rays, true)


def redrawn_conditions(effort):
    """A condition for each camera."""
    return [
        {"camera": camera, "rig": rig + SMALL[effort], "step": STEPS[effort]}
        for camera, rig in RIGS.items()
    ]


def bracket_trial(condition, rng):
    """CGSP's ray-point errors on rendered sets of one misalignment."""
    found = rendered_trial(condition, rng)
    return {
        name: found[name] for name in ("cgsp", "true_scatter_mm", "used", "left_out")
    }


def bracket_conditions(effort):
    """A condition for every misalignment and seed."""
    return [
        {"offset_mm": offset, "rig": BRACKETS[offset], "seed": seed}
        for offset in OFFSETS_MM[effort]
        for seed in SEEDS[effort]
    ]


def caustic_trial(condition, rng):
    """Noise-free rays of the fisheye: their scatter after CGSP, and the caustic's own.

    The caustic's spread is where the true rays cross the plane across them through
    the point nearest to all, RMS from there.
    """
    rig, step = condition["rig"], condition["step"]
    points, pixels, poses = drawn_grids(rig, step, rng)
    seen = np.isfinite(points[..., 0]).all(axis=0)
    points, pixels = points[:, seen], pixels[seen]
    true = true_grids(rig_named(rig).camera, poses, pixels)
    start = linear_cgsp(points)
    found = crossings(start.centre, points, start.T_base_grid)
    exact = crossings(true.centre, points, true.T_base_grid)
    return {
        "scatter_mm": scatter_of(found)["rms_mm"],
        "caustic_mm": scatter_of(exact)["rms_mm"],
        "distance_mm": true.scatter_mm,
        "centre_off_mm": float(np.linalg.norm(start.centre - true.centre)),
    }


def caustic_conditions(effort):
    """The fisheye; without noise nothing but the poses is drawn."""
    return [{"rig": RIGS["fisheye"] + SMALL[effort], "step": STEPS[effort]}]
