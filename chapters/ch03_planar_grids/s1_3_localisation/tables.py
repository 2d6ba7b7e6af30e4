"""The localisers of section 3.1.3 side by side."""

import numpy as np

from chapters.ch03_planar_grids.s1_3_localisation.results import (
    Swept,
    best_setting,
    excess_of_one_setting,
    gain_of_bins,
)
from chapters.shared.localiser_basin import (
    FARTHEST_START_PX,
    HALF_WINDOWS,
    LOCALISED_PX,
    OTHERS,
    farthest_start,
    results_by_localiser,
    worst_within,
)
from repro.run.columns import columns
from repro.run.experiment import table
from repro.run.outcomes import Measured, Table

LOCALISERS = ("saddle point", "derivative", "OpenCV")


@table("ext_localisers", needs=("ext_localiser_spread",), evidence="rendered")
def ext_localisers(results):
    """Error, stated SD and bias of three localisers with their defaults."""
    result = results["ext_localiser_spread"]
    names = {
        "converged": "found (%)",
        "rms_px": "RMS error per axis (px)",
        "sd_px": "stated SD (px)",
        "bias_px": "RMS error without noise (px)",
        "score_sd": "error / stated SD (1)",
        "within": "within one stated SD (%)",
    }
    rows = [
        (
            square,
            localiser,
            *(
                float(
                    (100 if "%" in name else 1)
                    * np.mean(of.column(f"{localiser}.{key}"))
                )
                for key, name in names.items()
            ),
        )
        for square, of in result.by("square_px").items()
        for localiser in LOCALISERS
    ]
    return Table(
        columns(("square (px)", "localiser", *names.values()), rows),
        "The three localisers with their default settings on the images of "
        "Fig. 3.5, means over the images. The stated SD is that of noise; "
        "what remains without noise is bias.",
    )


@table(
    "ext_localiser_choice",
    needs=("fig_3_5_derivative", "fig_3_5_saddle"),
    evidence="rendered",
)
def ext_localiser_choice(results):
    """The best single setting, and what a choice by distance would save."""
    rows = []
    for name, title in (("derivative", "derivative"), ("saddle", "saddle point")):
        swept = Swept(results[f"fig_3_5_{name}"])
        window, blur, median = best_setting(swept)
        saved = [gain_of_bins(swept, s) for s in (np.median, np.mean)]
        rows.append(
            (
                title,
                int(window),
                None if np.isnan(blur) else float(blur),
                float(median),
                100 * float(excess_of_one_setting(swept) - 1),
                *(Measured(100 * s.value, 100 * s.low, 100 * s.high) for s in saved),
            )
        )
    names = (
        "method",
        "best window (px)",
        "best blur SD (px)",
        "median residual (px)",
        "most above a bin's own best (%)",
        "saved by a choice per bin: median (%)",
        "saved: mean (%)",
    )
    return Table(
        columns(names, rows),
        "The single best setting of either method, by how much it is above "
        "the best of a bin in the worst bin (luck within the bin included), "
        "and how much of the residual a choice per bin saves: chosen on one "
        "half of the images, scored on the other, with 95 % intervals. "
        "Negative: the choice costs.",
    )


@table(
    "ext_localiser_reach",
    needs=("fig_3_11_localised", "ext_localiser_basin"),
    evidence="rendered",
)
def ext_localiser_reach(results):
    """How far off a start each localiser brings back."""
    of_localiser = results_by_localiser(results)
    widths = {name: 2 * half + 1 for name, half in HALF_WINDOWS.items()}
    widths |= {name: given["window"] for name, (_, given) in OTHERS.items()}
    rows = [
        (
            f"OpenCV, {name}" if name in HALF_WINDOWS else name,
            width,
            of_localiser[name].trials_per_condition,
            farthest_start(of_localiser[name], name),
            worst_within(of_localiser[name], name),
        )
        for name, width in widths.items()
    ]
    return Table(
        columns(
            (
                "localiser",
                "window (px)",
                "trials",
                "farthest start (px)",
                "largest error (px)",
            ),
            rows,
        ),
        "Farthest start error of the sweep up to which every corner of every "
        f"trial comes within {LOCALISED_PX} px, and the largest error from "
        f"starts up to {FARTHEST_START_PX} px. Image of Fig. 3.10(b).",
    )
