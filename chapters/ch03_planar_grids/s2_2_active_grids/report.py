"""Results of this page read: values of the prose, figures, tables, judgements."""

from itertools import product

import numpy as np

from chapters.ch03_planar_grids.s2_2_active_grids.experiment import (
    AMPLITUDE_GREY,
    DATA_SHEET_GAMMA,
    SLANT_PX,
)
from chapters.ch03_planar_grids.s2_2_active_grids.scenes import (
    CORNER_METHODS,
    EXPOSURES,
    SHARES,
)
from raxel.sets import pattern_image, patterns_of, plan_of_cells
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
# Option of the question clipped_sines -> name of the active grid in a trial.
CLIPPED = {"kept": "active grid", "left out": "masked"}


def bit_counts(result, edges, light, threshold):
    """(wrong by the threshold, wrong by the inverse, pixels): (trials,) each,
    summed over blur and noise; then the pixels that are wrong by only one of them.
    """
    trials = result.select(slant_px=SLANT_PX[edges], light=light)

    def total(*path):
        return trials.column(*path).reshape(len(trials.conditions), -1).sum(axis=0)

    return (
        total(threshold, "wrong"),
        total("inverse", "wrong"),
        total("pixels"),
        int(total(threshold, "only_threshold").sum()),
        int(total(threshold, "only_inverse").sum()),
    )


def name_values(open_results):
    """Name the numbers that the page quotes."""
    rests = open_results("exp_c3_radiometric_ok").by("rest").values()
    three, five = (rest.column("largest_rad")[0] for rest in rests)
    wrong, paired, *_ = bit_counts(
        open_results("exp_c3_inverse_helps"), "anywhere", "falls off", "one grey value"
    )
    bloom, much = open_results("exp_c3_blooming"), (EXPOSURES[-1], SHARES[-1])
    saddle, active = bloom.column(("saddle point", "active grid"), *much, "rms_px")
    located = bloom.column("active grid", *much, "share")
    quoted = {
        "response.three": PERCENT_OF_PERIOD * three,
        "response.five": PERCENT_OF_PERIOD * five,
        "bits.anywhere.falls_off.one_grey_value": wrong.sum() / max(paired.sum(), 1),
        "bloom.saddle": median_interval(saddle).value,
        "bloom.active": median_interval(active).value,
        "bloom.located": 100 * median_interval(located).value,
    }
    for name, number in quoted.items():
        value(name, number)


# Figs. 3.8 and 3.9: patterns of an active grid, and the imaged sine.


SHOWN_PX = (512, 384)
# Of rig d200-lens, chosen from the published fits of Fig. 3.9.
CHOSEN_GAMMA = 2.0
# Fitted model -> its misfit and its curve in a trial.
MODELS = {
    "one sine": ("rms_0", "fit_0"),
    "one harmonic": ("rms_1", "fit_1"),
    "two harmonics": ("rms_2", "fit_2"),
}


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
            image = pattern_image(pattern, SHOWN_PX)
            cell.imshow(image, cmap="gray", vmin=0, vmax=255)
            name = (
                f"bit {pattern.bit}" + ("\ninverse" if pattern.inverse else "")
                if pattern.kind == "gray"
                else f"sine\n{360 * pattern.step // pattern.of}°"
            )
            cell.set_title(name, fontsize=8, loc="center", fontweight="normal")
            data[name.replace("\n", ", ")] = image[:, 0].tolist()
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
    profile = ran.arrays("linear", "profile")[0]
    position = (np.arange(len(profile)) + 0.5) / len(profile)
    drawn, (left, right) = new_figure(1, 2, height_in=3.4)
    points = {"color": "#4a4a4a", "label": "column means"}
    left.plot(position[::3], profile[::3], ".", **points)
    data = {"place": position.tolist(), "profile": profile.tolist()}
    gammas = ran.conditions[0]["gammas"]
    for k, (name, (misfit, curve)) in enumerate(MODELS.items()):
        fit = ran.arrays("linear", curve)[0]
        left.plot(position, fit, **series(k) | {"marker": ""}, label=name)
        data[name] = fit.tolist()
        rms = np.median(ran.column("linear", gammas, misfit), axis=1)
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
BLOOMED = {method: method for method in (*CORNER_METHODS, "active grid")} | {
    "masked": "active grid, masked",
    "all pixels": "all pixels, masked",
}


@table("ext_blooming", needs=("exp_c3_blooming",), evidence="rendered")
def ext_blooming(results):
    """Errors at overexposure, with and without blooming."""
    ran = results["exp_c3_blooming"]
    rows = []
    for exposure, share in product(EXPOSURES, SHARES):
        errors = ran.column(tuple(BLOOMED), exposure, share, "rms_px")
        located = 100 * np.median(
            ran.column(tuple(BLOOMED), exposure, share, "share"), axis=1
        )
        row = (exposure, round(100 * share), *map(_of_located, errors), *located)
        rows.append(row)
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
    without, with_one = results["fig_3_9"].column(
        options["camera_response"], DATA_SHEET_GAMMA, ("rms_0", "rms_1")
    )
    ratio = without / with_one
    of = f"ratio of the misfits, {_range(ratio)} over {len(ratio)} views"
    return _in_views(ratio >= MIN_RATIO, ratio, "1", of, "them")


@claim(
    "c3_third_marginal",
    needs=("fig_3_9",),
    evidence="rendered",
    readings=("camera_response", "sine_amplitude"),
)
def judge_third_marginal(results, options):
    """Order 3 has at most 0.43 grey levels, at the data-sheet gamma.

    Its square is the drop of the squared misfit. All orders are proportional to
    the amplitude.
    """
    without, with_it = results["fig_3_9"].column(
        options["camera_response"], DATA_SHEET_GAMMA, ("rms_1", "rms_2")
    )
    amplitude = AMPLITUDES[options["sine_amplitude"]]
    third = np.sqrt(without**2 - with_it**2) * amplitude / AMPLITUDE_GREY
    of = (
        f"RMS of order 3, {_range(third)} grey levels over {len(third)} views; "
        f"{MAX_THIRD_GREY} are 5 % of a misfit whose rest is the thesis's"
    )
    return _in_views(third <= MAX_THIRD_GREY, third, "grey levels", of, "the views")


@numbers("fig_3_9", needs=("fig_3_9",), evidence="rendered")
def values_of_fits(results):
    """Misfits with zero, one and two harmonics, medians over the views."""
    misfits = results["fig_3_9"].column(
        "linear", DATA_SHEET_GAMMA, ("rms_0", "rms_1", "rms_2")
    )
    return {
        f"fig3_9_rms_h{k}": Value.of_seeds(misfit, "grey levels")
        for k, misfit in enumerate(misfits)
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
    formula, decoder = ran.column(("formula_rad", "decoder_rad")).max(axis=1)
    return Reading.of(
        HOLDS if formula < ROUNDING_RAD else FAILS,
        float(formula),
        "rad",
        "largest change in double precision; the decoder, on images "
        f"of 8 bits, changes by {decoder:.1g} rad",
    )


@claim("c3_vignetting", needs=("exp_c3_vignetting",), evidence="analytic")
def judge_vignetting(results):
    """Phase change below 1e-12 rad for gains of 0.2 to 1."""
    ran = results["exp_c3_vignetting"]
    names = ("formula_rad", "decoder_16_rad", "decoder_8_rad")
    formula, sixteen, eight = ran.column(names).max(axis=1)
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
    names = ("bits_changed", "shift", "shift_elsewhere", "binary_shift")
    changed, shift, elsewhere, binary = ran.column(names).max(axis=1).astype(int)
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
    doubt = f"; cannot hold: theory gives {expected:.2f}" if anywhere else ""
    return Reading.of(
        UNDECIDED if decision == HOLDS and p >= SIGNIFICANCE else decision,
        ratio,
        "1",
        f"{wrong.sum():.0f} wrong bits against {paired.sum():.0f} of "
        f"{pixels.sum():.0f}, all levels of blur and noise; McNemar p = {p:.1g}{doubt}",
    )


def growth_gap(less, more):
    """Difference in growth by blooming between two errors (2, trials): Estimate, px.

    Both errors are without and with blooming.
    """
    growths = (with_worst(with_it - without) for without, with_it in (less, more))
    return bootstrap(
        lambda a, b: np.median(b, axis=-1) - np.median(a, axis=-1),
        *growths,
        paired=True,
    )


def comparison(less, more):
    """Wins with blooming, and gaps in growth, at every exposure.

    less, more: errors (exposures, 2, trials) px, without and with blooming.
    """
    won = wins(list(zip(less[:, 1], more[:, 1], strict=True)))
    return won, [growth_gap(*pair) for pair in zip(less, more, strict=True)]


@claim(
    "c3_blooming",
    needs=("exp_c3_blooming",),
    evidence="rendered",
    readings=("clipped_sines",),
)
def judge_blooming(results, options):
    """At the corners the active grid has the smaller error, and it grows less."""
    ran, grid = results["exp_c3_blooming"], CLIPPED[options["clipped_sines"]]
    of_grid = ran.column(grid, EXPOSURES, SHARES, "rms_px")
    won, gaps = [], []
    for of_corners in ran.column(tuple(CORNER_METHODS), EXPOSURES, SHARES, "rms_px"):
        more_won, more_gaps = comparison(of_grid, of_corners)
        won, gaps = won + more_won, gaps + more_gaps
    ratios = [w.ratio.value for w in won]
    located = ran.column(grid, EXPOSURES, SHARES[-1], "share").mean(axis=1)
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
        + ", ".join(f"{share:.2f}" for share in located),
    )


@claim("c3_midpoints_blooming", needs=("exp_c3_blooming",), evidence="rendered")
def judge_midpoints(results):
    """Midpoints have a smaller error than edges of one image, and it grows less."""
    ran = results["exp_c3_blooming"]
    kinds = ("midpoint", "one picture")
    midpoint, one = (ran.column("edges", EXPOSURES, SHARES, kind) for kind in kinds)
    won, gaps = comparison(midpoint, one)
    ratios = [w.ratio.value for w in won]
    errors = (
        f"{np.median(b):.2f} and {np.median(a):.2f}"
        for a, b in zip(midpoint[:, 1], one[:, 1], strict=True)
    )
    return Reading.of(
        all_of([w.decision for w in won] + [gap.above(0.0) for gap in gaps]),
        float(min(ratios)),
        "1",
        "smallest ratio of medians, one image over midpoint; medians of both (px) "
        f"at 1.05 and 1.2 full wells: {', '.join(errors)}; growth by spilling, one "
        f"image less midpoint: {', '.join(f'{gap.value:.2g}' for gap in gaps)} px",
    )


@claim("c3_20_patterns", needs=("exp_c3_20_patterns",), evidence="analytic")
def judge_twenty(results):
    """Twenty patterns, and every pixel of the display decoded to itself."""
    ran = results["exp_c3_20_patterns"].select()
    count = ran.column("patterns")
    wrong, pixels = ran.column(("not_own", "pixels")).sum(axis=1).astype(int)
    holds = (ran.column("bits") == 3).all() and (count == 20).all() and wrong == 0
    return Reading.of(
        HOLDS if holds else FAILS,
        float(count.max()),
        "patterns",
        f"{wrong} of {pixels} pixels of {len(ran.conditions)} monitors are decoded to "
        "the position of another pixel, from the patterns as sent in 8 bits",
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
