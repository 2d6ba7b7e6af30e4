"""Three cameras, four methods; and breaks of other sizes."""

from __future__ import annotations

import numpy as np

from chapters.ch03_planar_grids.s2_1_interpolation_bias.results import (
    Method,
    at_stated_pitch,
)
from chapters.ch03_planar_grids.s2_1_interpolation_bias.trials.facets import GROSS_MM
from chapters.ch03_planar_grids.s2_1_interpolation_bias.trials.interpolators import (
    METHODS,
)
from chapters.ch03_planar_grids.s2_1_interpolation_bias.trials.scenes import (
    CORNER_NOISE_PX,
)
from repro.run.columns import columns
from repro.run.experiment import table
from repro.run.outcomes import Table

RIDGE_METHODS = {
    "unknown": "interpolation, ridge unknown",
    "known, noisy": "interpolation, ridge known, corners with noise",
    "7 x 7": "decoding, 7 × 7 filter",
    "none": "decoding, no filter",
}


@table(
    "ext_interpolation_cameras",
    needs=("ext_interpolation_methods",),
    evidence="synthetic",
)
def ext_interpolation_cameras(results):
    """How much each method errs, and where noise and bias balance."""
    result = results["ext_interpolation_methods"]
    rows = []
    for camera in dict.fromkeys(c["camera"] for c in result.conditions):
        for name in METHODS:
            one = Method(result, camera, name)
            balance = one.balance_mm
            rows.append(
                (
                    camera,
                    name,
                    at_stated_pitch(one, "bias_mm"),
                    at_stated_pitch(one, "bias_px"),
                    one.slope,
                    at_stated_pitch(one, "noise_px"),
                    balance,
                    balance and balance * one.px_per_mm,
                )
            )
    names = (
        "camera",
        "method",
        "bias at 20 mm (mm)",
        "bias at 20 mm (px)",
        "slope (1)",
        f"noise of {CORNER_NOISE_PX} px passed on (px)",
        "pitch at which both are alike (mm)",
        "square there (px)",
    )
    return Table(
        columns(names, rows),
        "Bias of four methods before three cameras, with a grid of 300 × 300 "
        "mm. Pictures are 1000 px wide, the mirror's 1280. With squares of the "
        "pitch in the last two columns, noise of the corners and bias err alike: "
        "narrower ones gain nothing in a single picture. Empty: alike at no pitch "
        "of the sweep, the larger at 20 mm being larger throughout. The slope of "
        "the smooth surface is bent by a floor of our own, of 0.015 px.",
    )


@table(
    "ext_breaks",
    needs=("exp_c3_interp_discontinuous", "ext_interpolation_breaks"),
    evidence="rendered",
)
def ext_breaks(results):
    """Interpolation and decoding near ridges of three sizes."""
    rows = []
    for name in ("exp_c3_interp_discontinuous", "ext_interpolation_breaks"):
        result = results[name]
        for condition in result.conditions:
            jump = np.median(result.column("jump_mm", **condition))
            trusted = np.median(result.column("trusted", **condition))
            for method, label in RIDGE_METHODS.items():
                rms, median, gross = (
                    float(np.median(result.column(f"{method}.{key}", **condition)))
                    for key in ("rms_mm", "median_mm", "gross")
                )
                rows.append(
                    (
                        condition["facet_deg"],
                        float(jump),
                        label,
                        rms,
                        median,
                        100 * gross,
                        float(100 * trusted),
                    )
                )
    names = (
        "facet turned by (deg)",
        "jump (mm)",
        "method",
        "RMS error (mm)",
        "median error (mm)",
        f"off by more than {GROSS_MM:g} mm (%)",
        "pixels trusted (%)",
    )
    return Table(
        columns(names, sorted(rows, key=lambda row: row[0])),
        "Errors near the ridge of two mirrors, over the pixels within one "
        "square of 20 mm that the decoder trusts, giving them a place; medians "
        "over trials. A facet is one of the mirrors, and the jump how far apart on "
        "the monitor the two sides of the ridge look. The "
        "claim is judged at the middle size. Corners are exact, or have a noise "
        f"of {CORNER_NOISE_PX} px.",
    )
