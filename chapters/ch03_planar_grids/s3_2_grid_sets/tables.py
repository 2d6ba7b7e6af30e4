"""The tables of section 3.3.2."""

from __future__ import annotations

import numpy as np

from chapters.ch03_planar_grids.s3_2_grid_sets.results import (
    EXPERIMENTS,
    GRIDS,
    errors,
    right,
    seeds_of,
    title_of,
)
from chapters.ch03_planar_grids.s3_2_grid_sets.trials.scores import (
    BOTH,
    FINE,
    REFERENCE,
    TRUTH,
)
from chapters.shared.grid_detectors import (
    CELECT,
    CLICKLESS,
    LINEAR,
    OPENCV,
    OPENCV_SB,
)
from repro.run.experiment import table
from repro.run.outcomes import Check, Table

ROWS = {
    OPENCV: "OpenCV findChessboardCorners",
    OPENCV_SB: "OpenCV findChessboardCornersSB",
    CELECT: "CELECT",
    LINEAR: "CELECT, tone curve undone (ext.)",
    FINE: "CELECT, finer Harris (ext.)",
    BOTH: "CELECT, both (ext.)",
    CLICKLESS: "without clicks (ext.)",
}
NOTHING = "–"


@table(
    "table_3_3",
    needs=GRIDS,
    evidence="rendered",
)
def table_3_3(results):
    """The four sets as they were rendered."""
    columns = {
        "Image set": [],
        "Camera": [],
        "Resolution (px)": [],
        "Grid (int. corners)": [],
        "Pitch (mm)": [],
        "Images": [],
    }
    for set_name, experiment in EXPERIMENTS.items():
        ran = results[experiment].settings
        width, height = ran["image_px"]
        cells = (
            title_of(set_name),
            ran["camera"].split(" (thesis")[0],
            f"{width} × {height}",
            ", ".join(f"{c} × {r}" for c, r in ran["grids"]),
            ", ".join(f"{pitch:g}" for pitch in ran["pitch_mm"]),
            " + ".join(str(count) for count in ran["images"]),
        )
        for column, cell in zip(columns.values(), cells, strict=True):
            column.append(cell)
    return Table(
        columns,
        "Configurations of the rendered sets. Every value of a rig has its "
        "origin in its file.",
        Check(True, "read from the settings of the runs"),
    )


def statistics(values):
    """Mean, maximum and SD (px) of errors as cells."""
    if not len(values):
        return [NOTHING] * 3
    spread = values.std(ddof=1) if len(values) > 1 else np.nan
    return [f"{x:.4f}" for x in (values.mean(), values.max(), spread)]


def counted(result, method):
    """Right grids of the first seed and of all, as cells."""
    seeds = seeds_of(result)
    first, every = right(result, method, seeds[0]), right(result, method)
    return [
        f"{first.sum()}/{len(first)}",
        f"{every.sum()}/{len(every)}",
    ]


def error_table(result):
    """Counts and errors of every method in one set."""
    heads = ["Method", "Grids right (seed 1)", "(all seeds)"]
    for when in ("before", "after"):
        heads += [f"{name} {when} (px)" for name in ("Mean", "Max", "SD")]
    heads += ["Mean after, against truth (px)", "Max (px)"]
    rows = []
    for method, name in ROWS.items():
        cells = [name, *counted(result, method)]
        for when in ("before", "after"):
            cells += statistics(errors(result, method, when, REFERENCE))
        cells += statistics(errors(result, method, "after", TRUTH))[:2]
        rows.append(cells)
    columns = {
        head: [row[k] for row in rows] for k, head in enumerate(heads)
    }
    title = title_of(result.settings["set"])
    return Table(
        columns,
        f"{title} set: grids with every corner right and in order, and the "
        "errors of their corners over all seeds, before and after "
        "cornerSubPix. Errors are against corners that the same localiser "
        "moved from the truth, as in the text; the last two columns are "
        "against the truth itself.",
    )


@table("table_3_4", needs=("table_3_4_grids",), evidence="rendered")
def table_3_4(results):
    """The Spherical set."""
    return error_table(results["table_3_4_grids"])


@table("table_3_5", needs=("table_3_5_grids",), evidence="rendered")
def table_3_5(results):
    """The Hyperboloidal set."""
    return error_table(results["table_3_5_grids"])


@table("table_3_6", needs=("table_3_6_grids",), evidence="rendered")
def table_3_6(results):
    """The Fisheye set."""
    return error_table(results["table_3_6_grids"])


@table("table_3_7", needs=("table_3_7_grids",), evidence="rendered")
def table_3_7(results):
    """The Flexible Mirror set."""
    return error_table(results["table_3_7_grids"])
