"""The claims and numbers of section 3.1.2."""

from __future__ import annotations

import numpy as np

from chapters.ch03_planar_grids.s1_2_celect.results import (
    COUNTS,
    SIDES,
    THRESHOLDS,
    interior,
)
from chapters.ch03_planar_grids.s1_2_celect.trials.boards import BIG_FOVS, BROKEN
from chapters.ch03_planar_grids.s1_2_celect.trials.scenes import CAMERAS, LEAST_PX
from raxel.features.celect import CelectSettings
from repro.judge.statistics import (
    FAILS,
    HOLDS,
    UNDECIDED,
    all_of,
    bootstrap,
    mcnemar,
    paired_gain,
    proportion,
)
from repro.run.experiment import claim, numbers
from repro.run.outcomes import DECISIONS, Reading, Value

SURE, DROP = 0.9, 0.2
LEAST_TRIALS = 10
P_MAX = 0.05


@claim("c3_trace_orders", needs=("fig_3_1_cameras",), evidence="rendered")
def judge_trace_orders(results):
    """Success of at least 0.9 with every camera."""
    result = results["fig_3_1_cameras"]
    readings = []
    for size, least_px in LEAST_PX.items():
        runs = {
            camera: result.column("success", camera=camera, size_px=size)
            for camera in CAMERAS
        }
        rates = {camera: proportion(run) for camera, run in runs.items()}
        decisions = [rate.above(SURE - 1e-9) for rate in rates.values()]
        worst = min(rates, key=lambda camera: rates[camera].value)
        readings.append(
            Reading(
                DECISIONS[all_of(decisions)],
                rates[worst].value,
                reading={"least_side_px": f"{least_px} px"},
                interval=(rates[worst].low, rates[worst].high),
                unit="1",
                reason=f"least share of boards in order ({worst}); "
                + ", ".join(f"{c} {100 * r.value:.0f} %" for c, r in rates.items()),
            )
        )
    return readings


@claim("c3_window_tradeoff", needs=("table_3_1_window",), evidence="synthetic")
def judge_window_tradeoff(results):
    """Both ends of the multiplier lower than the best by 20 points."""
    result = results["table_3_1_window"]
    run = [c["multiplier"] for c in result.conditions]
    success = {m: result.column("success", multiplier=m) for m in run}
    best = max(run, key=lambda m: (success[m].mean(), -abs(np.log(m))))
    decisions, drops = [], []
    for end in (run[0], run[-1]):
        drop = bootstrap(
            lambda a, b: a.mean(axis=-1) - b.mean(axis=-1), success[best], success[end]
        )
        few = len(success[end]) < LEAST_TRIALS
        decisions.append(UNDECIDED if few else drop.above(DROP - 1e-9))
        drops.append(drop.value)
    inside = HOLDS if best not in (run[0], run[-1]) else FAILS
    return [
        Reading(
            DECISIONS[all_of([inside, *decisions])],
            float(best),
            unit="1",
            reason="multiplier of r with the most boards right; "
            f"{100 * drops[0]:.0f} points fewer at {run[0]}, "
            f"{100 * drops[1]:.0f} at {run[-1]}",
        )
    ]


@claim("c3_window_growth", needs=("table_3_1_growth",), evidence="synthetic")
def judge_window_growth(results):
    """McNemar's test of runs with and without growing windows."""
    result = results["table_3_1_growth"]
    readings = []
    for option, condition in BROKEN.items():
        grown = result.column("published.success", **condition)
        fixed = result.column("no growth.success", **condition)
        only_grown = int(((grown == 1) & (fixed == 0)).sum())
        only_fixed = int(((grown == 0) & (fixed == 1)).sum())
        p = mcnemar(grown == 1, fixed == 1)
        gain = paired_gain(grown, fixed)
        verdict = FAILS
        if len(grown) < LEAST_TRIALS:
            verdict = UNDECIDED
        elif p < P_MAX and only_grown > only_fixed:
            verdict = HOLDS
        elif p >= P_MAX and only_grown > only_fixed:
            verdict = UNDECIDED
        readings.append(
            Reading(
                DECISIONS[verdict],
                gain.value,
                reading={"broken_edges": option},
                interval=(gain.low, gain.high),
                unit="1",
                reason=f"{100 * grown.mean():.0f} % right with growth, "
                f"{100 * fixed.mean():.0f} % without; {only_grown} boards "
                f"only with it, {only_fixed} only without; p = {p:.2g}",
            )
        )
    return readings


@claim("c3_split_peaks", needs=("table_3_2_split",), evidence="synthetic")
def judge_split_peaks(results):
    """Duplicates in windows with one edge: at most half with averaging."""
    result = results["table_3_2_split"]
    windows = result.conditions[0]["windows"]
    readings = []
    for count, option in (
        ("any", "any further line"),
        ("near", "a further line near the edge"),
    ):
        without = result.column(f"no averaging.{count}") / windows
        with_it = result.column(f"published.{count}") / windows
        drop = bootstrap(
            lambda a, b: 1 - b.mean(axis=-1) / a.mean(axis=-1),
            without,
            with_it,
            paired=True,
        )
        few = len(without) < LEAST_TRIALS
        readings.append(
            Reading(
                DECISIONS[UNDECIDED if few else drop.above(0.5 - 1e-9)],
                drop.value,
                reading={"single_edge_windows": option},
                interval=(drop.low, drop.high),
                unit="1",
                reason=f"drop of the rate, from {100 * without.mean():.1f} % "
                f"of the windows to {100 * with_it.mean():.1f} %",
            )
        )
    return readings


@claim("c3_start_condition", needs=("table_3_2_start",), evidence="synthetic")
def judge_start_condition(results):
    """Wrong exactly where the text's two conditions say so."""
    result = results["table_3_2_start"]
    predicted = result.column("predicted") == 1
    wrong = result.column("went_wrong") == 1
    agree = predicted == wrong
    share = proportion(agree)
    both_sides = 0 < predicted.sum() < len(predicted)
    verdict = HOLDS if agree.all() else FAILS
    if not both_sides or len(agree) < LEAST_TRIALS:
        verdict = UNDECIDED
    return [
        Reading(
            DECISIONS[verdict],
            share.value,
            interval=(share.low, share.high),
            unit="1",
            reason="share of constructed first corners that go as predicted: "
            f"{int((predicted & wrong).sum())} of {int(predicted.sum())} "
            f"wrong as predicted, {int((~predicted & ~wrong).sum())} of "
            f"{int((~predicted).sum())} right as predicted",
        )
    ]


def falling_trend(scores, counts, trials):
    """Cochran-Armitage: z of a linear trend of counts of trials over scores (n,)."""
    scores, counts = np.asarray(scores, float), np.asarray(counts, float)
    trials = np.asarray(trials, float)
    rate = counts.sum() / trials.sum()
    middle = (trials * scores).sum() / trials.sum()
    spread = rate * (1 - rate) * (trials * (scores - middle) ** 2).sum()
    if spread == 0:
        return 0.0
    return float(((counts - trials * rate) * (scores - middle)).sum()) / np.sqrt(spread)


@claim("c3_big_square_curved", needs=("exp_c3_big_square",), evidence="synthetic")
def judge_big_square(results):
    """Success falls with the size of the square, one-sided p < 0.05."""
    from scipy.stats import norm

    result = results["exp_c3_big_square"]
    readings = []
    for fov in BIG_FOVS:
        across = [c["squares_across"] for c in result.conditions if c["fov_deg"] == fov]
        runs = [result.column("success", squares_across=n, fov_deg=fov) for n in across]
        trials = [len(r) for r in runs]
        z = falling_trend(1000 / np.array(across), [r.sum() for r in runs], trials)
        p = float(norm.cdf(z))
        verdict = HOLDS if p < P_MAX else FAILS
        if min(trials) < LEAST_TRIALS:
            verdict = UNDECIDED
        rates = ", ".join(
            f"{1000 / n:.0f} px {100 * r.mean():.0f} %"
            for n, r in zip(across, runs, strict=True)
        )
        readings.append(
            Reading(
                DECISIONS[verdict],
                p,
                reading={"highest_fov": f"{fov} deg"},
                unit="1",
                reason=f"p of a falling trend; right: {rates}",
            )
        )
    return readings


@claim("c3_merge_multi", needs=("fig_3_1_cameras",), evidence="rendered")
def judge_merge_multi(results):
    """More candidates than corners, and one left of each.

    That one is left of each is what it takes to be read, so it cannot fail here.
    """
    result = results["fig_3_1_cameras"]
    success, candidates, merged, wanted = (
        np.concatenate([result.column(name, **c) for c in result.conditions])
        for name in ("success", "candidates", "merged", "wanted")
    )
    right = success == 1
    candidates, merged, wanted = (
        values[right] for values in (candidates, merged, wanted)
    )
    if not right.any():
        return [Reading(DECISIONS[UNDECIDED], "none", reason="no board read")]
    holds = (candidates > wanted).all() and (merged == wanted).all()
    return [
        Reading(
            DECISIONS[HOLDS if holds else FAILS],
            float((candidates / wanted).min()),
            unit="1",
            reason="least number of candidates per corner over "
            f"{int(right.sum())} boards that were read; mean "
            f"{(candidates / wanted).mean():.1f}",
        )
    ]


@claim("c3_border_formula", needs=(), evidence="analytic")
def judge_border_formula(results):
    """(l-1)(k-1) - (l-3)(k-3) = 2 l + 2 k - 8 for all boards up to 60 x 60."""
    sizes = [(a, b) for a in range(4, 61) for b in range(4, 61)]
    holds = all(
        interior(size, 0) - interior(size, 1) == 2 * sum(size) - 8 for size in sizes
    )
    return [
        Reading(
            DECISIONS[HOLDS if holds else FAILS],
            f"{interior((10, 8), 0)} - {interior((10, 8), 1)} = "
            f"{interior((10, 8), 0) - interior((10, 8), 1)}",
            reason=f"counted for {len(sizes)} sizes of board",
        )
    ]


@claim("c3_chess_unbiased", needs=("exp_c3_bias",), evidence="analytic")
def judge_chess_unbiased(results):
    """The corner stays to 1e-9 px, the centroid moves by more than 1e-3 px."""
    result = results["exp_c3_bias"]
    corner, disc = result.column("corner_px"), result.column("disc_px")
    holds = corner.max() < 1e-9 and disc.min() > 1e-3
    return [
        Reading(
            DECISIONS[HOLDS if holds else FAILS],
            float(np.median(disc)),
            unit="px",
            reason="median shift of the centroid of a disc of 20 px; largest "
            f"of the corner {corner.max():.0e} px, least of the disc "
            f"{disc.min():.1e} px",
        )
    ]


@numbers("table_3_1", needs=(), evidence="analytic")
def numbers_of_table_3_1(results):
    """The window radii, as the code has them."""
    divisor = CelectSettings().radius_divisor
    return {
        f"t3_1_s{i}": Value(f"|{side}| / ({divisor:g}*{count})", unit="px")
        for i, (side, count) in enumerate(zip(SIDES, COUNTS, strict=True), 1)
    }


@numbers("table_3_2", needs=(), evidence="analytic")
def numbers_of_table_3_2(results):
    """The thresholds, as the code has them."""
    settings = CelectSettings()
    values = {
        f"t3_2_{name}": Value(f"{getattr(settings, field):g}*s_i", unit=unit)
        for name, (field, unit, _) in THRESHOLDS.items()
        if name != "t4"
    }
    values["t3_2_t4"] = Value(settings.first_angle_deg, unit="deg")
    return values


@numbers("sec_3_1_2", needs=(), evidence="analytic")
def numbers_of_section(results):
    """Settings of the text, and the count of corners without a white border."""
    settings = CelectSettings()
    squares = (10, 8)
    extra = interior(squares, 0) - interior(squares, 1)
    return {
        "s3_1_2_col_radius": Value(settings.column_radius, unit="ratio"),
        "s3_1_2_grow": Value(100 * settings.growth, unit="%"),
        "s3_1_2_col_merge": Value(settings.column_merge, unit="ratio"),
        "s3_1_2_peaks_min": Value(settings.peaks[0], unit="count"),
        "s3_1_2_peaks_max": Value(settings.peaks[1], unit="count"),
        "s3_1_2_lambda": Value(squares[0], unit="count"),
        "s3_1_2_kappa": Value(squares[1], unit="count"),
        "s3_1_2_extra": Value(extra, unit="count"),
        "s3_1_2_extra_pct": Value(100 * extra / interior(squares, 1), unit="%"),
    }
