"""Results of this page read: values of the prose, figures, tables, judgements."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_1_simulated.experiment import (
    BASE,
    DEFAULT,
    LENGTH_MM,
    SWEEPS,
    rig_of,
)
from repro.page import INK, legend_below, new_figure, plot_estimates, series, value
from repro.run import (
    FAILS,
    HOLDS,
    OVER_TRIALS,
    Case,
    Drawing,
    Reading,
    Value,
    all_of,
    bootstrap,
    claim,
    columns,
    figure,
    numbers,
    weighted_line,
    wins,
    with_worst,
)

# Trials that Fig. 5.5 and its claims use, and the numbers that the page quotes.


RESULT = "fig_5_5_sweeps"
READINGS = {
    "averaged_trials": {"mean": "mean", "median": "median"},
    "reduced_curve": {
        "distance along the viewing rays": "distance",
        "height over the clamped line": "height",
    },
    "surface_error": {
        "across the whole mirror": "across_mm",
        "along the rays at the corners": "along_mm",
    },
    "row_before": {"found in the picture before": False, "known": True},
    "pixel_pitch": {
        "half of the MegaPlus": "megaplus",
        "APS-C sensor": "d200",
        "small sensor": "olympus",
        "film frame": "film",
    },
    "corner_rows": {"one row of 14": 1, "13 rows of 14": 13},
    "bend_sense": {"convex": 1, "concave": -1},
    "grid_size": {"fills the view": "fills", "one size": "one size"},
}
NOISY = SWEEPS["noise"][1:]
FAR = [depth for depth in SWEEPS["depth"] if depth >= 3000]
NEAR = [depth for depth in SWEEPS["depth"] if depth <= 3000]
MEAN_OF_BEAM = 3 / 8
"""Mean deflection of the beam (5.1) over that of its tip."""


class CurveCase(Case):
    """One interpretation of 5.3.1, with the primary option of all other questions."""

    def __init__(self, options=None):
        super().__init__(READINGS, options)

    @property
    def statistic(self):
        """'mean' or 'median' of the trials."""
        return self["averaged_trials"]

    @property
    def method(self):
        """Name of this interpretation's method in the trials."""
        return "known" if self["row_before"] else self["reduced_curve"]

    def column(self, result, sweep, level, name):
        """A value (trials,) of this set-up at a level; nan where failed."""
        number = SWEEPS[sweep].index(level)
        where = {"pitch": self["pixel_pitch"], "rows": self["corner_rows"],
                 "sense": self["bend_sense"], "grid": self["grid_size"]}  # fmt: skip
        return result.column(f"level_{number}.{name}", sweep=sweep, **where)

    def errors(self, result, sweep, level, stage):
        """Surface errors (trials,) of a stage, mm; the worst where one failed."""
        name = f"{self.method}.{stage}.{self['surface_error']}"
        return self._filled(self.column(result, sweep, level, name))

    def missing(self, result, level):
        """Share (trials,) of the tip's deflection that the linear stage misses."""
        name = f"{self.method}.linear.tip_ratio"
        return self._filled(1 - self.column(result, "depth", level, name))

    def _filled(self, trials):
        """Set a failure to infinity for a median, to the worst trial for a mean."""
        if self.statistic == "median" or np.isnan(trials).all():
            return with_worst(trials)
        return with_worst(trials, np.nanmax(trials))

    def along(self, result, sweep, stage, levels=None):
        """Errors of a stage at the levels of a sweep, a list of (trials,)."""
        return [
            self.errors(result, sweep, level, stage)
            for level in levels or SWEEPS[sweep]
        ]


PRIMARY = CurveCase()


def typical(statistic, trials):
    """Mean or median of trials (n,), an Estimate."""
    return bootstrap(OVER_TRIALS[statistic], trials)


def over_levels(statistic, levels, fit):
    """Estimate of a fit to the levels' means or medians; a draw is one of all levels.

    levels: a list of (n,), where trial i has the same grid and noise at all of them;
    fit: (levels, draws) -> (draws,).
    """
    over = OVER_TRIALS[statistic]
    return bootstrap(
        lambda *trials: fit(np.stack([over(t) for t in trials])), *levels, paired=True
    )


def linear_by_formula(depth, tip, pitch=BASE["pitch"]):
    """Mean surface error of the linear stage that an infinite scene costs, mm.

    It finds Z / (Z + D) of the deflection; the beam's mean is 3/8 of that of its tip.
    """
    return MEAN_OF_BEAM * tip * missing_by_formula(depth, pitch)


def missing_by_formula(depth, pitch=BASE["pitch"]):
    """D / (Z + D), the share of the deflection that the linear stage misses."""
    distance = rig_of(pitch).distance_mm
    return distance / (depth + distance)


def curvature(tip):
    """Curvature of the beam (5.1) at its clamp, 1/m."""
    return 3000 * tip / LENGTH_MM**2


def name_values(open_results):
    """Name the numbers of the prose, in the primary interpretation."""
    result = open_results(RESULT)
    for name, number in quoted(result).items():
        value(name, number)


def quoted(result):
    """Name -> number, of what the prose quotes."""
    default = DEFAULT["depth"]
    return {
        "camera.distance": rig_of(BASE["pitch"]).distance_mm,
        f"ratio.{default:g}": 1 - float(np.mean(PRIMARY.missing(result, default))),
        f"formula.{default:g}": 1 - missing_by_formula(default),
        **{
            f"noise.distance.{level:g}": float(
                np.mean(PRIMARY.errors(result, "noise", level, "final"))
            )
            for level in (0.0, 1.0, 3.0)
        },
    }


# Fig. 5.5 and the bias of the linear stage.


AXES = {
    "noise": "Image noise SD (px)",
    "depth": "Scene depth (mm)",
    "bend": "Curvature at the clamp (1/m)",
}
DEPTH_TICKS, SHARE_TICKS = (500, 1000, 2000, 4000, 8000), (0.05, 0.1, 0.2, 0.5, 0.8)
FORMULA = {"color": INK, "linestyle": ":", "marker": ""}
HEIGHT = CurveCase({"reduced_curve": "height over the clamped line"})
FINAL = (
    ("final, cubic of the image coordinate", PRIMARY, series(1)),
    ("final, cubic of the length", HEIGHT, series(2)),
)
PITCHES = {
    "half of the MegaPlus": series(0),
    "APS-C sensor": series(1),
    "small sensor": series(2),
    "film frame": series(3),
}
UNITS = {"noise": "px", "depth": "mm", "bend": "1/m"}


@figure("fig_5_5", needs=("fig_5_5_sweeps",), evidence="synthetic")
def fig_5_5(results):
    """Mean errors over noise, depth and curvature of the linear and final stages."""
    result, rows = results[RESULT], []
    drawn, axes = new_figure(3, 2, height_in=7.8, sharex="row")
    for (left, right), (sweep, levels) in zip(axes, SWEEPS.items(), strict=True):
        x = [curvature(tip) if sweep == "bend" else tip for tip in levels]
        formula = [_formula(sweep, level) for level in levels]
        left.plot(x, formula, label="linear, by formula", **FORMULA)
        for axis, stage, curves in (
            (left, "linear", (("linear estimate", PRIMARY, series(0)),)),
            (right, "final", FINAL),
        ):
            for label, case, look in curves:
                found = [
                    typical(case.statistic, case.errors(result, sweep, level, stage))
                    for level in levels
                ]
                whose = (sweep, UNITS[sweep], label)
                rows += plot_estimates(axis, x, found, whose, look=look, label=label)
            axis.set_xlabel(AXES[sweep])
            axis.set_ylim(bottom=0)
            if sweep == "depth":
                _log_depth(axis)
        left.set_ylabel("Surface error (mm)")
        right.set_ylabel("Surface error (mm)")
    axes[0, 0].set_title("linear estimate")
    axes[0, 1].set_title("final estimate")
    _legend_of(drawn, axes[0])
    return Drawing(
        drawn,
        columns(("sweep", "unit", "estimate", "level", "mean_mm", "low", "high"), rows),
        "Mean error of the estimated mirror surface against image noise, scene depth "
        "and curvature, of the linear estimate (left) and of the final one (right; "
        "other scale). The final estimate is shown for both interpretations of the "
        "reduced model's cubic. Means of the trials with 95 % intervals; dotted: "
        "error by the assumption of an infinite scene, 3/8 of the tip's deflection "
        "times D/(Z+D).",
    )


def _log_depth(axes):
    axes.set_xscale("log")
    axes.minorticks_off()
    axes.set_xticks(DEPTH_TICKS, [f"{tick}" for tick in DEPTH_TICKS])


def _formula(sweep, level):
    at = DEFAULT | {sweep: level}
    return linear_by_formula(at["depth"], at["bend"])


def _legend_of(drawn, pair):
    """One legend below, of both panels of a row."""
    handles, labels = [], []
    for axis in pair:
        for all_of_figure, own in zip(
            (handles, labels), axis.get_legend_handles_labels(), strict=True
        ):
            all_of_figure += own
    drawn.legend(handles, labels, loc="outside lower center", ncols=2)


@figure("ext_fig_5_5_bias", needs=("fig_5_5_sweeps",), evidence="synthetic")
def ext_fig_5_5_bias(results):
    """Deflection that the linear stage misses, over depth, with D / (Z + D)."""
    result, rows = results[RESULT], []
    drawn, axes = new_figure(height_in=3.9)
    depths = SWEEPS["depth"]
    for name, look in PITCHES.items():
        case = CurveCase({"pixel_pitch": name})
        found = [typical("mean", case.missing(result, depth)) for depth in depths]
        pitch = case["pixel_pitch"]
        label = f"{name}, camera {rig_of(pitch).distance_mm / 1000:.2f} m away"
        rows += plot_estimates(axes, depths, found, (name,), look=look, label=label)
        dotted = [missing_by_formula(depth, pitch) for depth in depths]
        axes.plot(depths, dotted, **FORMULA)
    axes.plot([], [], label="D/(Z+D)", **FORMULA)
    _log_depth(axes)
    axes.set(yscale="log", xlabel=AXES["depth"])
    axes.minorticks_off()
    axes.set_yticks(SHARE_TICKS, [f"{tick:g}" for tick in SHARE_TICKS])
    axes.set_ylabel("Missing share of the deflection")
    legend_below(drawn, axes, ncols=2)
    return Drawing(
        drawn,
        columns(("sensor", "depth_mm", "mean_share", "low", "high"), rows),
        "Share of the tip's deflection that the linear estimate misses, against scene "
        "depth, for four sensors with the same lens, and so four distances D from the "
        "camera to the mirror. Means with 95 % intervals; dotted: D/(Z+D); both axes "
        "are logarithmic.",
    )


# The claims about Fig. 5.5, each tested in every interpretation of the text.


SWEPT = ("fig_5_5_sweeps",)
ALL = (
    "averaged_trials",
    "reduced_curve",
    "surface_error",
    "row_before",
    "pixel_pitch",
    "corner_rows",
    "bend_sense",
    "grid_size",
)
OF_TIP = (
    "averaged_trials",
    "reduced_curve",
    "row_before",
    "pixel_pitch",
    "corner_rows",
    "bend_sense",
    "grid_size",
)
MAX_SLOPE2, MIN_GROWTH, MIN_R2 = 0.04, 3.0, 0.97
PROPORTIONAL, INVERSE = (0.85, 1.15), (-1.3, -0.7)
MAX_RANK, UNCHANGED = -0.7, (0.9, 1.1)


def _slopes(x):
    """Fit for `over_levels`: slope of log y over log x, for y (levels, draws)."""
    t = np.log(x) - np.mean(np.log(x))
    return lambda y: np.tensordot(t, np.log(y), 1) / (t @ t)


def _ranks(y):
    """Fit for `over_levels`: rank correlation of y (levels, draws) with the levels."""
    n = len(y)
    off = np.argsort(np.argsort(y, axis=0), axis=0).T - np.arange(n)
    return 1 - 6 * np.sum(off**2, axis=-1) / (n * (n**2 - 1))


def _in_words(found):
    return f"{found.value:.3g} ({found.low:.3g} to {found.high:.3g})"


def _monotonic(case, result, sweep, rising):
    """Whether the linear error rises, or falls, from each level to the next.

    Returns the decision, the ratio of neighbours nearest to 1 and its place.
    """
    trials, levels = case.along(result, sweep, "linear"), SWEEPS[sweep]
    found = {
        (a, b): over_levels(
            case.statistic,
            [first, second],
            lambda y: y[1] / y[0] if rising else y[0] / y[1],
        )
        for a, b, first, second in zip(
            levels, levels[1:], trials, trials[1:], strict=False
        )
    }
    at = min(found, key=lambda pair: found[pair].value)
    return all_of([one.above(1.0) for one in found.values()]), found[at], at


@claim("c5_slope_small", needs=SWEPT, evidence="analytic")
def judge_slope_small(results):
    """The steepest slope of all calibrated mirrors, and that of the default.

    Slope is that of the metric curve; the sweep's end was set to the printed 0.036
    (E-5.13), so the verdict shows only that the text uses the beam's formula.
    """
    case, result = CurveCase(), results[RESULT]
    most = max(
        np.max(case.column(result, sweep, level, "slope2"))
        for sweep, levels in SWEEPS.items()
        for level in levels
    )
    usual = np.max(case.column(result, "noise", DEFAULT["noise"], "slope2"))
    return Reading.of(
        most <= MAX_SLOPE2,
        float(most),
        reason=f"at {SWEEPS['bend'][-1]:g} mm, the end of the sweep, which was put "
        f"where the printed 0.036 is reached; at {DEFAULT['bend']:g} mm {usual:.4f}",
    )


@claim("c5_noise_final_more", needs=SWEPT, evidence="synthetic", readings=ALL)
def judge_noise_final_more(results, options):
    """From 0.5 to 3 px: growth of the final error over that of the linear one."""
    case, result = CurveCase(options), results[RESULT]
    ends = [
        case.errors(result, "noise", level, stage)
        for stage in ("final", "linear")
        for level in (NOISY[0], NOISY[-1])
    ]
    ratio = over_levels(case.statistic, ends, lambda y: y[1] / y[0] * y[2] / y[3])
    final, linear = (
        over_levels(case.statistic, pair, lambda y: y[1] / y[0])
        for pair in (ends[:2], ends[2:])
    )
    return Reading.of(
        ratio.above(np.nextafter(MIN_GROWTH, 0)),
        ratio,
        reason=f"growth of the final error {_in_words(final)}, of the linear one "
        f"{_in_words(linear)}",
    )


@claim("c5_noise_final_linear", needs=SWEPT, evidence="synthetic", readings=ALL)
def judge_noise_final_linear(results, options):
    """Weighted line with R2 >= 0.97, log-log slope in [0.85, 1.15]."""
    case, result = CurveCase(options), results[RESULT]
    trials = case.along(result, "noise", "final", NOISY)
    found = [typical(case.statistic, t) for t in trials]
    spread = np.array([max(one.high - one.low, 1e-12) for one in found])
    line = weighted_line(
        np.array(NOISY), np.array([one.value for one in found]), 1 / spread**2
    )
    slope = over_levels(case.statistic, trials, _slopes(NOISY))
    decision = slope.within(*PROPORTIONAL) if line.r2 >= MIN_R2 else FAILS
    return Reading.of(
        decision, slope, reason=f"log-log slope; R² of the weighted line {line.r2:.4f}"
    )


@claim("c5_final_beats_linear", needs=SWEPT, evidence="synthetic", readings=ALL)
def judge_final_beats_linear(results, options):
    """wins(final < linear) at every level of the three sweeps with default noise."""
    case, result = CurveCase(options), results[RESULT]
    places = [("noise", DEFAULT["noise"])] + [
        (sweep, level) for sweep in ("depth", "bend") for level in SWEEPS[sweep]
    ]
    pairs = [
        tuple(case.errors(result, *at, stage) for stage in ("final", "linear"))
        for at in places
    ]
    won = dict(zip(places, wins(pairs, case.statistic), strict=True))
    at = min(won, key=lambda place: won[place].ratio.value)
    ahead = sum(one.decision == HOLDS for one in won.values())
    return Reading.of(
        all_of([one.decision for one in won.values()]),
        won[at].ratio,
        reason=f"least ratio linear / final: {at[0]} sweep at {at[1]:g}; the final "
        f"estimate is ahead at {ahead} of {len(won)} levels",
    )


@claim("c5_depth_decreases", needs=SWEPT, evidence="synthetic", readings=ALL)
def judge_depth_decreases(results, options):
    """Linear: falls at every step. Final: rank correlation <= -0.7 up to 3 m."""
    case, result = CurveCase(options), results[RESULT]
    falls, ratio, at = _monotonic(case, result, "depth", rising=False)
    final = case.along(result, "depth", "final", NEAR)
    rank = over_levels(case.statistic, final, _ranks)
    return Reading.of(
        all_of([falls, rank.below(MAX_RANK + 1e-9)]),
        rank,
        reason="rank correlation of depth and final error up to 3000 mm; the linear "
        f"error falls least from {at[0]:g} to {at[1]:g} mm, by a factor of "
        f"{_in_words(ratio)}",
    )


@claim("c5_depth_saturates", needs=SWEPT, evidence="synthetic", readings=ALL)
def judge_depth_saturates(results, options):
    """From 3 m on: the final error within 10 % of that at 3 m, at every level."""
    case, result = CurveCase(options), results[RESULT]
    first, *others = case.along(result, "depth", "final", FAR)
    ratios = [
        over_levels(case.statistic, [first, other], lambda y: y[1] / y[0])
        for other in others
    ]
    most = max(ratios, key=lambda one: abs(np.log(one.value)))
    return Reading.of(
        all_of([one.within(*UNCHANGED) for one in ratios]),
        most,
        reason=f"final error beyond 3000 mm over that at 3000 mm, where it is "
        f"farthest from 1: {FAR[1 + ratios.index(most)]:g} mm",
    )


@claim("c5_curv_linear_rises", needs=SWEPT, evidence="synthetic", readings=ALL)
def judge_curv_linear_rises(results, options):
    """Test that the linear error rises from each curvature to the next."""
    case = CurveCase(options)
    rises, ratio, at = _monotonic(case, results[RESULT], "bend", rising=True)
    return Reading.of(
        rises, ratio, reason=f"least ratio of neighbours: {at[1]:g} over {at[0]:g} mm"
    )


@claim("c5_curv_final_largest", needs=SWEPT, evidence="synthetic", readings=ALL)
def judge_curv_final_largest(results, options):
    """Largest final error over curvature above those over noise and over depth."""
    case, result = CurveCase(options), results[RESULT]
    over = {
        name: case.along(result, name, "final") for name in ("bend", "noise", "depth")
    }
    count = len(over["bend"])
    most = {
        other: over_levels(
            case.statistic,
            [*over["bend"], *over[other]],
            lambda y: np.max(y[:count], axis=0) / np.max(y[count:], axis=0),
        )
        for other in ("noise", "depth")
    }
    at = min(most, key=lambda name: most[name].value)
    return Reading.of(
        all_of([one.above(1.0) for one in most.values()]),
        most[at],
        reason=f"largest final error over curvature over that over {at}; over "
        + ", ".join(f"{name} {_in_words(one)}" for name, one in most.items()),
    )


@claim("c5_bias_inverse_depth", needs=SWEPT, evidence="synthetic", readings=OF_TIP)
def judge_bias_inverse_depth(results, options):
    """Log-log slope of 1 - linear / actual deflection over depth in [-1.3, -0.7]."""
    case, result = CurveCase(options), results[RESULT]
    depths = SWEEPS["depth"]
    trials = [case.missing(result, depth) for depth in depths]
    slope = over_levels(case.statistic, trials, _slopes(depths))
    ends = ", ".join(
        f"{typical(case.statistic, trials[i]).value:.2f} at {depths[i]:g} mm"
        for i in (0, -1)
    )
    return Reading.of(
        slope.within(*INVERSE),
        slope,
        reason=f"share of the deflection left out: {ends}",
    )


@numbers("fig_5_5", needs=SWEPT, evidence="synthetic")
def numbers_fig_5_5(results):
    """Settings that the text states, as run, and its two results."""
    result, case = results[RESULT], CurveCase()
    ran = result.settings
    steepest = float(np.max(case.column(result, "bend", SWEEPS["bend"][-1], "slope2")))
    final = case.along(result, "depth", "final")
    depth = over_levels(case.statistic, final, _steady_from)
    return {
        "fig5_5_f": Value(ran["focal_mm"], unit="mm"),
        "fig5_5_w": Value(ran["image_px"][0], unit="px"),
        "fig5_5_h": Value(ran["image_px"][1], unit="px"),
        "fig5_5_len": Value(ran["mirror_mm"], unit="mm"),
        "fig5_5_ang": Value(ran["mirror_angle_deg"], unit="deg"),
        "fig5_5_defl": Value(ran["default"]["bend"], unit="mm"),
        "fig5_5_depth": Value(ran["default"]["depth"], unit="mm"),
        "fig5_5_noise": Value(ran["default"]["noise"], unit="px"),
        "fig5_5_trials": Value(result.trials_per_condition, unit="count"),
        "fig5_5_depth_thr": Value(
            depth.value,
            (depth.low, depth.high),
            "mm",
            "the least depth swept from which on the final error is within 10 % of "
            "that at 8000 mm",
        ),
        "fig5_5_slope2": Value(
            steepest,
            unit="1",
            put_in="the curvature sweep ends where the beam's tip reaches it (E-5.13)",
        ),
    }


def _steady_from(y):
    """Fit for `over_levels`: the least depth from which on y is within 10 % of its end.

    y: (levels, draws) -> (draws,).
    """
    near = np.abs(y / y[-1] - 1) < UNCHANGED[1] - 1
    steady = np.cumprod(near[::-1], axis=0)[::-1].astype(bool)
    return np.array(SWEEPS["depth"])[np.argmax(steady, axis=0)]
