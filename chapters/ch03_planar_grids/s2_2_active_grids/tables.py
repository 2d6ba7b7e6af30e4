"""One pixel by hand, the window, the bits, the edges, and blooming as tables."""

from __future__ import annotations

import numpy as np

from chapters.ch03_planar_grids.s2_2_active_grids.results import (
    METHODS,
    QUESTIONS,
    bloom_errors,
    pixel_rows,
    worked,
)
from chapters.ch03_planar_grids.s2_2_active_grids.trials.blooming import (
    EXPOSURES,
    SHARES,
)
from chapters.ch03_planar_grids.s2_2_active_grids.trials.codes import SLANT_PX
from chapters.ch03_planar_grids.s2_2_active_grids.trials.decoding import BLURS_PX
from repro.judge.statistics import median_interval
from repro.run.experiment import table
from repro.run.outcomes import Check, Measured, Table

CELL_MM = (38.0, 28.5)
AGREE_MM = 1e-3


@table("ext_one_pixel", needs=("ext_active_grid",), evidence="rendered")
def ext_one_pixel(results):
    """The twenty grey values of one pixel, and what follows from them."""
    view = results["ext_active_grid"]
    rows = pixel_rows(view)
    found = [worked(view, axis, w) for axis, w in zip("xy", CELL_MM, strict=True)]
    steps = {
        "Gray code": "gray",
        "cell b": "cell",
        "phase φ (deg)": "phi",
        "modulation B (grey levels)": "swing",
        "noise s (grey levels)": "noise",
        "location (b + d) w (mm)": "location",
        "σ (mm)": "sigma",
    }
    rows.append(("width of a cell w (mm)", *CELL_MM))
    for name, key in steps.items():
        scale = np.degrees(1) if key == "phi" else 1
        pair = [f[key] if key == "gray" else scale * f[key] for f in found]
        rows.append((name, *pair))
    decoder = {
        "decoder: location (mm)": "location_mm",
        "decoder: σ (mm)": "sigma_mm",
        "true location (mm)": "true_mm",
    }
    for name, key in decoder.items():
        pair = [float(view.column(f"pixel.{a}.{key}")[0]) for a in "xy"]
        rows.append((name, *pair))
    apart = max(
        abs(f["location"] - view.column(f"pixel.{a}.location_mm")[0])
        for a, f in zip("xy", found, strict=True)
    )
    names = ("what", "along x", "along y")
    return Table(
        dict(zip(names, map(list, zip(*rows, strict=True)), strict=True)),
        "From twenty grey values to a place: one pixel of the view above, decoded "
        "alone. The upper rows are read from the pictures, the middle ones worked "
        "out by hand, the last ones are the decoder's and the truth.",
        Check(
            bool(apart < AGREE_MM),
            f"by hand and by the decoder differ by {apart:.1e} mm at most",
        ),
    )


@table("ext_window", needs=("ext_window",), evidence="rendered")
def ext_window(results):
    """What the 7 x 7 window does to scatter and to bias."""
    ran = results["ext_window"]
    columns = {"cells": [], "steps": []}
    names = {
        "σ of a pixel (mm)": "raw.sigma_mm",
        "RMS error of a pixel (mm)": "raw.rms_mm",
        "σ, 7 × 7 (mm)": "smooth.sigma_mm",
        "RMS error, 7 × 7 (mm)": "smooth.rms_mm",
        "without noise: a pixel (mm)": "raw.bias_mm",
        "without noise: 7 × 7 (mm)": "smooth.bias_mm",
    }
    columns |= {name: [] for name in names}
    for condition in ran.conditions:
        given = {k: condition[k] for k in ("cells", "steps")}
        for name in given:
            columns[name].append(given[name])
        for name, key in names.items():
            columns[name].append(float(ran.column(key, **given)[0]))
    return Table(
        columns,
        "Averaging over 7 × 7 pixels divides the scatter by seven, and takes the "
        "ripple of the gamma away where a cell is about four windows wide. One view of "
        "a monitor with a gamma of 2.2; RMS errors per axis over all pixels that the "
        "decoder keeps.",
    )


@table("ext_wrap_rule", needs=("ext_wrap_rule",), evidence="rendered")
def ext_wrap_rule(results):
    """Gross errors at cell edges, with and without a rule."""
    ran = results["ext_wrap_rule"]
    total = {
        name: [int(ran.column(f"{blur}.{name}").sum()) for blur in BLURS_PX]
        for name in ("pixels", "printed", "decoder")
    }
    return Table(
        {
            "blur (px)": list(BLURS_PX),
            "pixels": total["pixels"],
            "off by a cell, (3.24) alone": total["printed"],
            "off by a cell, decoder": total["decoder"],
        },
        "Without a rule at the edges of cells, (3.24) is off by a whole cell in some "
        "pixels of every picture. Counted are pixels more than half a cell from the "
        "truth, with noise of 4 grey levels, each decoded alone.",
    )


@table("ext_bits", needs=("exp_c3_inverse_helps",), evidence="synthetic")
def ext_bits(results):
    """Share of wrong bits near edges, by blur and noise."""
    ran = results["exp_c3_inverse_helps"]
    slants = {slant: name for name, slant in SLANT_PX.items()}
    columns = {"edges": [], "light": []}
    columns |= {"blur (px)": [], "noise (grey levels)": []}
    columns |= {"inverse (%)": []}
    columns |= {f"{name} (%)": [] for name in QUESTIONS["bit_threshold"]}
    for condition in ran.conditions:
        pixels = ran.column("pixels", **condition).sum()
        columns["edges"].append(slants[condition["slant_px"]])
        columns["light"].append(condition["light"])
        columns["blur (px)"].append(condition["blur_px"])
        columns["noise (grey levels)"].append(condition["noise_grey"])
        for name in ("inverse", *QUESTIONS["bit_threshold"]):
            wrong = ran.column(f"{name}.wrong", **condition).sum()
            columns[f"{name} (%)"].append(float(100 * wrong / pixels))
    return Table(
        columns,
        "An inverse makes fewer wrong bits than any threshold, above all where the "
        "light falls off and the threshold is one grey value. Wrong bits among the "
        "pixels within 2 px of an edge.",
    )


@table("ext_blooming", needs=("exp_c3_blooming",), evidence="rendered")
def ext_blooming(results):
    """Errors in too much light, with and without spilling."""
    ran = results["exp_c3_blooming"]
    columns = {"light (full wells)": [], "spills (%)": []}
    columns |= {f"{name} (px)": [] for name in METHODS}
    columns |= {"pixels located (%)": [], "corners located (%)": []}
    for exposure in EXPOSURES:
        for share in SHARES:
            columns["light (full wells)"].append(exposure)
            columns["spills (%)"].append(round(100 * share))
            for name in METHODS:
                errors = bloom_errors(ran, name, exposure, share)
                found = median_interval(errors[np.isfinite(errors)])
                columns[f"{name} (px)"].append(
                    Measured(found.value, found.low, found.high)
                    if np.isfinite(errors).any()
                    else None
                )
            for name, column in (
                ("active grid", "pixels located (%)"),
                ("derivative", "corners located (%)"),
            ):
                shares = bloom_errors(ran, name, exposure, share, "share")
                columns[column].append(float(100 * np.median(shares)))
    return Table(
        columns,
        "Corners of a chessboard bear too much light well; the active grid is masked "
        "where its sines are cut off. RMS errors of what was located, medians over the "
        "trials that located anything; shares are medians over all trials.",
    )
