"""Tables 3.1 and 3.2, and the success of CELECT with four cameras."""

import numpy as np

from chapters.ch03_planar_grids.s1_2_celect.results import NAMES, THRESHOLDS, Run
from chapters.ch03_planar_grids.s1_2_celect.trials.scenes import MIN_SQUARE_PX
from raxel.features.celect import CelectSettings
from repro.judge.statistics import proportion
from repro.run.columns import columns
from repro.run.experiment import table
from repro.run.outcomes import Check, Measured, Table

# End corners of each side, and the symbol of its number of corners.
ENDS_AND_COUNTS = (
    ("c_1 - c_2", "w"),
    ("c_2 - c_3", "h"),
    ("c_3 - c_4", "w"),
    ("c_4 - c_1", "h"),
)


@table("table_3_1", needs=("fig_3_1_run", "table_3_1_window"), evidence="synthetic")
def table_3_1(results):
    """The formula of each side's window radius, and its value in the run."""
    divisor = CelectSettings().radius_divisor
    run = Run(results["fig_3_1_run"])
    sides = np.linalg.norm(np.roll(run.outer, -1, axis=0) - run.outer, axis=1)
    rows, columns = run.grid.shape[:2]
    counts = np.array([columns, rows, columns, rows])
    expected = sides / (divisor * counts)
    return Table(
        {
            "Radius": [f"$s_{i}$" for i in range(1, 5)],
            "Formula": [
                rf"$\lvert {ends} \rvert / ({divisor:g}\,{count})$"
                for ends, count in ENDS_AND_COUNTS
            ],
            "Length of the side (px)": sides.tolist(),
            "Corners": counts.tolist(),
            "Run of Fig. 3.1 (px)": run.s[:4].tolist(),
        },
        "Window radius on the four sides: formula, and value in the run of Fig. 3.1.",
        Check(
            bool(np.allclose(expected, run.s[:4])),
            "the run's radii are those of the formula",
        ),
        printed={"Formula": [f"t3_1_s{i}" for i in range(1, 5)]},
    )


@table("table_3_2", needs=("fig_3_1_run", "table_3_2_start"), evidence="synthetic")
def table_3_2(results):
    """All thresholds, with unit and value on side 1 of the run."""
    settings = CelectSettings()
    side_1 = float(Run(results["fig_3_1_run"]).s[0])

    def on_side_1(name, field):
        """(fraction of s_1, value on side 1) of a threshold; t4 is no fraction."""
        number = getattr(settings, field)
        return (None, number) if name == "t4" else (number, number * side_1)

    rows = [
        (f"$t_{name[1]}$", bounds, *on_side_1(name, field), unit, f"`{field}`")
        for name, (field, unit, bounds) in THRESHOLDS.items()
    ]
    names = (
        "Threshold", "Bounded quantity", "Fraction of $s_i$", "Side 1", "Unit",
        "Field of `CelectSettings`",
    )  # fmt: skip
    return Table(
        columns(names, rows),
        "Thresholds of CELECT. All except $t_4$ are fractions of the window radius "
        "$s_i$. Side 1: value in the run of Fig. 3.1.",
        printed={
            "Fraction of $s_i$": [
                None if name == "t4" else f"t3_2_{name}" for name in THRESHOLDS
            ],
            "Side 1": [f"t3_2_{name}" if name == "t4" else None for name in THRESHOLDS],
        },
    )


@table("ext_celect_cameras", needs=("fig_3_1_cameras",), evidence="rendered")
def camera_table(results):
    """Share of correct boards for each camera and smallest square."""
    result = results["fig_3_1_cameras"]

    def percent(camera, size):
        runs = result.column("success", camera=camera, size_px=size)
        return Measured(*(100 * end for end in proportion(runs)[:3]))

    rows = [
        (name, *(percent(camera, size) for size in MIN_SQUARE_PX))
        for camera, name in NAMES.items()
    ]
    heads = [
        f"Correct, squares from {least} px (%)" for least in MIN_SQUARE_PX.values()
    ]
    return Table(
        columns(("Camera", *heads), rows),
        "Share of correct boards for four cameras and two image sizes, with exact "
        f"95 % intervals, from {result.trials_per_condition} random poses each.",
    )
