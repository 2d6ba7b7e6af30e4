"""Results of this page read: values of the prose, figures, tables, judgements."""

from __future__ import annotations

from functools import partial

import numpy as np

from chapters.ch02_general_camera_model.s5_1_synthetic_data.experiment import (
    LAWS,
    LAWS_FOV_DEG,
    LEVELS,
    NOISE_FOV_DEG,
)
from chapters.shared.general import FOVS_DEG, SweepCase
from chapters.shared.methods import METHODS, NAMES
from repro.page import legend_below, look_of, new_figure, plot_estimates, value
from repro.run import (
    FAILS,
    HOLDS,
    OVER_TRIALS,
    SIGNIFICANCE,
    UNDECIDED,
    Drawing,
    Estimate,
    Reading,
    Value,
    all_of,
    bootstrap,
    claim,
    columns,
    figure,
    loglog_slope,
    median_interval,
    numbers,
    ratio_of,
    spread_of,
    trend,
    weighted_line,
    welch_less,
    wins,
    with_worst,
)

# Numbers of section 2.5.1 for its prose and its claims.


def trials_of(result, method, quantity, **condition):
    """Return the trials (n,) of a method's quantity, failed ones as the worst.

    In the primary interpretation, of which ``condition`` replaces parts.
    ``over_exact`` is the mean residual on fresh noise as a multiple of that of exact
    rays, ``ray_deg`` the ray error.
    """
    case = SweepCase(result)
    if quantity == "over_exact":
        trials = case.over_exact("mean_px", method, **condition)
    elif quantity == "ray_deg":
        trials = case.column(method, quantity, **condition)
    else:
        trials = case.trials(method, quantity, **condition)
    return with_worst(trials, np.nanmax(trials))


def median_of(result, method, quantity, **condition):
    """Return the median over the trials that `trials_of` returns."""
    return float(np.median(trials_of(result, method, quantity, **condition)))


def crossing(fov, method):
    """Return the levels (deg) between which a method becomes the better one.

    In the primary interpretation; the last crossing, where there are several.
    """
    levels = sorted(fov.levels("fov_deg"))
    behind = [
        at
        for at in levels
        if median_of(fov, method, "mean_px", fov_deg=at)
        >= median_of(fov, "parametric", "mean_px", fov_deg=at)
    ]
    after = levels.index(behind[-1]) + 1 if behind else 0
    return levels[max(after - 1, 0)], levels[min(after, len(levels) - 1)]


def name_values(open_results):
    """Name the numbers of the prose, in the primary interpretation."""
    fov = open_results("fig_2_3_fov")
    _, *generic = METHODS
    below, above = crossing(fov, generic[0])
    found = {
        "crossing.below": below,
        "crossing.above": above,
        **{
            f"{generic[0]}.over.{at}": median_of(
                fov, generic[0], "over_exact", fov_deg=at
            )
            for at in (120, 150)
        },
        **{
            f"{method}.ray_deg.90": median_of(fov, method, "ray_deg", fov_deg=90)
            for method in generic
        },
    }
    for name, number in found.items():
        value(name, number)


# Figures of section 2.5.1: residuals of the methods along two sweeps.


NOISE = ("fig_2_3_noise", "noise", LEVELS, "Noise SD (px)")
FOV = ("fig_2_3_fov", "fov_deg", FOVS_DEG, "Field of view (deg)")
FISHEYE = ("fig_2_3_fisheye", *FOV[1:])


COLUMNS = (
    "sweep", "value", "method", "noise_domain", "extent",
    "x", "median", "low", "high",
)  # fmt: skip


def draw_curves(axes, results, sweep, quantity, methods):
    """Draw medians over trials with 95 % intervals; return the rows of the data.

    A failed trial counts as the worst trial.
    """
    experiment, x_name, xs, x_label = sweep
    scored = f"fresh.corrected.{quantity}" if quantity.endswith("_px") else quantity
    rows = []
    for method in methods:
        found = [
            median_interval(
                trials_of(results[experiment], method, quantity, **{x_name: x})
            )
            for x in xs
        ]
        rows += plot_estimates(
            axes, xs, found, (x_name, scored, method, "px", "unbounded"),
            look=look_of(NAMES[method]), label=NAMES[method],
        )  # fmt: skip
    axes.set(yscale="log", xlabel=x_label)
    if x_name == "noise":
        axes.set_xscale("log")
    else:
        axes.set_xticks(range(30, 151, 30))
    return rows


@figure("fig_2_3", needs=("fig_2_3_noise", "fig_2_3_fov"), evidence="synthetic")
def fig_2_3(results):
    """Draw mean and SD of the residual in the primary interpretation, both sweeps."""
    drawn, axes = new_figure(2, 2, height_in=6.4, sharex="col")
    titles, rows = ("(a) noise", "(b) field of view"), []
    for (top, bottom), sweep, title in zip(axes.T, (NOISE, FOV), titles, strict=True):
        for panel, quantity in ((top, "mean_px"), (bottom, "sd_px")):
            rows += draw_curves(panel, results, sweep, quantity, ("exact", *METHODS))
        top.set(title=title, xlabel="", ylabel="Mean residual (px)")
        bottom.set_ylabel("SD of residual (px)")
    legend_below(drawn, axes[0, 0], ncols=2)
    return Drawing(
        drawn,
        columns(COLUMNS, rows),
        "Distortion residuals of the parametric and the generic method as a "
        "function of (a) noise and (b) field of view, scored on fresh noise "
        "(primary interpretation). Top: mean, bottom: standard deviation. "
        "*Exact rays* are those of the simulated camera: their residual is "
        "the noise of the scored points. Medians over trials with 95 % "
        "intervals, on logarithmic axes.",
    )


@figure(
    "ext_fig_2_3_fisheye",
    needs=("fig_2_3_fov", "fig_2_3_fisheye"),
    evidence="synthetic",
)
def ext_fig_2_3_fisheye(results):
    """Draw Fig. 2.3(b) together with OpenCV's fisheye model: residual and rays."""
    drawn, (residual, rays) = new_figure(1, 2, height_in=3.8)
    rows = []
    for panel, quantity in ((residual, "over_exact"), (rays, "ray_deg")):
        rows += draw_curves(panel, results, FOV, quantity, METHODS[:2])
        rows += draw_curves(panel, results, FISHEYE, quantity, ["opencv_fisheye"])
    residual.set(ylabel="Mean residual (multiple of exact rays)", title="residual")
    rays.set(ylabel="Median ray error (deg)", title="rays")
    legend_below(drawn, residual, ncols=3)
    return Drawing(
        drawn,
        columns(COLUMNS, rows),
        "Residual and ray error in the sweep of Fig. 2.3(b), with OpenCV's "
        "fisheye model, which the thesis did not have. Left: the mean "
        "residual on fresh noise as a multiple of that of exact rays on the "
        "same points, which removes the stretch of the corrected view. "
        "Right: the angle between calibrated and true rays, after the best "
        "rotation. Medians over trials with 95 % intervals.",
    )


# Claims about Fig. 2.3, each tested in every interpretation of the text.
#
# Tests follow the wording of the registry; the first interpretation is primary.


FLAT_FOVS = [fov for fov in FOVS_DEG if 30 <= fov <= 120]


NOISY = ("fig_2_3_noise",)
SWEPT = ("fig_2_3_fov",)
ALL = (
    "noise",
    "scoring",
    "extent",
    "standard_method",
    "residual_scale",
    "statistic_of_trials",
)
PARAMETRIC = ("noise", "scoring", "extent", "residual_scale", "statistic_of_trials")
ANY_EXTENT = (
    "noise",
    "scoring",
    "standard_method",
    "residual_scale",
    "statistic_of_trials",
)
OF_LAWS = (
    "noise",
    "scoring",
    "extent",
    "standard_method",
    "law_pixels",
    "statistic_of_trials",
)


def _interval(statistic: str, trials: np.ndarray) -> Estimate:
    """Median or mean of trials with its interval, failures as the worst that is."""
    worst = np.nanmax(trials)
    if statistic == "median":
        return median_interval(trials, worst=worst)
    return bootstrap(OVER_TRIALS[statistic], with_worst(trials, worst))


def in_words(found: Estimate) -> str:
    """Return an estimate with its interval, in words."""
    return f"{found.value:.2f} ({found.low:.2f} to {found.high:.2f})"


def _proportional(case: SweepCase, method: str) -> Reading:
    """Return whether the residual is proportional to the noise.

    Weighted line with R2 >= 0.98, log-log slope in [0.85, 1.15].
    """
    levels = np.array(LEVELS)
    trials = [
        case.trials(method, "mean_px", noise=level, fov_deg=NOISE_FOV_DEG)
        for level in LEVELS
    ]
    found = [_interval(case.statistic, t) for t in trials]
    width = np.array([max(e.high - e.low, 1e-12) for e in found])
    # The intervals of the levels are in the weights; R2 itself has none.
    line = weighted_line(levels, [e.value for e in found], 1 / width**2)
    slope = trend(levels, trials, loglog_slope, statistic=case.statistic)
    failed = np.count_nonzero(np.isnan(trials))
    remark = f"log-log slope; R² of the weighted line {line.r2:.4f}"
    if failed:
        remark += f"; {failed} of {np.size(trials)} trials failed"
    decision = slope.within(0.85, 1.15) if line.r2 >= 0.98 else FAILS
    return Reading.of(decision, slope, reason=remark)


@claim("c2_noise_linear_generic", needs=NOISY, evidence="synthetic", readings=ALL)
def judge_noise_linear_generic(results, options):
    """The generic residual grows in proportion to the noise."""
    return _proportional(SweepCase(results["fig_2_3_noise"], options), "generic")


@claim("c2_noise_linear_persp", needs=NOISY, evidence="synthetic", readings=PARAMETRIC)
def judge_noise_linear_parametric(results, options):
    """The parametric residual grows in proportion to the noise."""
    return _proportional(SweepCase(results["fig_2_3_noise"], options), "parametric")


def rank_trend(x, medians):
    """Return the rank correlation of medians (n,) with a sweep (n,) without ties."""
    return float(np.corrcoef(np.arange(len(x)), np.argsort(np.argsort(medians)))[0, 1])


@claim("c2_fov_persp_rises", needs=SWEPT, evidence="synthetic", readings=PARAMETRIC)
def judge_fov_parametric_rises(results, options):
    """Spearman >= 0.9, and 150 deg more than twice 60 deg."""
    case = SweepCase(results["fig_2_3_fov"], options)
    trials = [case.trials("parametric", "mean_px", fov_deg=fov) for fov in FOVS_DEG]
    rank = trend(np.array(FOVS_DEG), trials, rank_trend, statistic=case.statistic)
    (wide, narrow), exact = (
        [case.trials(method, "mean_px", fov_deg=fov) for fov in (150, 60)]
        for method in ("parametric", "exact")
    )
    ratio = ratio_of(case.statistic, wide, narrow)
    p = welch_less(2 * narrow, wide)
    decision = all_of([rank.above(0.9 - 1e-9), ratio.above(2.0)])
    if decision == HOLDS and p >= SIGNIFICANCE:
        decision = UNDECIDED
    return Reading.of(
        decision,
        ratio,
        reason=f"ratio 150/60 deg (exact rays "
        f"{ratio_of(case.statistic, *exact).value:.2f}); Spearman "
        f"{in_words(rank)}; Welch p {p:.1g}",
    )


@claim("c2_fov_generic_flat", needs=SWEPT, evidence="synthetic", readings=ALL)
def judge_fov_generic_flat(results, options):
    """30 to 120 deg: mean within 1.5, SD within 2, below parametric."""
    case = SweepCase(results["fig_2_3_fov"], options)
    mean, sd = (
        trend(
            np.array(FLAT_FOVS),
            [case.trials("generic", quantity, fov_deg=fov) for fov in FLAT_FOVS],
            lambda fovs_deg, medians: medians.max() / medians.min(),
            statistic=case.statistic,
        )
        for quantity in ("mean_px", "sd_px")
    )
    exact_mean, exact_sd = (
        spread_of(
            case.statistic,
            *(case.trials("exact", quantity, fov_deg=fov) for fov in FLAT_FOVS),
        )
        for quantity in ("mean_px", "sd_px")
    )
    generic, parametric = (
        case.trials(method, "mean_px", fov_deg=120)
        for method in ("generic", "parametric")
    )
    ratio = ratio_of(case.statistic, parametric, generic)
    p = welch_less(generic, parametric)
    lower = ratio.above(1.0)
    if lower == HOLDS and p >= SIGNIFICANCE:
        lower = UNDECIDED
    return Reading.of(
        all_of([mean.below(1.5), sd.below(2.0), lower]),
        mean,
        reason=f"max/min of the mean (exact rays {exact_mean:.2f}); of "
        f"the SD {sd.value:.2f} ({sd.low:.2f} to {sd.high:.2f}; exact "
        f"rays {exact_sd:.2f}); parametric/generic at 120 deg "
        f"{ratio.value:.2f}, Welch p {p:.1g}",
    )


@claim("c2_fov_generic_150", needs=SWEPT, evidence="synthetic", readings=ALL)
def judge_fov_generic_150(results, options):
    """Generic mean and SD rise from 120 to 150 deg, more than of exact rays."""
    case = SweepCase(results["fig_2_3_fov"], options)
    both = tuple(case.trials("generic", "mean_px", fov_deg=f) for f in (120, 150))
    (won,) = wins([both], case.statistic)
    sd, over_mean, over_sd = (
        ratio_of(case.statistic, *(of(quantity, fov_deg=f) for f in (150, 120)))
        for of, quantity in (
            (partial(case.trials, "generic"), "sd_px"),
            (case.over_exact, "mean_px"),
            (case.over_exact, "sd_px"),
        )
    )
    return Reading.of(
        all_of(
            [won.decision, *(found.above(1.0) for found in (sd, over_mean, over_sd))]
        ),
        won.ratio,
        reason=f"ratio of means 150/120 deg, Wilcoxon p {won.p:.1g}; of SDs "
        f"{in_words(sd)}; over the ratios of exact rays: means "
        f"{in_words(over_mean)}, SDs {in_words(over_sd)}",
    )


def _excess_left(statistic, finite_150, finite_120, unbounded_150, unbounded_120):
    """Share of the 150/120 ratio's excess over 1 that finite grids keep."""
    over_trials = OVER_TRIALS[statistic]
    finite = over_trials(finite_150) / over_trials(finite_120)
    unbounded = over_trials(unbounded_150) / over_trials(unbounded_120)
    return (finite - 1) / (unbounded - 1)


@claim(
    "c2_infinite_plane_cause", needs=SWEPT, evidence="synthetic", readings=ANY_EXTENT
)
def judge_infinite_plane_cause(results, options):
    """Finite grids halve the rise; the residual follows 1/sin(angle).

    The rise is that beyond exact rays, and the rank correlation is in px of
    the source image: the corrected view is stretched where rays graze.
    """
    case = SweepCase(results["fig_2_3_fov"], options)
    swept = (
        case.over_exact("mean_px", extent=extent, fov_deg=fov)
        for extent in ("finite", "unbounded")
        for fov in (150, 120)
    )
    trials = [with_worst(found, np.nanmax(found)) for found in swept]
    rise = ratio_of(case.statistic, trials[2], trials[3])
    left = bootstrap(partial(_excess_left, case.statistic), *trials)
    scored = case["standard_method"], case["scoring"], "source", "grazing_spearman"
    grazing = case.column(*scored, extent="unbounded", fov_deg=150)
    rank = median_interval(grazing, worst=-1.0)
    decisions = [left.below(0.5), rank.above(0.3 - 1e-9)]
    if rise.above(1.0) != HOLDS:
        decisions.append(rise.above(1.0))
    return Reading.of(
        all_of(decisions),
        left,
        reason="share of the rise from 120 to 150 deg, beyond that of exact "
        "rays, that is left on finite grids (on unbounded planes it is "
        f"{in_words(rise)} times); rank correlation (Spearman) of a ray's "
        "residual in px of the source image with 1/sin of its angle to "
        f"the plane {in_words(rank)}",
    )


@claim("c2_peripheral_noise", needs=SWEPT, evidence="synthetic")
def judge_peripheral_noise(results):
    """Point noise at 150 deg: outer 20 % of field angle over inner 20 %.

    The claim itself names infinite planes and back-projected noise. Noise drawn in mm
    is the same everywhere.
    """
    trials = SweepCase(results["fig_2_3_fov"]).column("point_noise_ratio", fov_deg=150)
    ratio = median_interval(trials)
    decision = FAILS if ratio.high <= 1.5 else UNDECIDED
    if ratio.value > 1.5 and ratio.low > 1:
        decision = HOLDS
    return Reading.of(decision, ratio, reason="ratio of SDs in mm")


def _lower_mean(a: np.ndarray, b: np.ndarray) -> tuple[str, float]:
    """Whether the mean of ``a`` is below that of ``b`` (Welch), and p."""
    p = welch_less(a, b)
    if p < SIGNIFICANCE:
        return HOLDS, p
    return FAILS if welch_less(b, a) < SIGNIFICANCE else UNDECIDED, p


def _better_along_sweep(signs: np.ndarray) -> str:
    """The sweep in words, from signs of parametric less generic residuals."""
    better = np.where(signs > 0, "generic", "parametric")
    turns = np.flatnonzero(better[1:] != better[:-1]) + 1
    if len(turns) == 0:
        return f"{better[0]} better everywhere"
    return f"{better[0]} better, " + ", ".join(
        f"{better[i]} from {FOVS_DEG[i]} deg on" for i in turns
    )


@claim("c2_crossover", needs=SWEPT, evidence="synthetic", readings=ALL)
def judge_crossover(results, options):
    """Parametric better at the lowest, generic at the highest FOV."""
    case = SweepCase(results["fig_2_3_fov"], options)
    found = np.array(
        [
            [case.trials(method, "mean_px", fov_deg=fov) for fov in FOVS_DEG]
            for method in ("parametric", "generic")
        ]
    )
    worst = np.inf if case.statistic == "median" else np.nanmax(found)
    parametric, generic = OVER_TRIALS[case.statistic](with_worst(found, worst))
    signs = np.sign(parametric - generic)
    changes = int(np.sum(np.diff(signs) != 0))
    first, p_first = _lower_mean(found[0, 0], found[1, 0])
    last, p_last = _lower_mean(found[1, -1], found[0, -1])
    decision = all_of([first, last])
    if decision == HOLDS and changes != 1:
        decision = FAILS
    return Reading.of(
        decision,
        _better_along_sweep(signs),
        reason=f"sign changes: {changes}; Welch p {p_first:.1g} at 30 deg, "
        f"{p_last:.1g} at 150 deg",
    )


@claim(
    "c2_modality_independent",
    needs=("fig_2_3_laws",),
    evidence="synthetic",
    readings=OF_LAWS,
)
def judge_modality_independent(results, options):
    """Four projection laws at 90 deg: means within 15 % of each other.

    The laws share rays and noise in every trial, so trials are paired.
    """
    scale = {"residual_scale": options["law_pixels"]}
    case = SweepCase(results["fig_2_3_laws"], options | scale)
    generic, exact = (
        case.trials(method, "mean_px", LAWS, fov_deg=LAWS_FOV_DEG)
        for method in ("generic", "exact")
    )
    trials = [with_worst(found, np.nanmax(found)) for found in generic]
    spread = bootstrap(partial(spread_of, case.statistic), *trials, paired=True)
    return Reading.of(
        spread.below(1.15),
        spread,
        reason=f"largest over smallest of the four means (exact rays "
        f"{spread_of(case.statistic, *exact):.2f})",
    )


@numbers("fig_2_3", needs=SWEPT, evidence="synthetic")
def numbers_fig_2_3(results):
    """The settings that the text states, as they were run."""
    ran = results["fig_2_3_fov"]
    fovs_deg = [condition["fov_deg"] for condition in ran.conditions]
    return {
        "s2_5_1_res": Value(ran.settings["image_px"][0], unit="px"),
        "s2_5_1_pts": Value(ran.settings["points_per_trial"], unit="count"),
        "s2_5_1_trials": Value(ran.trials_per_condition, unit="count"),
        "s2_5_1_fov_min": Value(min(fovs_deg), unit="deg"),
        "s2_5_1_fov_max": Value(max(fovs_deg), unit="deg"),
    }
