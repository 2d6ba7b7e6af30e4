"""Table 2.2, and the same residuals with other corners."""

from __future__ import annotations

from itertools import product

import numpy as np

from chapters.shared.methods import METHODS, NAMES
from chapters.shared.zoom_readings import OF_SEEDS, ZoomCase
from chapters.shared.zoom_rigs import FACADE_ZOOM, STAGE_ZOOM, ZOOMS
from repro.judge.statistics import SIGNIFICANCE, holm, with_worst
from repro.run.columns import columns
from repro.run.experiment import table
from repro.run.outcomes import Check, Measured, Table

SOURCES = {"table_2_2_redrawn": "redrawn", "table_2_2_rendered": "rendered"}
# Methods in the order of the thesis, with their names in the registry's ids.
ROWS = (("parametric", "persp"), ("generic_as_printed", "gen"))
STATISTICS = {"rms": "RMS", "sd": "SD"}
FISHEYE = "OpenCV fisheye"


@table(
    "table_2_2", needs=("table_2_2_redrawn", "table_2_2_rendered"), evidence="rendered"
)
def table_2_2(results):
    """Tabulate the residuals of the calibration images, in px of the corrected view."""
    redrawn = results["table_2_2_redrawn"]
    places = list(product(ROWS, STATISTICS))
    found = {
        "Method": [NAMES[method] for (method, _), _ in places],
        "Error type": [STATISTICS[statistic] for _, statistic in places],
    }
    printed = {}
    for zoom in ZOOMS:
        found[f"Set {zoom} (px)"] = [
            Measured.median_or_none(
                redrawn.column(
                    f"{method}.calibration.corrected.{statistic}_px", zoom=zoom
                )
            )
            for (method, _), statistic in places
        ]
        printed[f"Set {zoom} (px)"] = [
            f"t2_2_{short}_{statistic}_set{zoom}" for (_, short), statistic in places
        ]
    return Table(
        found,
        "Distortion residuals after perspective correction, in px of the "
        f"corrected view: medians over {redrawn.trials_per_condition} simulated "
        "runs with 95 % intervals.",
        agreement(*(results[name] for name in SOURCES)),
        printed=printed,
    )


LINES = {"parametric": "parametric", "generic_as_printed": "generic"}


@table("ext_table_2_2_readings", needs=OF_SEEDS, evidence="rendered")
def ext_table_2_2_readings(results):
    """Tabulate the section's results for other corner noise and interpolation."""
    rows = []
    for noise, between, method in (
        ("none", "homographic", "parametric"),
        ("none", "homographic", "generic_as_printed"),
        ("none", "smooth", "generic_as_printed"),
        ("none", "smooth", "opencv_fisheye"),
        *(
            (noise, "homographic", method)
            for noise in ("0.06 px", "0.45 px")
            for method in LINES
        ),
    ):
        case = ZoomCase(results, {"corner_noise": noise, "interpolation": between})
        residuals = [
            case.column(f"{method}.calibration.corrected.rms_px", zoom)
            for zoom in ZOOMS
        ]
        medians = [np.median(with_worst(trials)) for trials in residuals]
        ratio = float(max(medians) / min(medians))
        steps = case.column(f"{method}.stage.grid.deviation_mm", STAGE_ZOOM)
        name = {**NAMES, "opencv_fisheye": FISHEYE}[method]
        if between == "smooth" and method in LINES:
            name += ", smooth"
        # Section 2.5.3 has its lines for two methods alone.
        place = f"lines.generic_as_printed.{LINES.get(method)}.corrected"
        off_lines = case.column(place, FACADE_ZOOM) if method in LINES else [np.nan]
        rows.append(
            [noise, name, len(steps), *map(Measured.median_or_none, residuals)]
            + [ratio if np.isfinite(ratio) else None]
            + [Measured.median_or_none(trials) for trials in (steps, off_lines)]
        )
    names = [
        "Noise added", "Method", "Runs", *(f"Set {zoom} (px)" for zoom in ZOOMS),
        "Largest over smallest", "Scatter of steps, set 3 (mm)",
        "Distance from straight lines, set 2 (px)",
    ]  # fmt: skip
    return Table(
        columns(names, rows),
        "RMS residuals as in Table 2.2, with Gaussian noise added to the "
        "corners on each axis, and with a smooth surface between corners. "
        "Last columns: scatter of the steps of Fig. 2.6, and distance from "
        "straight lines near the edge of the boards, as in section 2.5.3. "
        "Medians over simulated runs with 95 % intervals.",
    )


def agreement(redrawn, rendered):
    """Check whether redrawn runs differ from rendered ones: rank tests, Holm.

    A large p-value does not show equality, so the text gives the ratios of
    the medians.
    """
    from scipy.stats import mannwhitneyu

    p, ratios = [], []
    for method, zoom in product(METHODS, ZOOMS):
        name = f"{method}.calibration.corrected.rms_px"
        both = [with_worst(ran.column(name, zoom=zoom)) for ran in (redrawn, rendered)]
        p.append(mannwhitneyu(*both).pvalue)
        ratios.append(np.median(both[0]) / np.median(both[1]))
    smallest = min(holm(p))
    return Check(
        bool(smallest > SIGNIFICANCE),
        "no difference shown between residuals of redrawn and rendered "
        f"runs: smallest corrected p of {len(p)} rank tests {smallest:.2g}; "
        f"medians of redrawn runs are {min(ratios):.2f} to {max(ratios):.2f} "
        f"times those of {len(both[1])} rendered ones",
    )
