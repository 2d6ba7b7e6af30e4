"""Tables 3.1 and 3.2, and what their values and the unstated ones do."""

import numpy as np

from chapters.ch03_planar_grids.s1_2_celect.results import NAMES, THRESHOLDS, Run
from chapters.ch03_planar_grids.s1_2_celect.trials.scenes import LEAST_PX
from raxel.features.celect import CelectSettings
from repro.judge.statistics import proportion
from repro.run.columns import columns
from repro.run.experiment import table
from repro.run.outcomes import Check, Measured, Table

# The corners of a side, and the letter of its count, as the page names them.
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
            "parameter": [f"$s_{i}$" for i in range(1, 5)],
            "value": [
                rf"$\lvert {ends} \rvert / ({divisor:g}\,{count})$"
                for ends, count in ENDS_AND_COUNTS
            ],
            "side (px)": sides.tolist(),
            "corners": counts.tolist(),
            "in the run of Fig. 3.1 (px)": run.s[:4].tolist(),
        },
        "Window radius of the four sides, with the values in the run of Fig. 3.1.",
        Check(
            bool(np.allclose(expected, run.s[:4])),
            "the run's radii are those of the formula",
        ),
        printed={"value": [f"t3_1_s{i}" for i in range(1, 5)]},
    )


@table("table_3_2", needs=("fig_3_1_run", "table_3_2_start"), evidence="synthetic")
def table_3_2(results):
    """Every threshold, its unit, and its value on side 1 of the run."""
    settings = CelectSettings()
    side_1 = float(Run(results["fig_3_1_run"]).s[0])

    def on_side_1(name, field):
        """(share of s_1, what it is on side 1) of a threshold; t4 is no share."""
        number = getattr(settings, field)
        return (None, number) if name == "t4" else (number, number * side_1)

    rows = [
        (f"$t_{name[1]}$", bounds, *on_side_1(name, field), unit, f"`{field}`")
        for name, (field, unit, bounds) in THRESHOLDS.items()
    ]
    names = (
        "Threshold", "What it bounds", "Share of $s_i$", "Side 1", "Unit",
        "Field of `CelectSettings`",
    )  # fmt: skip
    return Table(
        columns(names, rows),
        "Thresholds of CELECT. All but $t_4$ are shares of the window radius "
        "$s_i$; side 1 is that of the run of Fig. 3.1.",
        printed={
            "Share of $s_i$": [
                None if name == "t4" else f"t3_2_{name}" for name in THRESHOLDS
            ],
            "Side 1": [f"t3_2_{name}" if name == "t4" else None for name in THRESHOLDS],
        },
    )


@table("ext_celect_cameras", needs=("fig_3_1_cameras",), evidence="rendered")
def camera_table(results):
    """Share of boards read before each camera, by size of the picture."""
    result = results["fig_3_1_cameras"]

    def percent(camera, size):
        runs = result.column("success", camera=camera, size_px=size)
        return Measured(*(100 * end for end in proportion(runs)[:3]))

    rows = [
        (name, *(percent(camera, size) for size in LEAST_PX))
        for camera, name in NAMES.items()
    ]
    heads = [f"Squares from {least} px on (%)" for least in LEAST_PX.values()]
    return Table(
        columns(("Camera", *heads), rows),
        "Boards read completely and in order, with exact 95 % intervals: "
        f"random poses, {result.trials_per_condition} for each camera, in "
        "pictures of two sizes.",
    )
