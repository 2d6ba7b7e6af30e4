"""The claims and numbers of section 3.1.2."""

import numpy as np

from chapters.ch03_planar_grids.s1_2_celect.experiment import (
    BIG_FOVS,
    BROKEN,
    MIN_SQUARE_PX,
)
from chapters.ch03_planar_grids.s1_2_celect.report import THRESHOLDS, interior
from raxel.features.celect import CelectSettings
from repro.run import (
    FAILS,
    HOLDS,
    UNDECIDED,
    Case,
    Reading,
    Value,
    all_of,
    bootstrap,
    claim,
    mcnemar,
    numbers,
    paired_gain,
    proportion,
)

MIN_SUCCESS, MIN_DROP = 0.9, 0.2
MIN_TRIALS = 10
MAX_P = 0.05
NAMES = {
    "least_side_px": {f"{side} px": size for size, side in MIN_SQUARE_PX.items()},
    "broken_edges": BROKEN,
    "single_edge_windows": {
        "any further line": "any",
        "a further line near the edge": "near",
    },
    "highest_fov": {f"{fov} deg": fov for fov in BIG_FOVS},
}


def if_enough(trials, decision):
    """The decision made on trials (n,); open where they are fewer than ten."""
    return decision if len(trials) >= MIN_TRIALS else UNDECIDED


@claim(
    "c3_trace_orders",
    needs=("fig_3_1_cameras",),
    evidence="rendered",
    readings=("least_side_px",),
)
def judge_trace_orders(results, options):
    """Success of at least 0.9 with every camera."""
    size = Case(NAMES, options)["least_side_px"]
    of_camera = results["fig_3_1_cameras"].by("camera", size_px=size)
    rates = {c: proportion(runs.column("success")) for c, runs in of_camera.items()}
    worst = min(rates, key=lambda camera: rates[camera].value)
    return Reading.of(
        all_of([rate.above(MIN_SUCCESS - 1e-9) for rate in rates.values()]),
        rates[worst],
        "1",
        f"smallest share of correct boards ({worst}); "
        + ", ".join(f"{c} {100 * r.value:.0f} %" for c, r in rates.items()),
    )


@claim("c3_window_tradeoff", needs=("table_3_1_window",), evidence="synthetic")
def judge_window_tradeoff(results):
    """Both ends of the multiplier lower than the best by 20 points."""
    runs = results["table_3_1_window"].by("multiplier")
    success = {m: run.column("success") for m, run in runs.items()}
    best = max(success, key=lambda m: (success[m].mean(), -abs(np.log(m))))
    first, *_, last = success
    drops = [
        bootstrap(
            lambda a, b: a.mean(axis=-1) - b.mean(axis=-1), success[best], success[end]
        )
        for end in (first, last)
    ]
    inside = HOLDS if best not in (first, last) else FAILS
    large = if_enough(success[best], all_of([d.above(MIN_DROP - 1e-9) for d in drops]))
    return Reading.of(
        all_of([inside, large]),
        float(best),
        "1",
        "multiplier of r with the most correct boards; "
        f"{100 * drops[0].value:.0f} points fewer at {first}, "
        f"{100 * drops[1].value:.0f} at {last}",
    )


@claim(
    "c3_window_growth",
    needs=("table_3_1_growth",),
    evidence="synthetic",
    readings=("broken_edges",),
)
def judge_window_growth(results, options):
    """McNemar's test of runs with and without growing windows."""
    broken = Case(NAMES, options)["broken_edges"]
    runs = results["table_3_1_growth"].one(**broken)
    grown, fixed = runs.column(("published", "no growth"), "success")
    only_grown, only_fixed = int((grown > fixed).sum()), int((fixed > grown).sum())
    p = mcnemar(grown == 1, fixed == 1)
    better = HOLDS if p < MAX_P else UNDECIDED
    return Reading.of(
        if_enough(grown, better if only_grown > only_fixed else FAILS),
        paired_gain(grown, fixed),
        "1",
        f"{100 * grown.mean():.0f} % right with growth, "
        f"{100 * fixed.mean():.0f} % without; {only_grown} boards "
        f"only with it, {only_fixed} only without; p = {p:.2g}",
    )


@claim(
    "c3_split_peaks",
    needs=("table_3_2_split",),
    evidence="synthetic",
    readings=("single_edge_windows",),
)
def judge_split_peaks(results, options):
    """Duplicates in windows with one edge: at most half with averaging."""
    result, count = results["table_3_2_split"], Case(NAMES, options)
    found = result.column(("no averaging", "published"), count["single_edge_windows"])
    without, with_it = found / result.conditions[0]["windows"]
    drop = bootstrap(
        lambda a, b: 1 - b.mean(axis=-1) / a.mean(axis=-1),
        without,
        with_it,
        paired=True,
    )
    return Reading.of(
        if_enough(without, drop.above(0.5 - 1e-9)),
        drop,
        "1",
        f"drop of the rate, from {100 * without.mean():.1f} % "
        f"of the windows to {100 * with_it.mean():.1f} %",
    )


@claim("c3_start_condition", needs=("table_3_2_start",), evidence="synthetic")
def judge_start_condition(results):
    """Wrong exactly where the text's two conditions predict it."""
    result = results["table_3_2_start"]
    predicted = result.column("predicted") == 1
    wrong = result.column("went_wrong") == 1
    agree = predicted == wrong
    both_sides = 0 < predicted.sum() < len(predicted)
    decision = HOLDS if agree.all() else FAILS
    return Reading.of(
        if_enough(agree, decision) if both_sides else UNDECIDED,
        proportion(agree),
        "1",
        "share of constructed first corners that go as predicted: "
        f"{int((predicted & wrong).sum())} of {int(predicted.sum())} "
        f"wrong as predicted, {int((~predicted & ~wrong).sum())} of "
        f"{int((~predicted).sum())} right as predicted",
    )


def falling_trend(scores, counts, trials):
    """Cochran-Armitage: z of a linear trend of counts of trials over scores (n,)."""
    scores, counts, trials = np.array([scores, counts, trials], float)
    rate = counts.sum() / trials.sum()
    middle = (trials * scores).sum() / trials.sum()
    spread = rate * (1 - rate) * (trials * (scores - middle) ** 2).sum()
    if spread == 0:
        return 0.0
    return float(((counts - trials * rate) * (scores - middle)).sum()) / np.sqrt(spread)


@claim(
    "c3_big_square_curved",
    needs=("exp_c3_big_square",),
    evidence="synthetic",
    readings=("highest_fov",),
)
def judge_big_square(results, options):
    """Success falls with the size of the square, one-sided p < 0.05."""
    from scipy.stats import norm

    fov = Case(NAMES, options)["highest_fov"]
    sizes = results["exp_c3_big_square"].by("squares_across", fov_deg=fov)
    runs = {1000 / across: of.column("success") for across, of in sizes.items()}
    trials = [len(r) for r in runs.values()]
    z = falling_trend(list(runs), [r.sum() for r in runs.values()], trials)
    p = float(norm.cdf(z))
    return Reading.of(
        if_enough(min(runs.values(), key=len), HOLDS if p < MAX_P else FAILS),
        p,
        "1",
        "p of a falling trend; right: "
        + ", ".join(f"{px:.0f} px {100 * r.mean():.0f} %" for px, r in runs.items()),
    )


@claim("c3_merge_multi", needs=("fig_3_1_cameras",), evidence="rendered")
def judge_merge_multi(results):
    """More candidates than corners, and one left of each.

    A correct board has one left of each, so the second part cannot fail here.
    """
    runs = results["fig_3_1_cameras"].select()
    right = runs.column("success") == 1
    if not right.any():
        return Reading.of(UNDECIDED, "none", reason="no correct board")
    counts = runs.column(("candidates", "merged", "wanted"))
    candidates, merged, wanted = counts[:, right]
    holds = (candidates > wanted).all() and (merged == wanted).all()
    return Reading.of(
        HOLDS if holds else FAILS,
        float((candidates / wanted).min()),
        "1",
        "smallest number of candidates per corner over "
        f"{int(right.sum())} correct boards; mean "
        f"{(candidates / wanted).mean():.1f}",
    )


@claim("c3_border_formula", needs=(), evidence="analytic")
def judge_border_formula(results):
    """(l-1)(k-1) - (l-3)(k-3) = 2 l + 2 k - 8 for all boards up to 60 x 60."""
    sizes = [(a, b) for a in range(4, 61) for b in range(4, 61)]
    holds = all(
        interior(size, 0) - interior(size, 1) == 2 * sum(size) - 8 for size in sizes
    )
    without, with_it = interior((10, 8), 0), interior((10, 8), 1)
    return Reading.of(
        HOLDS if holds else FAILS,
        f"{without} - {with_it} = {without - with_it}",
        reason=f"counted for {len(sizes)} sizes of board",
    )


@claim("c3_chess_unbiased", needs=("exp_c3_bias",), evidence="analytic")
def judge_chess_unbiased(results):
    """The corner stays to 1e-9 px, the centroid moves by more than 1e-3 px."""
    corner, disc = results["exp_c3_bias"].column(("corner_px", "disc_px"))
    holds = corner.max() < 1e-9 and disc.min() > 1e-3
    return Reading.of(
        HOLDS if holds else FAILS,
        float(np.median(disc)),
        "px",
        "median shift of the centroid of a disc of 20 px; largest "
        f"of the corner {corner.max():.0e} px, least of the disc "
        f"{disc.min():.1e} px",
    )


@numbers("table_3_1", needs=(), evidence="analytic")
def numbers_of_table_3_1(results):
    """The window radii, as the code has them."""
    divisor = CelectSettings().radius_divisor
    return {
        f"t3_1_s{i}": Value(f"|c{i}-c{i % 4 + 1}| / ({divisor:g}*{count})", unit="px")
        for i, count in enumerate(("width", "height") * 2, 1)
    }


@numbers("table_3_2", needs=(), evidence="analytic")
def numbers_of_table_3_2(results):
    """The thresholds, as the code has them."""
    settings = CelectSettings()
    return {
        f"t3_2_{name}": Value(f"{getattr(settings, field):g}*s_i", unit=unit)
        for name, (field, unit, _) in THRESHOLDS.items()
        if name != "t4"
    } | {"t3_2_t4": Value(settings.first_angle_deg, unit="deg")}


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
