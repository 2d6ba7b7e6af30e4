"""The claims of section 3.2.2, tested as the ledger words them."""

from __future__ import annotations

import itertools

import numpy as np

from chapters.ch03_planar_grids.s2_2_active_grids.results import (
    PERCENT_OF_PERIOD,
    QUESTIONS,
    bit_counts,
    bloom_errors,
    bloom_growth,
    misfit_ratio,
    profile_column,
    third_gain,
)
from chapters.ch03_planar_grids.s2_2_active_grids.trials.blooming import (
    CORNER_METHODS,
    EXPOSURES,
)
from chapters.ch03_planar_grids.s2_2_active_grids.trials.codes import EDGES_AND_LIGHT
from chapters.ch03_planar_grids.s2_2_active_grids.trials.profile import DATA_SHEET_GAMMA
from repro.judge.statistics import (
    all_of,
    bootstrap,
    mcnemar,
    proportion,
    wins,
    with_worst,
)
from repro.run.experiment import claim, numbers
from repro.run.outcomes import DECISIONS, Reading, Value

ROUNDING_RAD = 1e-12
LEAST_RATIO, MOST_GAIN = 3.0, 0.05
MOST_ERROR_PERCENT, ABOUT_TEN_GREY = 0.1, (9.0, 11.0)
LEAST_BIT_RATIO, SIGNIFICANCE = 2.0, 0.01
SHARE_OF_SEEDS = 0.9


def _of_seeds(holds):
    """Verdict over rendered seeds: the share that holds decides as it stands."""
    return "reproduced" if np.mean(holds) >= SHARE_OF_SEEDS else "differs"


def _range(values, unit=""):
    return f"{np.min(values):.3g} to {np.max(values):.3g}{unit}"


@claim("c3_single_sine_poor", needs=("fig_3_9",), evidence="rendered")
def judge_single_sine(results):
    """RMS0 at least three times RMS1, at the data-sheet gamma."""
    ran = results["fig_3_9"]
    readings = []
    for camera in QUESTIONS["camera_response"]:
        ratio = misfit_ratio(ran, camera)
        held = ratio >= LEAST_RATIO
        share = proportion(held)
        readings.append(
            Reading(
                _of_seeds(held),
                float(np.median(ratio)),
                reading={"camera_response": camera},
                unit="1",
                reason=f"ratio of the misfits, {_range(ratio)} over "
                f"{len(ratio)} views; held in {100 * share.value:.0f} % of "
                f"them ({100 * share.low:.0f} to {100 * share.high:.0f})",
            )
        )
    return readings


@claim("c3_third_marginal", needs=("fig_3_9",), evidence="rendered")
def judge_third_marginal(results):
    """Order 3 takes away at most 5 % of the misfit."""
    ran = results["fig_3_9"]
    readings = []
    for camera in QUESTIONS["camera_response"]:
        gain = third_gain(ran, camera)
        size = profile_column(ran, camera, DATA_SHEET_GAMMA, "order_3")
        held = gain <= MOST_GAIN
        share = proportion(held)
        readings.append(
            Reading(
                _of_seeds(held),
                float(np.median(gain)),
                reading={"camera_response": camera},
                unit="1",
                reason=f"share of the misfit, {_range(gain)} over {len(gain)} "
                f"views; order 3 has {_range(size)} grey levels; held in "
                f"{100 * share.value:.0f} % of the views "
                f"({100 * share.low:.0f} to {100 * share.high:.0f})",
            )
        )
    return readings


@numbers("fig_3_9", needs=("fig_3_9",), evidence="rendered")
def values_of_fits(results):
    """Misfits with zero, one and two harmonics, medians over the views."""
    found = {}
    for k in range(3):
        rms = profile_column(results["fig_3_9"], "linear", DATA_SHEET_GAMMA, f"rms_{k}")
        found[f"fig3_9_rms_h{k}"] = Value(
            float(np.median(rms)),
            interval=(float(rms.min()), float(rms.max())),
            unit="grey levels",
        )
    return found


@claim("c3_radiometric_ok", needs=("exp_c3_radiometric_ok",), evidence="synthetic")
def judge_radiometric(results):
    """Error at most 0.1 % of a period, at a misfit of about 10 grey levels."""
    ran = results["exp_c3_radiometric_ok"]
    readings = []
    for rest in QUESTIONS["profile_rest"]:
        error = PERCENT_OF_PERIOD * ran.column("largest_rad", rest=rest)[0]
        misfit = ran.column("misfit_grey", rest=rest)[0]
        low, high = ABOUT_TEN_GREY
        holds = error <= MOST_ERROR_PERCENT and low <= misfit <= high
        readings.append(
            Reading(
                "reproduced" if holds else "differs",
                float(error),
                reading={"profile_rest": rest},
                unit="% of a period",
                reason=f"largest error over the period and all positions of the "
                f"orders, at 80 grey levels of order 1; misfit of one sine "
                f"{misfit:.2f} grey levels",
            )
        )
    return readings


@claim("c3_offset_cancels", needs=("exp_c3_offset_cancels",), evidence="analytic")
def judge_offset(results):
    """Phase change below 1e-12 rad for offsets of up to 50 grey levels."""
    ran = results["exp_c3_offset_cancels"]
    formula = ran.column("formula_rad").max()
    decoder = ran.column("decoder_rad").max()
    return [
        Reading(
            "reproduced" if formula < ROUNDING_RAD else "differs",
            float(formula),
            unit="rad",
            reason="largest change in double precision; the decoder, on pictures "
            f"of 8 bits, changes by {decoder:.1g} rad",
        )
    ]


@claim("c3_vignetting", needs=("exp_c3_vignetting",), evidence="analytic")
def judge_vignetting(results):
    """Phase change below 1e-12 rad for gains of 0.2 to 1."""
    ran = results["exp_c3_vignetting"]
    formula = ran.column("formula_rad").max()
    sixteen = ran.column("decoder_16_rad").max()
    eight = ran.column("decoder_8_rad").max()
    return [
        Reading(
            "reproduced" if formula < ROUNDING_RAD else "differs",
            float(formula),
            unit="rad",
            reason="largest change in double precision; by the decoder after "
            f"rounding {sixteen:.1g} rad in 16 bits, {eight:.1g} rad in 8",
        )
    ]


@claim("c3_gray_single", needs=("exp_c3_gray_single",), evidence="analytic")
def judge_gray_single(results):
    """Neighbours differ in one bit; one wrong at its edge moves by one cell."""
    ran = results["exp_c3_gray_single"]

    def over(name):
        return int(max(ran.column(name, **c).max() for c in ran.conditions))

    changed, shift = over("bits_changed"), over("shift")
    tested = int(sum(ran.column("tested", **c)[0] for c in ran.conditions))
    return [
        Reading(
            "reproduced" if changed == 1 and shift <= 1 else "differs",
            float(shift),
            unit="cells",
            reason=f"all {tested} edges of codes of 1 to "
            f"{len(ran.conditions)} bits, as decoded; a wrong bit away from its "
            f"edge moves by up to {over('shift_elsewhere')} cells, one of plain "
            f"binary at its edge by up to {over('binary_shift')}",
        )
    ]


@claim("c3_inverse_helps", needs=("exp_c3_inverse_helps",), evidence="synthetic")
def judge_inverse(results):
    """Half as many wrong bits as a threshold near edges, McNemar p < 0.01."""
    ran = results["exp_c3_inverse_helps"]
    readings = []
    for (edges, light), threshold in itertools.product(
        EDGES_AND_LIGHT, QUESTIONS["bit_threshold"]
    ):
        wrong, paired, pixels, only, other = bit_counts(ran, edges, light, threshold)
        ratio = bootstrap(
            lambda a, b: a.sum(axis=-1) / np.maximum(b.sum(axis=-1), 1),
            wrong,
            paired,
            paired=True,
        )
        lone = np.repeat([True, False], [only, other])
        p = mcnemar(~lone, lone)
        decision = ratio.above(np.nextafter(LEAST_BIT_RATIO, 0))
        if decision == "holds" and p >= SIGNIFICANCE:
            decision = "undecided"
        readings.append(
            Reading(
                DECISIONS[decision],
                ratio.value,
                reading={
                    "bit_edges": edges,
                    "bit_light": light,
                    "bit_threshold": threshold,
                },
                interval=(ratio.low, ratio.high),
                unit="1",
                reason=f"{wrong.sum():.0f} wrong bits against "
                f"{paired.sum():.0f} of {pixels.sum():.0f}, all levels of blur "
                f"and noise; McNemar p = {p:.1g}",
            )
        )
    return readings


@claim("c3_blooming", needs=("exp_c3_blooming",), evidence="rendered")
def judge_blooming(results):
    """The active grid below both corner methods, and growing less."""
    ran = results["exp_c3_blooming"]
    decisions, ratios, grown = [], [], []
    for method in CORNER_METHODS:
        levels = [
            (
                bloom_errors(ran, "active grid", exposure, 1.0),
                bloom_errors(ran, method, exposure, 1.0),
            )
            for exposure in EXPOSURES
        ]
        won = wins(levels)
        decisions += [w.decision for w in won]
        ratios += [w.ratio.value for w in won]
        for exposure in EXPOSURES:
            ours, theirs = (
                with_worst(bloom_growth(ran, name, exposure))
                for name in ("active grid", method)
            )
            gap = bootstrap(
                lambda a, b: np.median(b, axis=-1) - np.median(a, axis=-1),
                ours,
                theirs,
                paired=True,
            )
            decisions.append(gap.above(0.0))
            grown.append(f"{gap.value:.2g}")
    return [
        Reading(
            DECISIONS[all_of(decisions)],
            float(min(ratios)),
            unit="1",
            reason="smallest ratio of medians, corner over active grid; ratios "
            + ", ".join(f"{r:.2g}" for r in ratios)
            + " (saddle point at 1.05 and 1.2 full wells, then derivative); "
            "growth by spilling, corner less active grid: " + ", ".join(grown) + " px",
        )
    ]


@claim("c3_20_patterns", needs=("exp_c3_20_patterns",), evidence="analytic")
def judge_twenty(results):
    """Twenty patterns, and every pixel of the display decoded to itself."""
    ran = results["exp_c3_20_patterns"]

    def over(name):
        return [int(ran.column(name, **c)[0]) for c in ran.conditions]

    bits, count = set(over("bits")), set(over("patterns"))
    wrong = sum(over("not_own"))
    holds = bits == {3} and count == {20} and wrong == 0
    return [
        Reading(
            "reproduced" if holds else "differs",
            float(max(count)),
            unit="patterns",
            reason=f"{wrong} of {sum(over('pixels'))} pixels of "
            f"{len(ran.conditions)} monitors are decoded to another pixel's "
            "place, each from what is sent to the monitor in 8 bits",
        )
    ]


@numbers("sec_3_2_2", needs=("exp_c3_20_patterns",), evidence="analytic")
def values_of_plan(results):
    """What the default plan of patterns is made of."""
    ran = results["exp_c3_20_patterns"]
    first = ran.conditions[0]

    def of(name):
        return float(ran.column(name, **first)[0])

    return {
        "s3_2_2_patterns": Value(of("patterns")),
        "s3_2_2_binary": Value(of("binary")),
        "s3_2_2_sin": Value(of("sinusoidal")),
        "s3_2_2_cells": Value(2 ** of("bits")),
        "s3_2_2_phase": Value(of("phase_step_deg")),
        "s3_2_2_filter": Value(of("window_px")),
    }
