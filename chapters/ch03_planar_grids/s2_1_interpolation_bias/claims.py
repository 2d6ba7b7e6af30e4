"""The claims of section 3.2.1."""

from itertools import pairwise

import numpy as np

from chapters.ch03_planar_grids.s2_1_interpolation_bias.results import (
    MAGNIFIED,
    READINGS,
    gain_of_decoding,
    means_in_bins,
    radial_shares,
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
from repro.run.outcomes import Reading, Value

MIN_RANK, MIN_RADIAL = 0.4, 0.6
PITCH_SLOPE, DISTORTION_SLOPE = (1.5, 2.5), (0.8, 1.2)
EXACT_MM = 1e-9
MIN_GAIN = 10.0


def at_least(estimate, bound):
    """Whether an estimate reaches a bound."""
    return estimate.above(np.nextafter(bound, -np.inf))


@claim(
    "c3_interp_radial_growth",
    needs=("fig_3_6_vectors",),
    evidence="synthetic",
    readings=("four_corners",),
)
def judge_radial_growth(results, options):
    """Spearman(radius, |error|) >= 0.4, and means that rise over four bins."""
    trials = trials_of_vectors(results["fig_3_6_vectors"], options["four_corners"])
    rank = median_interval([rank_of_growth(v) for v in trials])
    means = np.array([means_in_bins(v) for v in trials])
    rises = [median_interval(d).above(0) for d in np.diff(means, axis=1).T]
    listed = ", ".join(f"{m:.4f}" for m in np.median(means, axis=0))
    return Reading.of(
        all_of([at_least(rank, MIN_RANK), *rises]),
        rank,
        reason=f"Spearman; mean errors in the four bins, inner to outer, {listed} mm",
    )


@claim("c3_interp_radial_dir", needs=("fig_3_6_vectors",), evidence="synthetic")
def judge_radial_direction(results):
    """Radial with the nearest four, and more so with the enclosing cell."""
    shares = [radial_shares(results["fig_3_6_vectors"], name) for name in READINGS]
    nearest, enclosing = (median_interval(s) for s in shares)
    more = median_interval(shares[1] - shares[0])
    return Reading.of(
        all_of([at_least(nearest, MIN_RADIAL), more.above(0)]),
        nearest,
        reason="share of the energy with the nearest four; with the "
        f"enclosing cell {enclosing.value:.4f}",
    )


@claim(
    "c3_interp_pitch",
    needs=("fig_3_7_pitches",),
    evidence="synthetic",
    readings=("four_corners",),
)
def judge_pitch(results, options):
    """The RMS rises with every pitch; log-log slope in [1.5, 2.5]."""
    pitch, trials = swept(results["fig_3_7_pitches"], options["four_corners"])
    levels = [median_interval(t) for t in trials]
    rises = [
        HOLDS if after.low > before.high else FAILS
        for before, after in pairwise(levels)
    ]
    slope = trend(pitch, trials, loglog_slope)
    return Reading.of(
        all_of([*rises, slope.within(*PITCH_SLOPE)]),
        slope,
        reason=f"log-log slope; RMS from {levels[0].value:.4f} mm at "
        f"{pitch[0]:g} mm to {levels[-1].value:.4f} mm at {pitch[-1]:g} mm",
    )


@claim(
    "c3_interp_cause",
    needs=("fig_3_6_distortion",),
    evidence="synthetic",
    readings=("four_corners",),
)
def judge_cause(results, options):
    """Exact without distortion, and nearly in proportion to it."""
    name = options["four_corners"]
    share, trials = swept(results["fig_3_6_distortion"], name, "share")
    straight = trials[share == 0].max()
    slope = trend(share[share > 0], trials[share > 0], loglog_slope)
    exact = HOLDS if straight < EXACT_MM else FAILS
    return Reading.of(
        all_of([exact, slope.within(*DISTORTION_SLOPE)]),
        slope,
        reason="log-log slope over the share of the distortion; "
        f"without any, at most {straight:.0e} mm",
    )


@claim(
    "c3_interp_discontinuous",
    needs=("exp_c3_interp_discontinuous",),
    evidence="rendered",
    readings=("facets", "phase_smoothing"),
)
def judge_discontinuous(results, options):
    """Interpolation errs ten times as much as decoding near the ridge."""
    result = results["exp_c3_interp_discontinuous"]
    taken = options["facets"], options["phase_smoothing"]
    gain = median_interval(gain_of_decoding(result, *taken))
    trusted = 100 * np.median(result.column("trusted"))
    wrong, decoded = (np.median(result.column(f"{name}.rms_mm")) for name in taken)
    return Reading.of(
        gain.above(MIN_GAIN),
        gain,
        "1",
        f"ratio of RMS errors; interpolation {wrong:.3g} mm, "
        f"decoding {decoded:.3g} mm, on the {trusted:.1f} % of the pixels "
        "near the ridge that the decoder trusts",
    )


@numbers("fig_3_6", needs=("fig_3_6_vectors",), evidence="synthetic")
def settings_of_vectors(results):
    """Settings of Fig. 3.6; the image is as large as the grid (E-3.07)."""
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
