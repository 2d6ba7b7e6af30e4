"""The claims of section 3.2.1."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from chapters.ch03_planar_grids.s2_1_interpolation_bias.results import (
    KNOWN,
    MAGNIFIED,
    READINGS,
    SMOOTHING,
    gain_of_decoding,
    means_in_bins,
    radial_share,
    rank_of_growth,
    swept,
    trials_of_vectors,
)
from chapters.ch03_planar_grids.s2_1_interpolation_bias.trials.scenes import (
    FOCAL_MM,
    MIDDLE_MM,
    RADIAL,
    SIDE_MM,
)
from repro.judge.statistics import (
    FAILS,
    HOLDS,
    all_of,
    loglog_slope,
    median_interval,
    trend,
)
from repro.run.experiment import claim, numbers
from repro.run.outcomes import DECISIONS, Reading, Value

LEAST_RANK, LEAST_RADIAL = 0.4, 0.6
PITCH_SLOPE, DISTORTION_SLOPE = (1.5, 2.5), (0.8, 1.2)
EXACT_MM = 1e-9
LEAST_GAIN = 10.0


def at_least(estimate, bound):
    """Whether an estimate reaches a bound."""
    return estimate.above(np.nextafter(bound, -np.inf))


@claim("c3_interp_radial_growth", needs=("fig_3_6_vectors",), evidence="synthetic")
def judge_radial_growth(results):
    """Spearman(radius, |error|) >= 0.4, and means that rise over four bins."""
    readings = []
    for name in READINGS:
        trials = trials_of_vectors(results["fig_3_6_vectors"], name)
        rank = median_interval([rank_of_growth(v) for v in trials])
        means = np.array([means_in_bins(v) for v in trials])
        rises = [median_interval(d) for d in np.diff(means, axis=1).T]
        decision = all_of(
            [at_least(rank, LEAST_RANK)] + [rise.above(0) for rise in rises]
        )
        listed = ", ".join(f"{m:.4f}" for m in np.median(means, axis=0))
        readings.append(
            Reading(
                DECISIONS[decision],
                rank.value,
                reading={"four_corners": name},
                interval=(rank.low, rank.high),
                reason="Spearman; mean errors in the four bins, inner to "
                f"outer, {listed} mm",
            )
        )
    return readings


@claim("c3_interp_radial_dir", needs=("fig_3_6_vectors",), evidence="synthetic")
def judge_radial_direction(results):
    """Radial with the nearest four, and more so with the enclosing cell."""
    shares = [
        np.array(
            [
                radial_share(v)
                for v in trials_of_vectors(results["fig_3_6_vectors"], name)
            ]
        )
        for name in READINGS
    ]
    nearest, enclosing = (median_interval(s) for s in shares)
    more = median_interval(shares[1] - shares[0])
    decision = all_of([at_least(nearest, LEAST_RADIAL), more.above(0)])
    return [
        Reading(
            DECISIONS[decision],
            nearest.value,
            interval=(nearest.low, nearest.high),
            reason="share of the energy with the nearest four; with the "
            f"enclosing cell {enclosing.value:.4f}",
        )
    ]


@claim("c3_interp_pitch", needs=("fig_3_7_pitches",), evidence="synthetic")
def judge_pitch(results):
    """The RMS rises with every pitch; log-log slope in [1.5, 2.5]."""
    result = results["fig_3_7_pitches"]
    pitch = swept(result, "pitch_mm")
    readings = []
    for name in READINGS:
        trials = [result.column(f"{name}.rms_mm", **c) for c in result.conditions]
        levels = [median_interval(t) for t in trials]
        rises = [
            HOLDS if after.low > before.high else FAILS
            for before, after in pairwise(levels)
        ]
        slope = trend(pitch, trials, loglog_slope)
        decision = all_of([*rises, slope.within(*PITCH_SLOPE)])
        readings.append(
            Reading(
                DECISIONS[decision],
                slope.value,
                reading={"four_corners": name},
                interval=(slope.low, slope.high),
                reason=f"log-log slope; RMS from {levels[0].value:.4f} mm at "
                f"{pitch[0]:g} mm to {levels[-1].value:.4f} mm at {pitch[-1]:g} mm",
            )
        )
    return readings


@claim("c3_interp_cause", needs=("fig_3_6_distortion",), evidence="synthetic")
def judge_cause(results):
    """Exact without distortion, and nearly in proportion to it."""
    result = results["fig_3_6_distortion"]
    bent = [c for c in result.conditions if c["share"] > 0]
    readings = []
    for name in READINGS:
        straight = result.column(f"{name}.rms_mm", share=0).max()
        slope = trend(
            np.array([c["share"] for c in bent]),
            [result.column(f"{name}.rms_mm", **c) for c in bent],
            loglog_slope,
        )
        exact = HOLDS if straight < EXACT_MM else FAILS
        decision = all_of([exact, slope.within(*DISTORTION_SLOPE)])
        readings.append(
            Reading(
                DECISIONS[decision],
                slope.value,
                reading={"four_corners": name},
                interval=(slope.low, slope.high),
                reason="log-log slope over the share of the distortion; "
                f"without any, at most {straight:.0e} mm",
            )
        )
    return readings


@claim(
    "c3_interp_discontinuous",
    needs=("exp_c3_interp_discontinuous",),
    evidence="rendered",
)
def judge_discontinuous(results):
    """Interpolation errs ten times as much as decoding near the ridge."""
    result = results["exp_c3_interp_discontinuous"]
    trusted = 100 * np.median(result.column("trusted"))
    readings = []
    for known in KNOWN:
        for smoothing in SMOOTHING:
            gain = median_interval(gain_of_decoding(result, known, smoothing))
            said = [
                f"{np.median(result.column(f'{name}.rms_mm')):.3g} mm"
                for name in (known, smoothing)
            ]
            readings.append(
                Reading(
                    DECISIONS[gain.above(LEAST_GAIN)],
                    gain.value,
                    reading={"facets": known, "phase_smoothing": smoothing},
                    interval=(gain.low, gain.high),
                    unit="1",
                    reason=f"ratio of RMS errors; interpolation {said[0]}, "
                    f"decoding {said[1]}, on the {trusted:.1f} % of the pixels "
                    "near the ridge that the decoder trusts",
                )
            )
    return readings


@numbers("fig_3_6", needs=("fig_3_6_vectors",), evidence="synthetic")
def settings_of_vectors(results):
    """What Fig. 3.6 is drawn with; the image is as large as the grid (E-3.07)."""
    ran = results["fig_3_6_vectors"]
    return {
        "fig3_6_f": Value(FOCAL_MM, unit="mm"),
        "fig3_6_pp_x": Value(MIDDLE_MM, unit="mm"),
        "fig3_6_pp_y": Value(MIDDLE_MM, unit="mm"),
        "fig3_6_k1": Value(RADIAL[0]),
        "fig3_6_k2": Value(RADIAL[1]),
        "fig3_6_pts": Value(len(ran.arrays("points")[0])),
        "fig3_6_grid": Value(SIDE_MM, unit="mm"),
        "fig3_6_pitch": Value(ran.conditions[0]["pitch_mm"], unit="mm"),
        "fig3_6_scale": Value(MAGNIFIED),
    }
