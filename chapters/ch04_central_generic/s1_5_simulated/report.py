"""Results of this page read: values of the prose, figures, tables, judgements."""

from itertools import pairwise, product

import numpy as np
from matplotlib.ticker import FixedFormatter

from chapters.ch04_central_generic.s1_5_simulated.experiment import (
    LEVELS,
    MANY_GRIDS,
    NOISE_PX,
    OF_MANY_GRIDS,
    STEPS,
)
from chapters.shared.methods import LINEAR_NAMES, STANDARD_METHODS
from repro.page import (
    legend_below,
    look_of,
    new_figure,
    plot_estimates,
    rounded,
    series,
    value,
)
from repro.run import (
    HOLDS,
    Case,
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
    median_interval,
    median_ratio,
    numbers,
    ratio_of,
    table,
    wins,
    with_worst,
)

# Trials behind Fig. 4.2 and its claims, and the numbers that the page quotes.


STAGES = {
    "linear": "",
    "ba": " + adjustment",
    "ba_true_centre": " + adjustment about the true centre",
    "consistent": " + adjustment of the centre too",
}
# Methods and stages; the last stage follows CGSP only.
RUNS = [
    (method, stage)
    for method, stage in product(LINEAR_NAMES, STAGES)
    if stage != "consistent" or method == "cgsp"
]
STEP_NAMES = LINEAR_NAMES | {
    "normalised": "normalised coordinates",
    "one_scale": "one scale by least squares",
    "well_conditioned": "no vanishing divisors",
    "cgsp_weighted": "CGSP, weighted",
    "consistent": "CGSP, adjusted with the centre",
}
READINGS = {
    "noise": {"px": "px", "mm": "mm"},
    "standard_method": STANDARD_METHODS,
    "translation_error": {
        "difference of lengths": "length_mm",
        "length of the difference": "mm",
    },
    "ray_point": {"true points": "ray_mm", "noisy points": "own_ray_mm"},
    "statistic_of_trials": {"median": "median", "mean": "mean"},
}
QUANTITIES = ("centre", "t2", "t3", "r2", "r3", "ray")
WORDS = {
    "centre": "centre",
    "t2": "translation of grid 2",
    "t3": "translation of grid 3",
    "r2": "rotation of grid 2",
    "r3": "rotation of grid 3",
    "ray": "ray to point",
}


class NoiseCase(Case):
    """One interpretation of 4.1.5; options that are not given are the primary ones."""

    def __init__(self, options=None):
        super().__init__(READINGS, options)

    def name(self, quantity):
        """Return the column of a quantity of Fig. 4.2, or the name itself."""
        return {
            "centre": "centre_mm",
            "t2": f"t2_{self['translation_error']}",
            "t3": f"t3_{self['translation_error']}",
            "r2": "r2_deg",
            "r3": "r3_deg",
            "ray": self["ray_point"],
        }.get(quantity, quantity)

    def trials(self, result, method, stage, quantity, noise):
        """Return the trials (n,) of a quantity; a failed one counts as the worst."""
        if method == "standard":
            method = self["standard_method"]
        name = f"{method}.{stage}.{self.name(quantity)}"
        return with_worst(result.column(name, domain=self["noise"], noise=noise))


PRIMARY = NoiseCase()


def medians(result, case, method, stage, quantity):
    """Return the medians at the noise levels, [Estimate, ...]."""
    return [
        median_interval(case.trials(result, method, stage, quantity, level))
        for level in LEVELS
    ]


def failures(result, method):
    """Return the numbers of failed trials of a method and of all trials."""
    texts = result.select().texts(f"{method}.failed")
    return sum(text is not None for text in texts), len(texts)


def centre_after(result, step):
    """Return the median centre error (mm) after a step, an Estimate.

    Failures count as the worst.
    """
    return median_interval(with_worst(result.column(f"{step}.centre_mm")))


def gain(result, one, other):
    """Return the ratio of the median errors of two steps, an Estimate."""
    errors = (result.column(f"{step}.centre_mm") for step in (one, other))
    return median_ratio(*errors, paired=True)


def in_words(ratio):
    """Return an Estimate with its interval as text."""
    return rounded(ratio.value, (ratio.low, ratio.high))


def name_values(open_results):
    """Name the numbers of the prose, in the primary interpretation at 0.5 px."""
    result, steps = map(open_results, ("fig_4_2_redrawn", "ext_cgsp_steps"))
    for method in ("as_printed", "cgsp"):
        trials = PRIMARY.trials(result, method, "linear", "centre", 0.5)
        value(f"{method}.linear.centre", np.median(trials))
    for before, after in pairwise(STEPS):
        if after in ("one_scale", "cgsp"):
            value(f"gain.{after}", in_words(gain(steps, before, after)))
    for quantity in ("t3", "ray"):
        value(f"adjusted.{quantity}", change_by_adjustment(result, quantity))


def change_by_adjustment(result, quantity):
    """Return the ratio of the median errors after and before adjustment, as text."""
    after, before = (
        PRIMARY.trials(result, "as_printed", stage, quantity, 0.5)
        for stage in ("ba", "linear")
    )
    return in_words(median_ratio(after, before, paired=True))


# Fig. 4.2, and the steps from the standard linear stage to CGSP.


UNITS = {"r2": "deg", "r3": "deg"}
CURVES = (
    ("as_printed", "linear"),
    ("as_printed", "ba"),
    ("well_conditioned", "linear"),
    ("cgsp", "linear"),
)


@figure("fig_4_2", needs=("fig_4_2_redrawn",), evidence="synthetic")
def fig_4_2(results):
    """Six errors against the noise level, in the primary interpretation."""
    result = results["fig_4_2_redrawn"]
    drawn, axes = new_figure(2, 3, height_in=5.6, sharex=True)
    rows = []
    for panel, quantity in zip(axes.flat, QUANTITIES, strict=True):
        for method, stage in CURVES:
            found = medians(result, PRIMARY, method, stage, quantity)
            name = LINEAR_NAMES[method]
            look = {
                "look": look_of(name, hollow=stage == "ba"),
                "label": name + STAGES[stage],
            }
            rows += plot_estimates(
                panel, LEVELS, found, (quantity, method, stage), **look
            )
        panel.set(xscale="log", yscale="log", title=WORDS[quantity])
        panel.set_ylabel(f"Error ({UNITS.get(quantity, 'mm')})")
    for panel in axes[1]:
        panel.set_xlabel("Noise SD (px)")
    legend_below(drawn, axes[0, 0], ncols=2)
    return Drawing(
        drawn,
        columns(
            ("quantity", "method", "stage", "noise_px", "median", "low", "high"), rows
        ),
        "Errors of the centre, of the poses of grids 2 and 3, and of the rays "
        "against the pixel noise. Methods: standard as printed, the same with "
        "bundle adjustment, standard well conditioned, and CGSP. Medians over "
        "trials with 95 % intervals, logarithmic axes. The translation error "
        "is that of the length, as in the thesis.",
    )


@figure("ext_what_cgsp_buys_figure", needs=("ext_cgsp_steps",), evidence="synthetic")
def what_cgsp_buys(results):
    """Centre error after every change, from top to bottom."""
    result = results["ext_cgsp_steps"]
    drawn, axes = new_figure(height_in=3.4)
    rows = np.arange(len(STEPS))[::-1]
    middle, low, high = np.array([centre_after(result, step)[:3] for step in STEPS]).T
    look = series(0) | {"linestyle": ""}
    axes.errorbar(middle, rows, xerr=[middle - low, high - middle], capsize=3, **look)
    axes.set_yticks(rows)
    axes.yaxis.set_major_formatter(FixedFormatter([STEP_NAMES[step] for step in STEPS]))
    axes.set(xscale="log", xlabel="Median error of the centre (mm)")
    return Drawing(
        drawn,
        columns(
            ("method", "median_mm", "low_mm", "high_mm"),
            zip(STEPS, middle, low, high, strict=True),
        ),
        f"Error of the camera's centre at {NOISE_PX} px noise, from the standard "
        "linear stage as printed (top) to CGSP and its extensions, with one "
        "change per line. Medians over trials with 95 % intervals, logarithmic "
        "axis.",
    )


# All methods of section 4.1.5 at one noise level, and the steps between them.


SHOWN = {
    "centre_mm": "Centre (mm)",
    "t2_mm": "Translation 2 (mm)",
    "r2_deg": "Rotation 2 (deg)",
    "ray_mm": "Ray to true point (mm)",
    "point_mm": "Moved points (mm)",
}


@table("ext_fig_4_2_methods", needs=("fig_4_2_redrawn",), evidence="synthetic")
def ext_fig_4_2_methods(results):
    """Medians at 0.5 px of every method, linear and adjusted."""
    result = results["fig_4_2_redrawn"]
    rows = [
        (
            LINEAR_NAMES[method] + STAGES[stage],
            *(
                Measured.median(
                    PRIMARY.trials(result, method, stage, quantity, NOISE_PX)
                )
                for quantity in SHOWN
            ),
            failures(result, method)[0],
        )
        for method, stage in RUNS
    ]
    return Table(
        columns(("Method", *SHOWN.values(), "Failed trials"), rows),
        "Errors of all methods at 0.5 px noise: medians over trials with 95 % "
        "intervals. *Translation*: here the length of the difference. *Moved "
        "points*: mean displacement of the points of grids 2 and 3 by the pose "
        "errors. *Failed trials*: number at all noise levels; they count as the "
        "worst.",
    )


@table(
    "ext_cgsp_steps_table",
    needs=("ext_cgsp_steps", "ext_cgsp_grids"),
    evidence="synthetic",
)
def cgsp_steps(results):
    """Median error of the centre after every change, with three grids and with ten."""
    three, many = results["ext_cgsp_steps"], results["ext_cgsp_grids"]
    gains = [gain(three, *pair) for pair in pairwise(STEPS)]
    with_many = [
        Measured(*centre_after(many, step)[:3]) if step in OF_MANY_GRIDS else None
        for step in STEPS
    ]
    return Table(
        {
            "Step": [STEP_NAMES[step] for step in STEPS],
            "Centre, three grids (mm)": [
                Measured(*centre_after(three, step)[:3]) for step in STEPS
            ],
            "Reduction factor": [None, *(Measured(*ratio[:3]) for ratio in gains)],
            "Failed trials": [failures(three, step)[0] for step in STEPS],
            f"Centre, {MANY_GRIDS} grids (mm)": with_many,
        },
        f"Error of the centre at {NOISE_PX} px noise after successive changes of the "
        "standard linear stage: medians over "
        f"{three.trials_per_condition} trials with 95 % intervals, and the factor of "
        "each step. The printed equations require three grids. Failed trials "
        "count as the worst.",
    )


# Tests of the claims of section 4.1.5, as the registry states them.


REDRAWN, FIXED = "fig_4_2_redrawn", "fig_4_2_fixed"
SWEEP = ("fig_4_2_redrawn",)
BOTH_SWEEPS = ("fig_4_2_redrawn", "fig_4_2_fixed")
STATISTIC = "statistic_of_trials"
ALL = ("noise", "standard_method", "statistic_of_trials")
POSES = ("noise", "standard_method", "translation_error", "statistic_of_trials")
SPREAD = ("noise", "standard_method", "translation_error", "ray_point")
SWEEPS = (
    "noise",
    "standard_method",
    "translation_error",
    "ray_point",
    "statistic_of_trials",
)
MIN_GAIN, HALF, MIN_SPREAD = 0.8, 0.5, 3.0
LINEAR, ADJUSTED = ("standard", "linear"), ("standard", "ba")
ABOUT_TRUE_CENTRE, CGSP = ("standard", "ba_true_centre"), ("cgsp", "linear")


def _ahead(results, options, better, worse, quantities=QUANTITIES):
    """wins(better < worse) for each quantity at every level.

    Returns the decision, the least ratio of the medians or means, and where that is,
    in words.
    """
    case, compared = NoiseCase(options), {}
    for quantity in quantities:
        pairs = [
            tuple(
                case.trials(results[REDRAWN], *which, quantity, level)
                for which in (better, worse)
            )
            for level in LEVELS
        ]
        won = wins(pairs, case[STATISTIC])
        compared |= zip(product([quantity], LEVELS), won, strict=True)
    at = min(compared, key=lambda key: compared[key].ratio.value)
    held = sum(found.decision == HOLDS for found in compared.values())
    words = WORDS.get(at[0], "moved points")
    return (
        all_of([found.decision for found in compared.values()]),
        compared[at].ratio,
        f"least ratio of the {case[STATISTIC]}s: {words} at {at[1]:g}; ahead in {held} "
        f"of {len(compared)} comparisons",
    )


def _judged_ahead(*given, **named):
    decision, least, words = _ahead(*given, **named)
    return Reading.of(decision, least, reason=words)


@claim("c4_cgsp_beats_std_ba", needs=SWEEP, evidence="synthetic", readings=SWEEPS)
def judge_beats_adjusted(results, options):
    """Unadjusted CGSP against the adjusted standard method."""
    return _judged_ahead(results, options, CGSP, ADJUSTED)


@claim("c4_cgsp_beats_std", needs=SWEEP, evidence="synthetic", readings=SWEEPS)
def judge_beats_linear(results, options):
    """CGSP against the standard method, both unadjusted."""
    return _judged_ahead(results, options, CGSP, LINEAR)


@claim("c4_ba_points_better", needs=SWEEP, evidence="synthetic", readings=ALL)
def judge_points_better(results, options):
    """The adjusted poses put the points closer to their true positions."""
    return _judged_ahead(results, options, ADJUSTED, LINEAR, ("point_mm",))


def _pose_ratios(results, options, over, under):
    """Ratio of the pose errors of two stages: (quantity, level) -> Estimate."""
    case, result = NoiseCase(options), results[REDRAWN]
    return {
        (quantity, level): ratio_of(
            case[STATISTIC],
            case.trials(result, *over, quantity, level),
            case.trials(result, *under, quantity, level),
            paired=True,
        )
        for quantity, level in product(QUANTITIES[1:5], LEVELS)
    }


@claim("c4_ba_little_gain", needs=SWEEP, evidence="synthetic", readings=SWEEPS)
def judge_little_gain(results, options):
    """Ray-point error falls; no pose error by more than 20 %."""
    falls, fall, _ = _ahead(results, options, ADJUSTED, LINEAR, ("ray",))
    left = _pose_ratios(results, options, ADJUSTED, LINEAR)
    at = min(left, key=lambda key: left[key].value)
    return Reading.of(
        all_of([falls, *(found.above(MIN_GAIN) for found in left.values())]),
        left[at],
        reason=f"least ratio after / before: {WORDS[at[0]]} at {at[1]:g}; "
        f"ray-point error before / after at least {fall.value:.2f}",
    )


@claim("c4_ba_centre_cause", needs=SWEEP, evidence="synthetic", readings=POSES)
def judge_centre_cause(results, options):
    """About the true centre, the adjusted pose errors are half or less."""
    left = _pose_ratios(results, options, ABOUT_TRUE_CENTRE, ADJUSTED)
    at = max(left, key=lambda key: left[key].value)
    return Reading.of(
        all_of([found.below(HALF) for found in left.values()]),
        left[at],
        reason=f"largest ratio true / estimated centre: {WORDS[at[0]]} at {at[1]:g}",
    )


@claim("c4_ba_rotation_worse", needs=SWEEP, evidence="synthetic", readings=ALL)
def judge_rotation_worse(results, options):
    """The rotation error grows at most levels.

    That of the median by the sign test. In means, which depend on how much a trial
    grows, by the interval of their ratio.
    """
    case, worse, ratios = NoiseCase(options), 0, []
    of_means = case[STATISTIC] == "mean"
    for level in LEVELS:
        before, after = (
            np.concatenate(
                [
                    case.trials(results[REDRAWN], *stage, quantity, level)
                    for quantity in ("r2", "r3")
                ]
            )
            for stage in (LINEAR, ADJUSTED)
        )
        ratios.append(ratio_of(case[STATISTIC], after, before, paired=of_means))
        if of_means:
            worse += ratios[-1].above(1.0) == HOLDS
        else:
            worse += ratios[-1].value > 1 and _grows_by_sign(before, after)
    by = "the interval of the means' ratio" if of_means else "the sign test"
    middle = sorted(ratios, key=lambda found: found.value)[len(ratios) // 2]
    return Reading.of(
        worse > len(LEVELS) / 2,
        middle,
        reason=f"after / before at the middle level of that ratio; larger, by "
        f"{by}, at {worse} of {len(LEVELS)} levels",
    )


def _grows_by_sign(before, after):
    """Whether more trials grow than shrink, p < 0.05 by the sign test."""
    from scipy.stats import binomtest

    up, down = np.sum(after > before), np.sum(after < before)
    p = binomtest(int(up), int(up + down), alternative="greater").pvalue
    return p < 0.05


@claim("c4_sd_smaller", needs=BOTH_SWEEPS, evidence="synthetic", readings=SPREAD)
def judge_sd_smaller(results, options):
    """Scatter of the standard method at least three times that of CGSP."""
    case = NoiseCase(options)
    found = {
        (name, quantity, level): bootstrap(
            lambda a, b: _scatter(a) / _scatter(b),
            case.trials(results[name], *LINEAR, quantity, level),
            case.trials(results[name], *CGSP, quantity, level),
            paired=True,
        )
        for name, quantity, level in product((REDRAWN, FIXED), QUANTITIES, LEVELS)
    }
    decisions = [one.above(MIN_SPREAD) for one in found.values()]
    at = min(found, key=lambda key: found[key].value)
    where = "poses redrawn" if at[0] == REDRAWN else "one configuration"
    return Reading.of(
        all_of(decisions),
        found[at],
        reason=f"least ratio of the median absolute deviations: {WORDS[at[1]]} "
        f"at {at[2]:g}, {where}; at least {MIN_SPREAD:g} in "
        f"{decisions.count(HOLDS)} of {len(found)}",
    )


def _scatter(trials):
    """Median absolute deviation along the last axis; failures count as far off."""
    middle = np.median(trials, axis=-1, keepdims=True)
    with np.errstate(invalid="ignore"):
        return np.median(np.abs(trials - middle), axis=-1)


@numbers("fig_4_2", needs=SWEEP, evidence="synthetic")
def settings_of_fig_4_2(results):
    """The settings that the text states, as they were run."""
    result = results[REDRAWN]
    x, y, z = result.settings["centre_mm"]
    return {
        "fig4_2_cx": Value(x, unit="mm"),
        "fig4_2_cy": Value(y, unit="mm"),
        "fig4_2_cz": Value(z, unit="mm"),
        "fig4_2_fov": Value(result.settings["fov_deg"], unit="deg"),
        "fig4_2_trials": Value(result.trials_per_condition, unit="count"),
    }
