"""What the page of methods shows: errors from results, costs as measured."""

from __future__ import annotations

import time

import numpy as np

from chapters.photographs.by_distortion.results import compared_sets
from chapters.shared.algorithm_1 import (
    BOARDS,
    SIZE_PX,
    board_points,
    draw_poses,
)
from chapters.shared.algorithm_1 import (
    COLUMNS as BOARD_COLUMNS,
)
from chapters.shared.algorithm_1 import (
    ROWS as BOARD_ROWS,
)
from chapters.shared.general_cameras import (
    KINDS,
    draw_two_grids,
    fisheye,
)
from raxel.calibration import (
    BoardView,
    calibrate_generic,
    calibrate_zhang,
    rays_from_known_motion,
)
from raxel.cameras.base import pixel_grid
from raxel.cli.calibrate import FEWEST_VIEWS
from raxel.geometry import intersect_rays_plane, transform
from repro.judge.statistics import median_interval
from repro.page.reader import Shown, pipe_table
from repro.run.experiment import trial_rng
from repro.run.outcomes import Table

NONE = "–"
FAILED = "failed"
METHODS = ("parametric", "generic_well_conditioned")
PRIMARY = {"domain": "px", "extent": "unbounded"}
FOVS_DEG = (60, 120, 150)
ZOOMS = (1, 2, 3)
STAGE_ZOOM = 3
BOARD_SHARE = 0.4  # of the board of Algorithm 1, which leaves the image
SIMULATED = {
    "clean.source.mean_px": "residual, clean (px)",
    "ray_deg": "ray error (deg)",
}
MODELS = {"zhang": METHODS[0], "general": METHODS[1]}
COLUMNS = (
    "Evidence",
    "Camera",
    "Quantity",
    "Zhang",
    "Generic, unknown poses",
    "General, known motion",
)
CAPTION = (
    "What each method leaves, where this repository has measured it. Medians "
    "with 95 % intervals; a failed trial counts as worst, and a method that "
    "failed in half of them or more has no median. Compare along a row only: "
    "the rows have different cameras, units and noise."
)


def told(estimate):
    """A median with its interval in words, or a dash where there is none.

    Where at least half of the trials failed, the worst is the median.
    """
    if estimate is None:
        return NONE
    if not np.isfinite(estimate.value):
        return FAILED
    e = estimate
    return f"{e.value:.2g} ({e.low:.2g} to {e.high:.2g})"


def typical(result, name, **condition):
    """Median over the trials; a failed one counts as the worst."""
    return median_interval(result.column(name, **condition))


def of_both(result, name, **condition):
    """The same value of Zhang's and of the generic method."""
    return [
        typical(result, f"{method}.{name}", **condition)
        for method in METHODS
    ]


def simulated_rows(fov):
    """Fig. 2.3: ray error and residual at three fields of view."""
    for name, quantity in SIMULATED.items():
        for at in FOVS_DEG:
            found = of_both(fov, name, fov_deg=at, **PRIMARY)
            yield ("simulated", f"fisheye, {at}°", quantity, *found, None)


def rendered_rows(zoom):
    """Table 2.2: what is left in pictures kept out, and the stage."""
    name = "held_out.corrected.rms_px"
    for at in ZOOMS:
        found = of_both(zoom, name, zoom=at)
        camera = f"fisheye converter, set {at}"
        quantity = "left after correction, kept out (px)"
        yield ("rendered", camera, quantity, *found, None)
    found = of_both(zoom, "stage.grid.deviation_mm", zoom=STAGE_ZOOM)
    camera = f"fisheye converter, set {STAGE_ZOOM}"
    yield ("rendered", camera, "scatter of equal steps (mm)", *found, None)


def motion_rows(wrong):
    """Ray error of the two-pose method for one unit of error of T_1."""
    for kind, unit in KINDS.items():
        found = typical(wrong, "ray_deg.1", kind=kind)
        quantity = f"ray error (deg) for 1 {unit} of wrong {kind}"
        yield ("simulated", "fisheye, 120°", quantity, None, None, found)


def photograph_rows(study):
    """Every image set of the build: residual in photographs kept out."""
    for one in compared_sets(study):
        errors = one.errors["rms_px"]
        found = [errors.get(model) for model in MODELS]
        quantity = "residual, kept out (px)"
        yield ("photographs", one.name, quantity, *found, None)


def methods_table(results):
    """Every row that compares methods, from four experiments."""
    rows = [
        *simulated_rows(results["fig_2_3_fov"]),
        *rendered_rows(results["table_2_2_redrawn"]),
        *photograph_rows(results["photograph_study"]),
        *motion_rows(results["fig_2_2_error"]),
    ]
    cells = [[*row[:3], *(told(e) for e in row[3:])] for row in rows]
    columns = zip(*cells, strict=True)
    return Table(
        {name: list(c) for name, c in zip(COLUMNS, columns, strict=True)},
        CAPTION,
    )


def named(results):
    """Numbers of the prose: name -> text."""
    fov, zoom = results["fig_2_3_fov"], results["table_2_2_redrawn"]
    out = {}
    for at in FOVS_DEG:
        for name in SIMULATED:
            found = of_both(fov, name, fov_deg=at, **PRIMARY)
            for method, estimate in zip(MODELS, found, strict=True):
                out[f"{method}.{name}.{at}"] = short(estimate)
    for at in ZOOMS:
        found = of_both(zoom, "held_out.corrected.rms_px", zoom=at)
        for method, estimate in zip(MODELS, found, strict=True):
            out[f"{method}.zoom.{at}"] = short(estimate)
    found = of_both(zoom, "stage.grid.deviation_mm", zoom=STAGE_ZOOM)
    for method, estimate in zip(MODELS, found, strict=True):
        out[f"{method}.stage"] = short(estimate)
    for kind in KINDS:
        found = typical(results["fig_2_2_error"], "ray_deg.1", kind=kind)
        out[f"motion.{kind}"] = short(found)
    out["motion.grids"] = results["fig_2_2_error"].settings["grids"]
    out["boards"], out["size"] = str(BOARDS), str(SIZE_PX)
    out["pictures"] = str(zoom.settings["calibration_images"])
    out["noise"] = f"{fov.settings['fov_sweep']['noise']:g}"
    return out


def short(estimate):
    """A median in words, for a sentence."""
    return f"{estimate.value:.2g}" if np.isfinite(estimate.value) else "∞"


def rounded_seconds(seconds):
    """A run time in words, coarse enough to be the same again."""
    return "under 1 s" if seconds < 1 else f"{seconds:.0f} s"


def timed(call):
    """Seconds that a call takes."""
    start = time.perf_counter()
    call()
    return time.perf_counter() - start


def whole_board(camera, T_camera_grid):
    """BoardView of a board small enough to be seen whole."""
    points = BOARD_SHARE * board_points()
    flat = np.column_stack([points, np.zeros(len(points))])
    pixels = camera.project(transform(T_camera_grid, flat)).pixels
    return BoardView(pixels, points, BOARD_COLUMNS, BOARD_ROWS)


def method_seconds():
    """Method -> seconds: the boards of one fisheye, calibrated now."""
    rng = trial_rng("ext_methods_seconds", {}, 0)
    camera, size = fisheye(SIZE_PX, SIZE_PX), (SIZE_PX, SIZE_PX)
    views = [whole_board(camera, T) for T in draw_poses(rng)]
    grids = draw_two_grids(rng, 1.0)
    rays = camera.rays(pixel_grid(*size))
    hits = intersect_rays_plane(rays.origins, rays.directions, grids)
    return {
        "zhang": timed(lambda: calibrate_zhang(views, *size)),
        "general": timed(lambda: calibrate_generic(views, *size, rng=rng)),
        "motion": timed(lambda: rays_from_known_motion(hits.points, grids)),
    }


def costs(seconds):
    """Table of what each method asks for; seconds as `method_seconds`."""
    took = {name: rounded_seconds(s) for name, s in seconds.items()}
    head = ["Method", "Pictures, at least", "Calibration", "Capture"]
    rows = [
        [
            "Zhang",
            str(FEWEST_VIEWS["zhang"]),
            took["zhang"],
            "board in the hand, tilted; any part of the image",
        ],
        [
            "Generic, unknown poses",
            str(FEWEST_VIEWS["generic"]),
            took["general"],
            "board in the hand, tilted; boards overlap in the image, and "
            "together cover it",
        ],
        [
            "General, known motion",
            "2",
            took["motion"],
            "target on a measured stage; every pixel sees it in each pose",
        ],
    ]
    text = pipe_table(head, rows, [False] * len(head))
    return Shown(text, f"<pre>{text}</pre>")
