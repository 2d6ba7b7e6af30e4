"""The claims of section 3.2.2, tested as worded in the registry."""

from functools import partial

import numpy as np

from chapters.ch03_planar_grids.s2_2_active_grids.results import (
    AMPLITUDES,
    CLIPPED,
    PERCENT_OF_PERIOD,
    bit_counts,
    bloom_errors,
    bloom_growth,
    misfit_ratio,
    profile_column,
    third_grey,
)
from chapters.ch03_planar_grids.s2_2_active_grids.trials.blooming import (
    CORNER_METHODS,
    EXPOSURES,
)
from chapters.ch03_planar_grids.s2_2_active_grids.trials.profile import DATA_SHEET_GAMMA
from repro.judge.statistics import (
    FAILS,
    HOLDS,
    UNDECIDED,
    all_of,
    bootstrap,
    mcnemar,
    proportion,
    wins,
    with_worst,
)
from repro.run.experiment import claim, numbers
from repro.run.outcomes import Reading, Value

ROUNDING_RAD = 1e-12
MIN_RATIO = 3.0
MAX_THIRD_GREY = 0.43
MAX_ERROR_PERCENT, ABOUT_TEN_GREY = 0.1, (9.0, 11.0)
MIN_BIT_RATIO, SIGNIFICANCE = 2.0, 0.01
# Variance of a threshold's own noise, over that of a pixel.
NOISE_OF_THRESHOLD = {
    "one grey value": 0.0,
    "white and black": 1 / 2,
    "mean of the sines": 1 / 4,
}


def _range(values):
    return f"{np.min(values):.3g} to {np.max(values):.3g}"


def _in_views(held, found, unit, of, views):
    """Reading of what held in some of the views, with the median of what was found.

    unit: of what was found; of: what it is, in words; views: what the views are called
    after it.
    """
    share = proportion(held)
    return Reading.of_seeds(
        held,
        float(np.median(found)),
        unit,
        f"{of}; held in {100 * share.value:.0f} % of {views} "
        f"({100 * share.low:.0f} to {100 * share.high:.0f})",
    )


@claim(
    "c3_single_sine_poor",
    needs=("fig_3_9",),
    evidence="rendered",
    readings=("camera_response",),
)
def judge_single_sine(results, options):
    """RMS0 at least three times RMS1, at the data-sheet gamma."""
    ratio = misfit_ratio(results["fig_3_9"], options["camera_response"])
    of = f"ratio of the misfits, {_range(ratio)} over {len(ratio)} views"
    return _in_views(ratio >= MIN_RATIO, ratio, "1", of, "them")


@claim(
    "c3_third_marginal",
    needs=("fig_3_9",),
    evidence="rendered",
    readings=("camera_response", "sine_amplitude"),
)
def judge_third_marginal(results, options):
    """Order 3 has at most 0.43 grey levels, at the data-sheet gamma."""
    ran, camera = results["fig_3_9"], options["camera_response"]
    third = third_grey(ran, camera, AMPLITUDES[options["sine_amplitude"]])
    of = (
        f"RMS of order 3, {_range(third)} grey levels over {len(third)} views; "
        f"{MAX_THIRD_GREY} are 5 % of a misfit whose rest is the thesis's"
    )
    return _in_views(third <= MAX_THIRD_GREY, third, "grey levels", of, "the views")


@numbers("fig_3_9", needs=("fig_3_9",), evidence="rendered")
def values_of_fits(results):
    """Misfits with zero, one and two harmonics, medians over the views."""
    misfits = partial(profile_column, results["fig_3_9"], "linear", DATA_SHEET_GAMMA)
    return {
        f"fig3_9_rms_h{k}": Value.of_seeds(misfits(f"rms_{k}"), "grey levels")
        for k in range(3)
    }


@claim(
    "c3_radiometric_ok",
    needs=("exp_c3_radiometric_ok",),
    evidence="synthetic",
    readings=("profile_rest",),
)
def judge_radiometric(results, options):
    """Error at most 0.1 % of a period, at a misfit of about 10 grey levels."""
    ran = results["exp_c3_radiometric_ok"].one(rest=options["profile_rest"])
    error = PERCENT_OF_PERIOD * ran.column("largest_rad")[0]
    misfit, (low, high) = ran.column("misfit_grey")[0], ABOUT_TEN_GREY
    return Reading.of(
        HOLDS if error <= MAX_ERROR_PERCENT and low <= misfit <= high else FAILS,
        float(error),
        "% of a period",
        "largest error over the period and all positions of the orders, at 80 grey "
        f"levels of order 1; misfit of one sine {misfit:.2f} grey levels, put in with "
        "the profile and not found",
    )


@claim("c3_offset_cancels", needs=("exp_c3_offset_cancels",), evidence="analytic")
def judge_offset(results):
    """Phase change below 1e-12 rad for offsets of up to 50 grey levels."""
    ran = results["exp_c3_offset_cancels"]
    formula, decoder = (ran.column(f"{n}_rad").max() for n in ("formula", "decoder"))
    return Reading.of(
        HOLDS if formula < ROUNDING_RAD else FAILS,
        float(formula),
        "rad",
        "largest change in double precision; the decoder, on pictures "
        f"of 8 bits, changes by {decoder:.1g} rad",
    )


@claim("c3_vignetting", needs=("exp_c3_vignetting",), evidence="analytic")
def judge_vignetting(results):
    """Phase change below 1e-12 rad for gains of 0.2 to 1."""
    ran = results["exp_c3_vignetting"]
    formula, sixteen, eight = (
        ran.column(f"{name}_rad").max()
        for name in ("formula", "decoder_16", "decoder_8")
    )
    return Reading.of(
        HOLDS if formula < ROUNDING_RAD else FAILS,
        float(formula),
        "rad",
        "largest change in double precision; by the decoder after "
        f"rounding {sixteen:.1g} rad in 16 bits, {eight:.1g} rad in 8",
    )


@claim("c3_gray_single", needs=("exp_c3_gray_single",), evidence="analytic")
def judge_gray_single(results):
    """Neighbours differ in one bit; one wrong at its edge moves by one cell."""
    ran = results["exp_c3_gray_single"].select()
    changed, shift, elsewhere, binary = (
        int(ran.column(name).max())
        for name in ("bits_changed", "shift", "shift_elsewhere", "binary_shift")
    )
    return Reading.of(
        HOLDS if changed == 1 and shift <= 1 else FAILS,
        float(shift),
        "cells",
        f"all {int(ran.column('tested').sum())} edges of codes of 1 to "
        f"{len(ran.conditions)} bits, as decoded; a wrong bit away from its "
        f"edge moves by up to {elsewhere} cells, one of plain "
        f"binary at its edge by up to {binary}",
    )


@claim(
    "c3_inverse_helps",
    needs=("exp_c3_inverse_helps",),
    evidence="synthetic",
    readings=("bit_edges", "bit_light", "bit_threshold"),
)
def judge_inverse(results, options):
    """Half as many wrong bits as a threshold near edges, McNemar p < 0.01."""
    wrong, paired, pixels, only, other = bit_counts(
        results["exp_c3_inverse_helps"],
        options["bit_edges"],
        options["bit_light"],
        options["bit_threshold"],
    )
    ratio = bootstrap(
        lambda a, b: a.sum(axis=-1) / np.maximum(b.sum(axis=-1), 1),
        wrong,
        paired,
        paired=True,
    )
    lone = np.repeat([True, False], [only, other])
    p = mcnemar(~lone, lone)
    decision = ratio.above(np.nextafter(MIN_BIT_RATIO, 0))
    anywhere = (options["bit_edges"], options["bit_light"]) == ("anywhere", "even")
    # The inverse has twice the slope, and the noise of two pixels.
    expected = np.sqrt(2 * (1 + NOISE_OF_THRESHOLD[options["bit_threshold"]]))
    doubt = f"; cannot hold as read: theory gives {expected:.2f}" if anywhere else ""
    return Reading.of(
        UNDECIDED if decision == HOLDS and p >= SIGNIFICANCE else decision,
        ratio,
        "1",
        f"{wrong.sum():.0f} wrong bits against {paired.sum():.0f} of "
        f"{pixels.sum():.0f}, all levels of blur and noise; McNemar p = {p:.1g}{doubt}",
    )


def growth_gap(ran, less, more):
    """Difference in growth by blooming between two errors: Estimate, px.

    less, more: (method, exposure) or (method, exposure, name), as of `bloom_growth`.
    """
    growths = (with_worst(bloom_growth(ran, *one)) for one in (less, more))
    return bootstrap(
        lambda a, b: np.median(b, axis=-1) - np.median(a, axis=-1),
        *growths,
        paired=True,
    )


@claim(
    "c3_blooming",
    needs=("exp_c3_blooming",),
    evidence="rendered",
    readings=("clipped_sines",),
)
def judge_blooming(results, options):
    """At the corners the active grid has the smaller error, and it grows less."""
    ran, grid = results["exp_c3_blooming"], CLIPPED[options["clipped_sines"]]
    won, gaps = [], []
    for method in CORNER_METHODS:
        pairs = [
            tuple(bloom_errors(ran, name, exposure, 1.0) for name in (grid, method))
            for exposure in EXPOSURES
        ]
        won += wins(pairs)
        gaps += [growth_gap(ran, (grid, e), (method, e)) for e in EXPOSURES]
    ratios = [w.ratio.value for w in won]
    located = (bloom_errors(ran, grid, e, 1.0, "share") for e in EXPOSURES)
    return Reading.of(
        all_of([w.decision for w in won] + [gap.above(0.0) for gap in gaps]),
        float(min(ratios)),
        "1",
        "smallest ratio of medians, corner over active grid; ratios "
        + ", ".join(f"{r:.2g}" for r in ratios)
        + " (saddle point at 1.05 and 1.2 full wells, then derivative); "
        "growth by spilling, corner less active grid: "
        + ", ".join(f"{gap.value:.2g}" for gap in gaps)
        + " px; share of the corners that the grid located: "
        + ", ".join(f"{np.mean(share):.2f}" for share in located),
    )


@claim("c3_midpoints_blooming", needs=("exp_c3_blooming",), evidence="rendered")
def judge_midpoints(results):
    """Midpoints have a smaller error than edges of one image, and it grows less."""
    ran = results["exp_c3_blooming"]
    pairs = [
        tuple(
            bloom_errors(ran, "edges", e, 1.0, n) for n in ("midpoint", "one picture")
        )
        for e in EXPOSURES
    ]
    won = wins(pairs)
    gaps = [
        growth_gap(ran, ("edges", e, "midpoint"), ("edges", e, "one picture"))
        for e in EXPOSURES
    ]
    ratios = [w.ratio.value for w in won]
    errors = (f"{np.median(b):.2f} and {np.median(a):.2f}" for a, b in pairs)
    return Reading.of(
        all_of([w.decision for w in won] + [gap.above(0.0) for gap in gaps]),
        float(min(ratios)),
        "1",
        "smallest ratio of medians, one picture over midpoint; medians of both (px) "
        f"at 1.05 and 1.2 full wells: {', '.join(errors)}; growth by spilling, one "
        f"picture less midpoint: {', '.join(f'{gap.value:.2g}' for gap in gaps)} px",
    )


@claim("c3_20_patterns", needs=("exp_c3_20_patterns",), evidence="analytic")
def judge_twenty(results):
    """Twenty patterns, and every pixel of the display decoded to itself."""
    ran = results["exp_c3_20_patterns"].select()
    count = ran.column("patterns")
    wrong, pixels = (int(ran.column(name).sum()) for name in ("not_own", "pixels"))
    holds = (ran.column("bits") == 3).all() and (count == 20).all() and wrong == 0
    return Reading.of(
        HOLDS if holds else FAILS,
        float(count.max()),
        "patterns",
        f"{wrong} of {pixels} pixels of {len(ran.conditions)} monitors are decoded to "
        "another pixel's place, each from what is sent to the monitor in 8 bits",
    )


@numbers("sec_3_2_2", needs=("exp_c3_20_patterns",), evidence="analytic")
def values_of_plan(results):
    """Composition of the default plan of patterns."""
    first = results["exp_c3_20_patterns"].select()
    names = {
        "s3_2_2_patterns": "patterns",
        "s3_2_2_binary": "binary",
        "s3_2_2_sin": "sinusoidal",
        "s3_2_2_phase": "phase_step_deg",
        "s3_2_2_filter": "window_px",
    }
    found = {own: Value(float(first.column(n)[0])) for own, n in names.items()}
    return found | {"s3_2_2_cells": Value(2 ** float(first.column("bits")[0]))}
