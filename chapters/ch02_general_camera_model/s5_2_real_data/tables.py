"""Table 2.2, and what stands beside it: statistics, coverage, other corners."""

from __future__ import annotations

from itertools import product

import numpy as np

from chapters.ch02_general_camera_model.s5_2_real_data.results import (
    covered,
    image_share,
)
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


@table(
    "ext_table_2_2_seeds",
    needs=("table_2_2_redrawn", "table_2_2_rendered"),
    evidence="rendered",
)
def ext_table_2_2_seeds(results):
    """Redrawn seeds beside rendered ones, every method, RMS and mean."""
    names = ["Method", "Error type", "Corners", "Seeds"]
    rows = [
        [NAMES[method], label, corners, results[name].trials_per_condition]
        + [
            Measured.median_or_none(
                results[name].column(
                    f"{method}.calibration.corrected.{statistic}_px", zoom=zoom
                )
            )
            for zoom in ZOOMS
        ]
        for method in METHODS
        for statistic, label in {"rms": "RMS", "mean": "mean"}.items()
        for name, corners in SOURCES.items()
    ]
    rendered = results["table_2_2_rendered"].trials_per_condition
    return Table(
        columns(names + [f"Set {zoom} (px)" for zoom in ZOOMS], rows),
        "Residuals as in Table 2.2. Redrawn corners err as those found in "
        f"rendered pictures do; of {rendered} rendered seeds, too few for an "
        "interval, the range stands in its place.",
        agreement(*(results[name] for name in SOURCES)),
    )


@table(
    "ext_table_2_2_pictures",
    needs=("table_2_2_redrawn", "table_2_2_rendered"),
    evidence="rendered",
)
def ext_table_2_2_pictures(results):
    """What the detector got and gave, set by set."""
    redrawn, rendered = (results[name] for name in SOURCES)
    asked = rendered.settings["calibration_images"]
    names = [
        "Set", "Boards photographed", "Boards found",
        "Corner error, rendered (px)", "Corner error, redrawn (px)",
        "Distortion over the boards (1)",
    ]  # fmt: skip
    rows = [
        [
            zoom,
            asked * rendered.trials_per_condition,
            int(rendered.column("found.calibration", zoom=zoom).sum()),
            Measured.median_or_none(rendered.column("corner_error_px", zoom=zoom)),
            Measured.median_or_none(redrawn.column("corner_error_px", zoom=zoom)),
            Measured.median_or_none(redrawn.column("distortion_level", zoom=zoom)),
        ]
        for zoom in ZOOMS
    ]
    return Table(
        columns(names, rows),
        "Calibration pictures of the rendered seeds, and how far corners are "
        "from the truth (RMS distance; medians over seeds, with the range of "
        "rendered and the 95 % interval of redrawn seeds). Distortion: the "
        "largest distance of a corner from where a pinhole of the same scale "
        "would see it, over the pinhole's radius.",
    )


def peers(results):
    """(words, seeds, method) on the same corners: the thesis's two, and what else."""
    as_found, smooth = (
        ZoomCase(results, {"interpolation": option})
        for option in ("homographic", "smooth")
    )
    return [
        (NAMES["parametric"], as_found, "parametric"),
        # Corners do not depend on what the generic method does between them.
        (FISHEYE, smooth, "opencv_fisheye"),
        (NAMES["generic_as_printed"], as_found, "generic_as_printed"),
        (f"{NAMES['generic_as_printed']}, smooth", smooth, "generic_as_printed"),
        (NAMES["generic_well_conditioned"], as_found, "generic_well_conditioned"),
    ]


@table("ext_table_2_2_coverage", needs=OF_SEEDS, evidence="rendered")
def ext_table_2_2_coverage(results):
    """Every error with what it is measured on."""
    names = [
        "Set", "Method", "Seeds", "Failed", "RMS (px)", "RMS held out (px)",
        "Corners found", "Corners without a ray",
        "Share of picture with a ray (%)",
    ]  # fmt: skip
    rows = []
    for zoom, (words, case, method) in product(ZOOMS, peers(results)):
        trials, held_out = (
            case.column(f"{method}.{use}.corrected.rms_px", zoom)
            for use in ("calibration", "held_out")
        )
        rows.append(
            [zoom, words, len(trials), int(np.isnan(trials).sum())]
            + [Measured.median_or_none(found) for found in (trials, held_out)]
            + [*covered(case, method, zoom), image_share(case, method, zoom)]
        )
    return Table(
        columns(names, rows),
        "Residuals in px of the corrected view, and what they are measured "
        "on: a corner without a ray is in no residual. Failed: no camera, or "
        "none with rays for any board. Held out: pictures that were not "
        "calibrated with. Smooth: between corners, a smooth surface in place "
        "of homographies.",
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
