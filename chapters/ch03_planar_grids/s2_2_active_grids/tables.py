"""One pixel by hand, the window, the bits, the edges, and blooming as tables."""

from itertools import product

import numpy as np

from chapters.ch03_planar_grids.s2_2_active_grids.results import (
    EDGES,
    METHODS,
    THRESHOLDS,
    bloom_errors,
    of_pixel,
    pixel_rows,
    worked,
)
from chapters.ch03_planar_grids.s2_2_active_grids.trials.blooming import (
    EXPOSURES,
    SHARES,
)
from chapters.ch03_planar_grids.s2_2_active_grids.trials.codes import SLANT_PX
from chapters.ch03_planar_grids.s2_2_active_grids.trials.decoding import BLURS_PX
from repro.run.columns import columns
from repro.run.experiment import table
from repro.run.outcomes import Check, Measured, Table

CELL_MM = (38.0, 28.5)
AGREE_MM = 1e-3
# What the trials of blooming call it -> its columns.
BLOOMED = {method: method for method in METHODS} | {
    "masked": "active grid, masked",
    "all pixels": "all pixels, masked",
}


@table("ext_one_pixel", needs=("ext_active_grid",), evidence="rendered")
def ext_one_pixel(results):
    """The twenty grey values of one pixel, and what follows from them."""
    view = results["ext_active_grid"]
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
    scales = {"phi": np.degrees(1)}
    decoder = {
        "decoder: location (mm)": "location_mm",
        "decoder: σ (mm)": "sigma_mm",
        "true location (mm)": "true_mm",
    }
    rows = [
        *pixel_rows(view),
        ("width of a cell w (mm)", *CELL_MM),
        *(
            (name, *(scales[key] * f[key] if key in scales else f[key] for f in found))
            for name, key in steps.items()
        ),
        *(
            (name, *(of_pixel(view, axis, key) for axis in "xy"))
            for name, key in decoder.items()
        ),
    ]
    apart = max(
        abs(f["location"] - of_pixel(view, axis, "location_mm"))
        for axis, f in zip("xy", found, strict=True)
    )
    return Table(
        columns(("what", "along x", "along y"), rows),
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
    names = {
        "σ of a pixel (mm)": "raw.sigma_mm",
        "RMS error of a pixel (mm)": "raw.rms_mm",
        "σ, 7 × 7 (mm)": "smooth.sigma_mm",
        "RMS error, 7 × 7 (mm)": "smooth.rms_mm",
        "without noise: a pixel (mm)": "raw.bias_mm",
        "without noise: 7 × 7 (mm)": "smooth.bias_mm",
    }
    rows = [
        (
            c["cells"],
            c["steps"],
            *(float(ran.column(k, **c)[0]) for k in names.values()),
        )
        for c in ran.conditions
    ]
    return Table(
        columns(("cells", "steps", *names), rows),
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
    names = ("inverse", *THRESHOLDS)

    def shares(condition):
        trials = ran.one(**condition)
        pixels = trials.column("pixels").sum()
        return (100 * trials.column(f"{n}.wrong").sum() / pixels for n in names)

    rows = [
        (slants[c["slant_px"]], c["light"], c["blur_px"], c["noise_grey"], *shares(c))
        for c in ran.conditions
    ]
    heads = ("edges", "light", "blur (px)", "noise (grey levels)")
    return Table(
        columns((*heads, *(f"{name} (%)" for name in names)), rows),
        "An inverse makes fewer wrong bits than any threshold, above all where the "
        "light falls off and the threshold is one grey value. Wrong bits among the "
        "pixels within 2 px of an edge.",
    )


@table("ext_blooming", needs=("exp_c3_blooming",), evidence="rendered")
def ext_blooming(results):
    """Errors in too much light, with and without spilling."""
    ran = results["exp_c3_blooming"]
    rows = [
        (
            exposure,
            round(100 * share),
            *(_of_located(bloom_errors(ran, n, exposure, share)) for n in BLOOMED),
            *(
                float(100 * np.median(bloom_errors(ran, n, exposure, share, "share")))
                for n in BLOOMED
            ),
        )
        for exposure, share in product(EXPOSURES, SHARES)
    ]
    names = (
        "light (full wells)",
        "spills (%)",
        *(f"{name} (px)" for name in BLOOMED.values()),
        *(f"{name}, located (%)" for name in BLOOMED.values()),
    )
    return Table(
        columns(names, rows),
        "RMS errors at the corners in too much light, by methods that localise them "
        "in a chessboard and by an active grid, with all sines kept and with those "
        "masked that are cut off; then of all pixels of the latter. Of what was "
        "located, medians over the trials that located anything; shares are medians "
        "over all trials.",
    )


@table("ext_code_edges", needs=("exp_c3_blooming",), evidence="rendered")
def ext_code_edges(results):
    """Edges of the Gray code in too much light, in one picture and midway."""
    ran = results["exp_c3_blooming"]
    rows = [
        (
            exposure,
            round(100 * share),
            *(
                Measured.median(bloom_errors(ran, "edges", exposure, share, name))
                for name in EDGES
            ),
        )
        for exposure, share in product(EXPOSURES, SHARES)
    ]
    names = ("light (full wells)", "spills (%)", *(f"{name} (px)" for name in EDGES))
    return Table(
        columns(names, rows),
        "The overflow of a bright stripe moves an edge of the Gray code in a pattern "
        "and, by as much the other way, in its inverse, as far as both stripes are as "
        "wide. RMS distance of the edges across the columns from their true places, "
        "in one picture and midway between a picture and its inverse; medians over "
        "the trials.",
    )


def _of_located(errors):
    """Median of the trials that located anything; None where none did."""
    located = errors[np.isfinite(errors)]
    return Measured.median(located) if len(located) else None
