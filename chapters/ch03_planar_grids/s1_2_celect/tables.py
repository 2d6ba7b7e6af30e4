"""Tables 3.1 and 3.2, and what their values and the unstated ones do."""

from __future__ import annotations

import numpy as np

from chapters.ch03_planar_grids.s1_2_celect.results import (
    COUNTS,
    FACTORS,
    SIDES,
    Run,
)
from raxel.features.celect import CelectSettings
from repro.run.experiment import table
from repro.run.outcomes import Check, Table


@table(
    "table_3_1",
    needs=("fig_3_1_run", "table_3_1_window"),
    evidence="synthetic",
)
def table_3_1(results):
    """The formula of each side's window radius, and its value in the run."""
    divisor = CelectSettings().radius_divisor
    run = Run(results["fig_3_1_run"])
    sides = np.linalg.norm(
        np.roll(run.outer, -1, axis=0) - run.outer, axis=1
    )
    rows, columns = run.grid.shape[:2]
    counts = np.array([columns, rows, columns, rows])
    expected = sides / (divisor * counts)
    return Table(
        {
            "parameter": [f"s_{i}" for i in range(1, 5)],
            "value": [
                f"|{side}| / ({divisor:g} {count})"
                for side, count in zip(SIDES, COUNTS, strict=True)
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
    )


@table(
    "table_3_2",
    needs=("fig_3_1_run", "table_3_2_start"),
    evidence="synthetic",
)
def table_3_2(results):
    """Every threshold, its unit, and its value on side 1 of the run."""
    settings = CelectSettings()
    run = Run(results["fig_3_1_run"])
    names = [*FACTORS, "t4"]
    names.sort()
    rows = {
        "parameter": [],
        "value": [],
        "unit": [],
        "field": [],
        "side 1": [],
    }
    for name in names:
        if name == "t4":
            field, unit = "first_angle_deg", "deg"
            here = settings.first_angle_deg
            value = f"{here:g}"
        else:
            field, unit = FACTORS[name]
            value = f"{getattr(settings, field):g} s_i"
            here = getattr(settings, field) * run.s[0]
        for key, cell in zip(
            rows,
            (f"t_{name[1]}", value, unit, field, float(here)),
            strict=True,
        ):
            rows[key].append(cell)
    return Table(
        rows,
        "Thresholds of CELECT: value, unit in which the number is taken, field of "
        "`CelectSettings`, and size on side 1 of the run of Fig. 3.1.",
    )


@table(
    "ext_celect_smoothing",
    needs=("ext_celect_limits",),
    evidence="synthetic",
)
def smoothing_table(results):
    """Success by smoothing, over noise and over the size of squares."""
    result = results["ext_celect_limits"]
    rules = list(
        dict.fromkeys(c["smoothing_px"] for c in result.conditions)
    )
    scenes = list(
        dict.fromkeys(
            (c["squares_across"], c["noise_sd"]) for c in result.conditions
        )
    )
    columns = {
        "smoothing (px)": [
            "0.1 s (chosen)" if rule is None else f"{rule:g}"
            for rule in rules
        ]
    }
    for across, noise in scenes:
        name = f"{1000 / across:.0f} px squares, noise {noise:g} (%)"
        columns[name] = [
            100
            * float(
                result.column(
                    "success",
                    smoothing_px=rule,
                    squares_across=across,
                    noise_sd=noise,
                ).mean()
            )
            for rule in rules
        ]
    return Table(
        columns,
        "Noise and small squares ask for opposite smoothing: share of synthetic "
        "boards read completely. The thesis states no smoothing.",
    )
