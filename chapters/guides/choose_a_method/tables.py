"""Errors of the methods from results, and their costs as measured."""

from __future__ import annotations

import numpy as np

from chapters.guides.choose_a_method.results import (
    FOVS_DEG,
    MODELS,
    PRIMARY,
    SIMULATED,
    of_both,
    typical,
)
from chapters.shared.general_cameras import (
    KINDS,
)
from chapters.shared.photographs.compared import compared_sets
from chapters.shared.run_times import rounded_seconds
from chapters.shared.zoom_rigs import STAGE_ZOOM, ZOOMS
from raxel.cli.calibrate import FEWEST_VIEWS
from repro.page.reader import Shown, pipe_table
from repro.run.experiment import table
from repro.run.outcomes import Table

NONE = "–"
FAILED = "failed"
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


@table(
    "ext_methods",
    needs=(
        "fig_2_3_fov",
        "table_2_2_redrawn",
        "photograph_study",
        "fig_2_2_error",
    ),
    evidence="synthetic",
)
def ext_methods(results):
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
