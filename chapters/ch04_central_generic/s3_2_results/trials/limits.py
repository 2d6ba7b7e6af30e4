"""What a bracket that is off, and a pupil that moves, do without the bench's noise."""

import numpy as np

from chapters.ch04_central_generic.s3_2_results.trials.drawn import STEPS, drawn_grids
from chapters.shared.active_grid_sets import true_camera
from chapters.shared.central_scatter import best_lines, crossings, scatter_of
from chapters.shared.central_sets import (
    RIGS,
    SEEDS,
    SMALL,
    first_points,
    shared_rays,
    true_grids,
    true_grids_of_set,
)
from chapters.shared.rigs import rig_named
from chapters.shared.three_grids import calibrated
from raxel.calibration import linear_cgsp
from repro.run.rendered import rendered_set

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
    """CGSP's ray-point errors on rendered sets of one misalignment."""
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
    """The fisheye; without noise nothing but the poses is drawn."""
    return [{"rig": RIGS["fisheye"] + SMALL[effort], "step": STEPS[effort]}]
