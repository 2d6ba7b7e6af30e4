"""Tables of section 3.3.2."""

from functools import partial

import numpy as np

from chapters.ch03_planar_grids.s3_2_grid_sets.results.pictures import (
    EXPERIMENTS,
    GRIDS,
    TITLES,
    WINDOW,
    errors,
    right,
)
from chapters.ch03_planar_grids.s3_2_grid_sets.trials.scores import (
    BOTH,
    FINE,
    REFERENCE,
    TRUTH,
)
from chapters.shared.grid_detectors import CELECT, CLICKLESS, LINEAR, OPENCV, OPENCV_SB
from repro.judge.statistics import bootstrap
from repro.run.columns import columns
from repro.run.experiment import table
from repro.run.outcomes import Check, Measured, Table

FULL = "full window"
ROWS = {
    OPENCV: "OpenCV findChessboardCorners",
    OPENCV_SB: "OpenCV findChessboardCornersSB",
    CELECT: "CELECT",
    LINEAR: "CELECT, tone curve undone (ext.)",
    FINE: "CELECT, finer Harris (ext.)",
    BOTH: "CELECT, both (ext.)",
    CLICKLESS: "without clicks (ext.)",
}
# Names of sets, methods and published columns in the registry's ids.
PRINTED_SETS = {
    "spherical": "sph",
    "hyperboloidal": "hyp",
    "fisheye": "fish",
    "flexible-mirror": "flex",
}
PRINTED_METHODS = {OPENCV: "opencv", CELECT: "celect"}
PRINTED_COLUMNS = {
    "Correct": "count",
    "Mean before (px)": "pre_mean",
    "Max before (px)": "pre_max",
    "SD before (px)": "pre_sd",
    "Mean after (px)": "post_mean",
    "Max after (px)": "post_max",
    "SD after (px)": "post_sd",
}
PRINTED_CONFIGURATION = ("Width (px)", "Height (px)", "Columns", "Pitch (mm)", "Images")
HEADS = (
    "Method",
    "Correct",
    "Images",
    "Mean before (px)",
    "Max before (px)",
    "SD before (px)",
    "Mean after (px)",
    "Max after (px)",
    "SD after (px)",
    "Mean after, full window (px)",
    "Max after, full window (px)",
    "Max after, against truth (px)",
)


@table("table_3_3", needs=GRIDS, evidence="rendered")
def table_3_3(results):
    """Return the four sets as rendered, one row per grid."""
    rows, printed, stated = [], [], []
    for set_name, experiment in EXPERIMENTS.items():
        ran = results[experiment].settings
        stated += corners_as_stated(results[experiment])
        camera = ran["camera"].split(" (thesis")[0].split(", 9 x")[0]
        rows += [
            [TITLES[set_name], camera, *ran["image_px"], *grid, pitch, images]
            for grid, pitch, images in zip(
                ran["grids"], ran["pitch_mm"], ran["images"], strict=True
            )
        ]
        printed += configuration(PRINTED_SETS[set_name], ran["grids"])
    heads = (
        "Image set",
        "Camera",
        "Width (px)",
        "Height (px)",
        "Columns",
        "Rows",
        "Pitch (mm)",
        "Images",
    )
    return Table(
        columns(heads, rows),
        "Configurations of the rendered sets. Columns and rows count interior "
        "corners. The rig files state the origin of every value.",
        Check(
            bool(stated) and all(stated),
            f"{sum(stated)} of {len(stated)} images show as many corners as the "
            "columns and rows of their grid have",
        ),
        printed=columns(PRINTED_CONFIGURATION, printed),
    )


def configuration(short, grids):
    """Return the ids of published values of a set, one row per grid."""
    named = [(f"_grid_{wide}x{high}", f"_{wide}x{high}") for wide, high in grids]
    alone = len(grids) == 1
    return [
        (
            *(f"t3_3_{short}{of}" for of in ("_w", "_h", grid)),
            f"t3_3_{short}_pitch{'' if alone else size}",
            "t3_3_images" if alone else None,
        )
        for grid, size in named
    ]


def corners_as_stated(result):
    """Return for each image whether it shows as many corners as its settings state."""
    ran = result.settings
    of_image = np.repeat([wide * high for wide, high in ran["grids"]], ran["images"])
    images = [c["image"] for c in result.conditions]
    return (result.select().column("corners") == of_image[images]).tolist()


def mean_of(grids):
    """Return the mean over all corners; 95 % bootstrap interval over whole grids."""
    sums, counts = np.array([[e.sum(), len(e)] for e in grids]).T

    def statistic(total, number):
        return total.sum(axis=-1) / number.sum(axis=-1)

    return Measured(*bootstrap(statistic, sums, counts, paired=True)[:3])


def statistics(grids):
    """Return mean, maximum and SD (px) of the errors of correct grids, or None."""
    if not grids:
        return [None] * 3
    every = np.concatenate(grids)
    return [mean_of(grids), float(every.max()), float(every.std(ddof=1))]


def error_table(result, number):
    """Return counts and errors of every method in one set, as in Table 3.``number``."""
    rows = []
    for method, name in ROWS.items():
        found = right(result, method)
        after = partial(errors, result, method, "after")
        rows.append(
            [name, int(found.sum()), len(found)]
            + statistics(errors(result, method, "before", TRUTH))
            + statistics(after(REFERENCE))
            + statistics(after(REFERENCE, window=FULL))[:2]
            + statistics(after(TRUTH))[1:2]
        )
    title = TITLES[result.settings["set"]]
    half = result.settings["localiser"]["half_window_px"]
    return Table(
        columns(HEADS, rows),
        f"{title} set: numbers of correct grids and errors of their corners, whole "
        "range of poses, all simulated runs. Errors before localisation are "
        "relative to the true corners. Errors after it are relative to the true "
        "corners refined by the same localiser, as in the thesis, with a "
        f"half-window of {half[WINDOW]} px (full window: {half[FULL]} px). "
        "Brackets: 95 % interval of the mean over grids.",
        printed={
            head: [
                f"t3_{number}_{PRINTED_METHODS[method]}_{what}"
                if method in PRINTED_METHODS
                else None
                for method in ROWS
            ]
            for head, what in PRINTED_COLUMNS.items()
        },
    )


@table("table_3_4", needs=("table_3_4_grids",), evidence="rendered")
def table_3_4(results):
    """Return the table of the Spherical set."""
    return error_table(results["table_3_4_grids"], 4)


@table("table_3_5", needs=("table_3_5_grids",), evidence="rendered")
def table_3_5(results):
    """Return the table of the Hyperboloidal set."""
    return error_table(results["table_3_5_grids"], 5)


@table("table_3_6", needs=("table_3_6_grids",), evidence="rendered")
def table_3_6(results):
    """Return the table of the Fisheye set."""
    return error_table(results["table_3_6_grids"], 6)


@table("table_3_7", needs=("table_3_7_grids",), evidence="rendered")
def table_3_7(results):
    """Return the table of the Flexible Mirror set."""
    return error_table(results["table_3_7_grids"], 7)
