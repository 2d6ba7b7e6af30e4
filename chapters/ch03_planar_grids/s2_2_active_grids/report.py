"""Results of this page read: values of the prose, figures, tables, judgements."""

from functools import partial
from itertools import product

import numpy as np

from chapters.ch03_planar_grids.s2_2_active_grids.experiment import (
    AMPLITUDE_GREY,
    DATA_SHEET_GAMMA,
    HARMONICS,
    SLANT_PX,
)
from chapters.ch03_planar_grids.s2_2_active_grids.scenes import (
    CORNER_METHODS,
    EXPOSURES,
    SHARES,
)
from raxel.sets import patterns_of, plan_of_cells
from raxel.sets.patterns import pattern_picture
from repro.page import new_figure, series, value
from repro.run import (
    FAILS,
    HOLDS,
    UNDECIDED,
    Check,
    Drawing,
    Measured,
    Reading,
    Table,
    Value,
    all_of,
    bootstrap,
    claim,
    columns,
    figure,
    mcnemar,
    median_interval,
    numbers,
    proportion,
    table,
    wins,
    with_worst,
)

# Results of section 3.2.2 for figures, tables, claims and text.


PERCENT_OF_PERIOD = 100 / (2 * np.pi)
# Options of questions that the text does not answer, the primary one first.
AMPLITUDES = {"80 grey levels": 80.0, "50 grey levels": 50.0}
THRESHOLDS = ("one grey value", "white and black", "mean of the sines")
METHODS = (*CORNER_METHODS, "active grid")
# Option of the question clipped_sines -> name of the active grid in a trial.
CLIPPED = {"kept": "active grid", "left out": "masked"}


def profile_column(result, camera, gamma, name):
    """A value (views,) of the imaged period."""
    return result.column(f"{camera}.{gamma}.{name}")


def misfit_ratio(result, camera, gamma=DATA_SHEET_GAMMA):
    """RMS misfit (views,) without further harmonics over that with one."""
    rms = [profile_column(result, camera, gamma, f"rms_{k}") for k in (0, 1)]
    return rms[0] / rms[1]


def third_grey(result, camera, amplitude_grey=AMPLITUDE_GREY):
    """RMS (views,) of order 3 for a sine of this amplitude, in grey levels.

    Its square is the drop of the squared misfit. All orders are proportional to
    the amplitude.
    """
    without, with_it = (
        profile_column(result, camera, DATA_SHEET_GAMMA, f"rms_{k}") for k in (1, 2)
    )
    return np.sqrt(without**2 - with_it**2) * amplitude_grey / AMPLITUDE_GREY


def bit_counts(result, edges, light, threshold):
    """(wrong by the threshold, wrong by the inverse, pixels): (trials,) each,
    summed over blur and noise; then the pixels that are wrong by only one of them.
    """
    trials = result.select(slant_px=SLANT_PX[edges], light=light)

    def total(name):
        return trials.column(name).reshape(len(trials.conditions), -1).sum(axis=0)

    return (
        total(f"{threshold}.wrong"),
        total("inverse.wrong"),
        total("pixels"),
        int(total(f"{threshold}.only_threshold").sum()),
        int(total(f"{threshold}.only_inverse").sum()),
    )


def bloom_errors(result, method, exposure, share, name="rms_px"):
    """RMS errors (trials,) in px, or located shares, of a method."""
    return result.column(f"{method}.{exposure}.{share}.{name}")


def bloom_growth(result, method, exposure, name="rms_px"):
    """Growth (trials,) of the error by blooming, px."""
    with_spill, without = (
        bloom_errors(result, method, exposure, share, name)
        for share in reversed(SHARES)
    )
    return with_spill - without


def name_values(open_results):
    """Name the numbers that the page quotes."""
    quoted = {
        **of_response(open_results),
        "bits.anywhere.falls_off.one_grey_value": threshold_factor(
            open_results("exp_c3_inverse_helps")
        ),
        **of_blooming(open_results("exp_c3_blooming")),
    }
    for name, number in quoted.items():
        value(name, number)


def of_response(open_results):
    """Phase errors by the published orders, in percent of a period."""
    three, five = open_results("exp_c3_radiometric_ok").by("rest").values()
    return {
        "response.three": PERCENT_OF_PERIOD * three.column("largest_rad")[0],
        "response.five": PERCENT_OF_PERIOD * five.column("largest_rad")[0],
    }


def threshold_factor(bits):
    """Wrong bits by one grey value over those by the inverse, in uneven light."""
    wrong, paired, *_ = bit_counts(bits, "anywhere", "falls off", THRESHOLDS[0])
    return wrong.sum() / max(paired.sum(), 1)


def of_blooming(bloom):
    """Errors at the corners with the most light, and the located share in percent."""
    much = EXPOSURES[-1]

    def median(method, name="rms_px"):
        return median_interval(bloom_errors(bloom, method, much, 1.0, name)).value

    return {
        "bloom.saddle": median("saddle point"),
        "bloom.active": median("active grid"),
        "bloom.located": 100 * median("active grid", "share"),
    }


# Figs. 3.8 and 3.9: patterns of an active grid, and the imaged sine.


SHOWN_PX = (512, 384)
# Of rig d200-lens, chosen from the published fits of Fig. 3.9.
CHOSEN_GAMMA = 2.0
MODELS = ("one sine", "one harmonic", "two harmonics")


@figure("fig_3_8", needs=("exp_c3_20_patterns",), evidence="analytic")
def fig_3_8(results):
    """Patterns of the vertical axis, as sent to the monitor."""
    counted = results["exp_c3_20_patterns"]
    patterns = [
        p for p in patterns_of(plan_of_cells(SHOWN_PX, phase_steps=4)) if p.axis == "y"
    ]
    drawn, axes = new_figure(2, 6, height_in=2.9)
    binary, sines = (
        [p for p in patterns if p.kind == kind] for kind in ("gray", "phase")
    )
    data = {"row": list(range(SHOWN_PX[1]))}
    for cell in axes.ravel():
        cell.axis("off")
    for panel, row, group in (("a", axes[0], binary), ("b", axes[1], sines)):
        for cell, pattern in zip(row, group, strict=False):
            picture = pattern_picture(pattern, SHOWN_PX)
            cell.imshow(picture, cmap="gray", vmin=0, vmax=255)
            name = (
                f"bit {pattern.bit}" + ("\ninverse" if pattern.inverse else "")
                if pattern.kind == "gray"
                else f"sine\n{360 * pattern.step // pattern.of}°"
            )
            cell.set_title(name, fontsize=8, loc="center", fontweight="normal")
            data[name.replace("\n", ", ")] = picture[:, 0].tolist()
        row[0].text(-0.25, 0.5, f"({panel})", transform=row[0].transAxes, ha="right")
    both = counted.column("patterns", **counted.conditions[0])[0]
    right = (len(binary), len(sines)) == (6, 4) and both == 2 * len(patterns)
    return Drawing(
        drawn,
        data,
        "The ten patterns of an active grid that encode the vertical location. "
        "(a) Three bits of a Gray code for eight cells, each with its inverse. "
        "(b) Four sines, shifted by 90° each.",
        Check(
            bool(right),
            f"{len(binary)} binary and {len(sines)} sinusoidal patterns along one "
            f"axis, {both:.0f} along both",
        ),
    )


@figure("fig_3_9", needs=("fig_3_9",), evidence="rendered")
def fig_3_9(results):
    """A period of the rectified image with its fits, and misfits over gamma."""
    ran = results["fig_3_9"]
    profile = ran.arrays("linear.profile")[0]
    position = (np.arange(len(profile)) + 0.5) / len(profile)
    drawn, (left, right) = new_figure(1, 2, height_in=3.4)
    left.plot(
        position[::3],
        profile[::3],
        linestyle="",
        marker=".",
        color="#4a4a4a",
        label="column means",
    )
    data = {"place": position.tolist(), "profile": profile.tolist()}
    gammas = ran.conditions[0]["gammas"]
    for k, name in zip(HARMONICS, MODELS, strict=True):
        fit = ran.arrays(f"linear.fit_{k}")[0]
        left.plot(position, fit, **series(k) | {"marker": ""}, label=name)
        data[name] = fit.tolist()
        rms = [np.median(profile_column(ran, "linear", g, f"rms_{k}")) for g in gammas]
        right.plot(gammas, rms, **series(k), label=name)
    left.set(
        xlabel="Position (periods)",
        ylabel="Mean grey level (grey levels)",
        title=f"(a) Gamma {DATA_SHEET_GAMMA}",
    )
    left.legend(fontsize=8)
    for gamma, name, line in (
        (DATA_SHEET_GAMMA, "judged (data sheet)", "--"),
        (CHOSEN_GAMMA, "rig d200-lens", ":"),
    ):
        right.axvline(gamma, color="#4a4a4a", linewidth=1, linestyle=line, label=name)
    right.legend(handles=right.get_lines()[len(MODELS) :], fontsize=8)
    right.set(
        yscale="log",
        xlabel="Gamma of the monitor",
        ylabel="RMS misfit (grey levels)",
        title="(b) Misfit over gamma",
    )
    return Drawing(
        drawn,
        data,
        "Imaged sinusoidal pattern and fits of Fourier series. (a) One of eight "
        "periods: column means of a rendered, undistorted and rectified image of a "
        "linear camera. (b) RMS misfit of the same models over the gamma of the "
        "monitor, medians over the views. The gamma of rig d200-lens was chosen from "
        "the figure of the thesis, so the misfit there is no result.",
    )


# Table of blooming at corners and over all pixels.


# Name in the trials of blooming -> name in the table.
BLOOMED = {method: method for method in METHODS} | {
    "masked": "active grid, masked",
    "all pixels": "all pixels, masked",
}


@table("ext_blooming", needs=("exp_c3_blooming",), evidence="rendered")
def ext_blooming(results):
    """Errors at overexposure, with and without blooming."""
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
        "Light (full wells)",
        "Overflow (%)",
        *(f"{name} (px)" for name in BLOOMED.values()),
        *(f"{name}, located (%)" for name in BLOOMED.values()),
    )
    return Table(
        columns(names, rows),
        "RMS errors at the corners at overexposure, for two corner methods on a "
        "chessboard and for an active grid with clipped sines kept or masked. Last: "
        "all pixels of the masked grid. Errors: medians over trials that located "
        "anything. Located shares: medians over all trials. Overflow: share of the "
        "excess charge that flows into neighbours.",
    )


def _of_located(errors):
    """Median of the trials that located anything, else None."""
    located = errors[np.isfinite(errors)]
    return Measured.median(located) if len(located) else None


# The claims of section 3.2.2, tested as worded in the registry.


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
