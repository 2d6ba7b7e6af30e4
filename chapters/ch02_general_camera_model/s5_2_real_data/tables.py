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
# As in the thesis: what a row is called there, and in the ledger's ids.
ROWS = (("parametric", "persp"), ("generic_as_printed", "gen"))
STATISTICS = {"rms": "RMS", "sd": "SD"}
FISHEYE = "OpenCV fisheye"


@table(
    "table_2_2", needs=("table_2_2_redrawn", "table_2_2_rendered"), evidence="rendered"
)
def table_2_2(results):
    """Residuals of the calibration pictures, in px of the corrected view."""
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
        "Distortion residuals after perspective correction: medians over "
        f"{redrawn.trials_per_condition} seeds with 95 % intervals, in px of "
        "the corrected view.",
        agreement(*(results[name] for name in SOURCES)),
        printed=printed,
    )


LINES = {"parametric": "parametric", "generic_as_printed": "generic"}


@table("ext_table_2_2_readings", needs=OF_SEEDS, evidence="rendered")
def ext_table_2_2_readings(results):
    """What noise of the corners and interpolation do to the section's results."""
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
        "Noise added", "Method", "Seeds", *(f"Set {zoom} (px)" for zoom in ZOOMS),
        "Largest over smallest (1)", "Scatter of steps, set 3 (mm)",
        "Off straight lines, set 2 (px)",
    ]  # fmt: skip
    return Table(
        columns(names, rows),
        "RMS residuals as in Table 2.2, of corners to which Gaussian noise "
        "was added on each axis, and with a smooth surface between corners; "
        "scatter of the steps of Fig. 2.6, and distance of points from "
        "straight lines near the rim of the boards, as in section 2.5.3. "
        "Medians over seeds with 95 % intervals.",
    )


def agreement(redrawn, rendered):
    """Whether redrawn seeds differ from rendered ones: rank tests, Holm.

    A p-value that was not reached shows no equality: the text says how far
    the medians are apart.
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
        f"seeds: smallest p of {len(p)} rank tests, corrected, "
        f"{smallest:.2g}; medians of redrawn seeds are {min(ratios):.2f} to "
        f"{max(ratios):.2f} times those of {len(both[1])} rendered ones",
    )
