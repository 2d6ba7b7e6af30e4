"""Results of this page read: values of the prose, figures, tables, judgements."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from chapters.ch02_general_camera_model.s5_1_synthetic_data.experiment import (
    LAWS,
    LAWS_FOV_DEG,
    LEVELS,
    NOISE_FOV_DEG,
)
from chapters.shared.general import FOVS_DEG, SweepCase
from chapters.shared.methods import METHODS, NAMES
from repro.page import look_of, new_figure, plot_estimates
from repro.page import value as name_value
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
from repro.run import columns as columns_of

# Numbers of section 2.5.1 for its prose and its claims.


PRIMARY = {"domain": "px", "extent": "unbounded"}
MEAN = "fresh.corrected.mean_px"


def trials_of(result, method, value, **condition):
    """Return the trials (n,) of one value of a method, failed ones as the worst.

    ``condition`` replaces parts of the primary interpretation. Exact rays have
    fresh noise only; ``over_exact`` is the mean residual on fresh noise as a
    multiple of theirs.
    """
    condition = PRIMARY | condition
    exact = 1.0
    if value == "over_exact":
        value, exact = MEAN, trials_of(result, "exact", MEAN, **condition)
    if method.endswith("exact"):
        value = value.removeprefix("fresh.")
    trials = result.column(f"{method}.{value}", **condition) / exact
    return with_worst(trials, np.nanmax(trials))


def median_of(result, method, value, **condition):
    """Return the median over the trials that `trials_of` returns."""
    return float(np.median(trials_of(result, method, value, **condition)))


def rank_trend(x, medians):
    """Return the rank correlation of medians (n,) with a sweep (n,) without ties."""
    return float(np.corrcoef(np.arange(len(x)), np.argsort(np.argsort(medians)))[0, 1])


def spread_over_sweep(x, medians):
    """Return the largest over the smallest of the medians (n,) of a sweep (n,)."""
    return float(medians.max() / medians.min())


def is_better(fov, method, of, **condition):
    """Return whether a method's median of a value is below the parametric one's."""
    own, other = (median_of(fov, m, of, **condition) for m in (method, "parametric"))
    return own < other


def crossing(fov, method):
    """Return the levels (deg) between which a method becomes the better one.

    In the primary interpretation; the last crossing, where there are several.
    """
    levels = sorted(fov.levels("fov_deg"))
    behind = [at for at in levels if not is_better(fov, method, MEAN, fov_deg=at)]
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
        name_value(name, number)


# Figures of section 2.5.1: residuals of the methods along two sweeps.


NOISE = ("fig_2_3_noise", "noise", LEVELS, "Noise SD (px)")
FOV = ("fig_2_3_fov", "fov_deg", FOVS_DEG, "Field of view (deg)")
FISHEYE = ("fig_2_3_fisheye", *FOV[1:])


class Curve(NamedTuple):
    """A curve to draw: a method, one of its values, and its label."""

    method: str
    value: str
    label: str
    look: dict


def sweep_line(method, value):
    """Return a method's curve in its own style, under its own name."""
    return Curve(method, value, NAMES[method], look_of(NAMES[method]))


class Curves:
    """A figure under construction, with the data of every curve drawn."""

    def __init__(self, results, rows, columns, **layout):
        self.results = results
        self.drawn, self.axes = new_figure(rows, columns, **layout)
        self.rows = []

    def draw(self, axes, sweep, lines, condition=PRIMARY):
        """Draw curves along one sweep: medians over trials, 95 % intervals.

        A failed trial counts as the worst trial.
        """
        experiment, x_name, xs, x_label = sweep
        result = self.results[experiment]
        for one in lines:
            found = [
                median_interval(
                    trials_of(result, one.method, one.value, **{x_name: x}, **condition)
                )
                for x in xs
            ]
            self.rows += plot_estimates(
                axes, xs, found, (x_name, one.value, one.method, *condition.values()),
                look=one.look, label=one.label,
            )  # fmt: skip
        axes.set(yscale="log", xlabel=x_label)
        if x_name == "noise":
            axes.set_xscale("log")
        else:
            axes.set_xticks(range(30, 151, 30))

    def finished(self, caption, columns):
        """Return the drawing, with one legend for all panels."""
        shown = {}
        for axes in self.axes.flat:
            handles, labels = axes.get_legend_handles_labels()
            shown |= dict(zip(labels, handles, strict=True))
        self.drawn.legend(
            shown.values(), shown.keys(), loc="outside lower center", ncols=columns
        )
        return Drawing(self.drawn, columns_of(COLUMNS, self.rows), caption)


COLUMNS = (
    "sweep", "value", "method", "noise_domain", "extent",
    "x", "median", "low", "high",
)  # fmt: skip


@figure("fig_2_3", needs=("fig_2_3_noise", "fig_2_3_fov"), evidence="synthetic")
def fig_2_3(results):
    """Draw mean and SD of the residual in the primary interpretation, both sweeps."""
    curves = Curves(results, 2, 2, height_in=6.4, sharex="col")
    for panels, sweep in zip(curves.axes.T, (NOISE, FOV), strict=True):
        for panel, quantity in zip(panels, ("mean", "sd"), strict=True):
            value = f"fresh.corrected.{quantity}_px"
            curves.draw(
                panel, sweep, [sweep_line(m, value) for m in ("exact", *METHODS)]
            )
        panels[0].set_ylabel("Mean residual (px)")
        panels[1].set_ylabel("SD of residual (px)")
    curves.axes[0, 0].set_title("(a) noise")
    curves.axes[0, 1].set_title("(b) field of view")
    for panel in curves.axes[0]:
        panel.set_xlabel("")
    return curves.finished(
        "Distortion residuals of the parametric and the generic method as a "
        "function of (a) noise and (b) field of view, scored on fresh noise "
        "(primary interpretation). Top: mean, bottom: standard deviation. "
        "*Exact rays* are those of the simulated camera: their residual is "
        "the noise of the scored points. Medians over trials with 95 % "
        "intervals, on logarithmic axes.",
        columns=2,
    )


@figure(
    "ext_fig_2_3_fisheye",
    needs=("fig_2_3_fov", "fig_2_3_fisheye"),
    evidence="synthetic",
)
def ext_fig_2_3_fisheye(results):
    """Draw Fig. 2.3(b) together with OpenCV's fisheye model: residual and rays."""
    curves = Curves(results, 1, 2, height_in=3.8)
    residual, rays = curves.axes
    for panel, value in ((residual, "over_exact"), (rays, "ray_deg")):
        curves.draw(panel, FOV, [sweep_line(m, value) for m in METHODS[:2]])
        curves.draw(panel, FISHEYE, [sweep_line("opencv_fisheye", value)])
    residual.set(ylabel="Mean residual (multiple of exact rays)", title="residual")
    rays.set(ylabel="Median ray error (deg)", title="rays")
    return curves.finished(
        "Residual and ray error in the sweep of Fig. 2.3(b), with OpenCV's "
        "fisheye model, which the thesis did not have. Left: the mean "
        "residual on fresh noise as a multiple of that of exact rays on the "
        "same points, which removes the stretch of the corrected view. "
        "Right: the angle between calibrated and true rays, after the best "
        "rotation. Medians over trials with 95 % intervals.",
        columns=3,
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


def _proportional(statistic: str, series: Callable) -> Reading:
    """Weighted line with R2 >= 0.98, log-log slope in [0.85, 1.15]."""
    levels = np.array(LEVELS)
    trials = [series(level) for level in LEVELS]
    found = [_interval(statistic, t) for t in trials]
    spread = np.array([max(e.high - e.low, 1e-12) for e in found])
    typical = np.array([e.value for e in found])
    # The intervals of the levels are in the weights; R2 itself has none.
    line = weighted_line(levels, typical, 1 / spread**2)
    slope = trend(levels, trials, loglog_slope, statistic=statistic)
    decision = slope.within(0.85, 1.15)
    if line.r2 < 0.98:
        decision = FAILS
    failed = sum(int(np.isnan(t).sum()) for t in trials)
    remark = f"log-log slope; R² of the weighted line {line.r2:.4f}"
    if failed:
        remark += f"; {failed} of {sum(map(len, trials))} trials failed"
    return Reading.of(decision, slope, reason=remark)


@claim("c2_noise_linear_generic", needs=NOISY, evidence="synthetic", readings=ALL)
def judge_noise_linear_generic(results, options):
    """The generic residual grows in proportion to the noise."""
    case = SweepCase(results["fig_2_3_noise"], options)
    return _proportional(
        case.statistic,
        lambda level: case.generic("mean_px", noise=level, fov_deg=NOISE_FOV_DEG),
    )


@claim("c2_noise_linear_persp", needs=NOISY, evidence="synthetic", readings=PARAMETRIC)
def judge_noise_linear_parametric(results, options):
    """The parametric residual grows in proportion to the noise."""
    case = SweepCase(results["fig_2_3_noise"], options)
    return _proportional(
        case.statistic,
        lambda level: case.parametric("mean_px", noise=level, fov_deg=NOISE_FOV_DEG),
    )


@claim("c2_fov_persp_rises", needs=SWEPT, evidence="synthetic", readings=PARAMETRIC)
def judge_fov_parametric_rises(results, options):
    """Spearman >= 0.9, and 150 deg more than twice 60 deg."""
    case = SweepCase(results["fig_2_3_fov"], options)
    trials = [case.parametric("mean_px", fov_deg=fov) for fov in FOVS_DEG]
    rank = trend(np.array(FOVS_DEG), trials, rank_trend, statistic=case.statistic)
    wide, narrow = (case.parametric("mean_px", fov_deg=fov) for fov in (150, 60))
    ratio = ratio_of(case.statistic, wide, narrow)
    exact = ratio_of(
        case.statistic, *(case.exact("mean_px", fov_deg=fov) for fov in (150, 60))
    ).value
    p = welch_less(2 * narrow, wide)
    decision = all_of([rank.above(0.9 - 1e-9), ratio.above(2.0)])
    if decision == HOLDS and p >= SIGNIFICANCE:
        decision = UNDECIDED
    return Reading.of(
        decision,
        ratio,
        reason=f"ratio 150/60 deg (exact rays {exact:.2f}); Spearman "
        f"{rank.value:.2f} ({rank.low:.2f} to {rank.high:.2f}); "
        f"Welch p {p:.1g}",
    )


@claim("c2_fov_generic_flat", needs=SWEPT, evidence="synthetic", readings=ALL)
def judge_fov_generic_flat(results, options):
    """30 to 120 deg: mean within 1.5, SD within 2, below parametric."""
    case = SweepCase(results["fig_2_3_fov"], options)
    spread = {
        quantity: trend(
            np.array(FLAT_FOVS),
            [case.generic(quantity, fov_deg=fov) for fov in FLAT_FOVS],
            spread_over_sweep,
            statistic=case.statistic,
        )
        for quantity in ("mean_px", "sd_px")
    }
    generic = case.generic("mean_px", fov_deg=120)
    parametric = case.parametric("mean_px", fov_deg=120)
    ratio = ratio_of(case.statistic, parametric, generic)
    p = welch_less(generic, parametric)
    lower = ratio.above(1.0)
    if lower == HOLDS and p >= SIGNIFICANCE:
        lower = UNDECIDED
    mean, sd = spread["mean_px"], spread["sd_px"]
    exact = {
        q: spread_of(case.statistic, *(case.exact(q, fov_deg=fov) for fov in FLAT_FOVS))
        for q in spread
    }
    return Reading.of(
        all_of([mean.below(1.5), sd.below(2.0), lower]),
        mean,
        reason=f"max/min of the mean (exact rays {exact['mean_px']:.2f}); of "
        f"the SD {sd.value:.2f} ({sd.low:.2f} to {sd.high:.2f}; exact "
        f"rays {exact['sd_px']:.2f}); parametric/generic at 120 deg "
        f"{ratio.value:.2f}, Welch p {p:.1g}",
    )


@claim("c2_fov_generic_150", needs=SWEPT, evidence="synthetic", readings=ALL)
def judge_fov_generic_150(results, options):
    """Generic mean and SD rise from 120 to 150 deg, more than of exact rays."""
    case = SweepCase(results["fig_2_3_fov"], options)
    quantities = ("mean_px", "sd_px")
    both = tuple(case.generic("mean_px", fov_deg=f) for f in (120, 150))
    won = wins([both], case.statistic)[0]
    rise, beyond = (
        {
            q: ratio_of(case.statistic, *(of(q, fov_deg=f) for f in (150, 120)))
            for q in quantities
        }
        for of in (case.generic, case.over_exact)
    )
    rises = (rise["sd_px"], *beyond.values())
    return Reading.of(
        all_of([won.decision, *(found.above(1.0) for found in rises)]),
        won.ratio,
        reason=f"ratio of means 150/120 deg, Wilcoxon p {won.p:.1g}; of SDs "
        f"{_said(rise['sd_px'])}; over the ratios of exact rays: means "
        f"{_said(beyond['mean_px'])}, SDs {_said(beyond['sd_px'])}",
    )


def _said(found) -> str:
    return f"{found.value:.2f} ({found.low:.2f} to {found.high:.2f})"


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
        case.other(extent=extent).over_exact("mean_px", fov_deg=fov)
        for extent in ("finite", "unbounded")
        for fov in (150, 120)
    )
    trials = [with_worst(found, np.nanmax(found)) for found in swept]
    rise = ratio_of(case.statistic, trials[2], trials[3])
    left = bootstrap(partial(_excess_left, case.statistic), *trials)
    case = case.other(extent="unbounded", residual_scale="source image")
    grazing = case.generic("grazing_spearman", fov_deg=150)
    rank = median_interval(grazing, worst=-1.0)
    decisions = [left.below(0.5), rank.above(0.3 - 1e-9)]
    if rise.above(1.0) != HOLDS:
        decisions.append(rise.above(1.0))
    return Reading.of(
        all_of(decisions),
        left,
        reason="share of the rise from 120 to 150 deg, beyond that of exact "
        "rays, that is left on finite grids (on unbounded planes it is "
        f"{_said(rise)} times); rank correlation (Spearman) of a ray's "
        "residual in px of the source image with 1/sin of its angle to "
        f"the plane {_said(rank)}",
    )


@claim("c2_peripheral_noise", needs=SWEPT, evidence="synthetic")
def judge_peripheral_noise(results):
    """Point noise at 150 deg: outer 20 % of field angle over inner 20 %.

    The claim itself says that the planes are infinite, and that the noise
    is back-projected: noise drawn in mm is the same everywhere.
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


def _who_is_better(signs: np.ndarray) -> str:
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
            [one("mean_px", fov_deg=fov) for fov in FOVS_DEG]
            for one in (case.parametric, case.generic)
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
        _who_is_better(signs),
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
    by_law = (case.generic("mean_px", law=law, fov_deg=LAWS_FOV_DEG) for law in LAWS)
    trials = [with_worst(found, np.nanmax(found)) for found in by_law]
    spread = bootstrap(partial(spread_of, case.statistic), *trials, paired=True)
    exact = spread_of(
        case.statistic,
        *(case.exact("mean_px", law, fov_deg=LAWS_FOV_DEG) for law in LAWS),
    )
    return Reading.of(
        spread.below(1.15),
        spread,
        reason=f"largest over smallest of the four means (exact rays {exact:.2f})",
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
