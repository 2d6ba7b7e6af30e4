"""Results of this page read: values of the prose, figures, tables, judgements."""

from dataclasses import astuple
from itertools import pairwise, product

import numpy as np
from scipy.stats import binomtest

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
STEP_NAMES = LINEAR_NAMES | {
    "normalised": "normalised coordinates",
    "one_scale": "one scale by least squares",
    "well_conditioned": "no vanishing divisors",
    "cgsp_weighted": "CGSP, weighted",
    "consistent": "CGSP, adjusted with the centre",
}
PRIMARY = {
    "noise": "px",
    "standard_method": "as printed",
    "translation_error": "difference of lengths",
    "ray_point": "true points",
    "statistic_of_trials": "median",
}
QUANTITIES = {
    "centre": "centre",
    "t2": "translation of grid 2",
    "t3": "translation of grid 3",
    "r2": "rotation of grid 2",
    "r3": "rotation of grid 3",
    "ray": "ray to point",
    "point_mm": "moved points",
}
COMPARED = tuple(QUANTITIES)[:6]  # of Fig. 4.2
POSES = ("t2", "t3", "r2", "r3")


def trials_of(result, options, method, stage, quantity, level):
    """Return the trials (n,) of a quantity; a failed one counts as the worst.

    options: of an interpretation; method "standard" is that of the options.
    """
    lengths = options["translation_error"] == "difference of lengths"
    shift = "length_mm" if lengths else "mm"
    rays = "ray_mm" if options["ray_point"] == "true points" else "own_ray_mm"
    names = {
        "centre": "centre_mm",
        "t2": f"t2_{shift}",
        "t3": f"t3_{shift}",
        "r2": "r2_deg",
        "r3": "r3_deg",
        "ray": rays,
    }
    if method == "standard":
        method = STANDARD_METHODS[options["standard_method"]]
    name = names.get(quantity, quantity)
    found = result.column(method, stage, name, domain=options["noise"], noise=level)
    return with_worst(found)


def failures(result, method):
    """Return the number of failed trials of a method."""
    return sum(text is not None for text in result.select().texts(method, "failed"))


def centre_after(result, step):
    """Return the median centre error (mm) after a step, failures as the worst."""
    return Measured.median(with_worst(result.column(step, "centre_mm")))


def gain(result, *steps):
    """Return the ratio of the median errors of two steps, an Estimate."""
    return median_ratio(*result.column(steps, "centre_mm"), paired=True)


def in_words(ratio):
    """Return an Estimate with its interval as text."""
    return rounded(ratio.value, (ratio.low, ratio.high))


def name_values(open_results):
    """Name the numbers of the prose, in the primary interpretation at 0.5 px."""
    result, steps = map(open_results, ("fig_4_2_redrawn", "ext_cgsp_steps"))
    for method in ("as_printed", "cgsp"):
        trials = trials_of(result, PRIMARY, method, "linear", "centre", NOISE_PX)
        value(f"{method}.linear.centre", np.median(trials))
    for before, after in (("normalised", "one_scale"), ("well_conditioned", "cgsp")):
        value(f"gain.{after}", in_words(gain(steps, before, after)))
    for quantity in ("t3", "ray"):
        before, after = (
            trials_of(result, PRIMARY, "as_printed", stage, quantity, NOISE_PX)
            for stage in ("linear", "ba")
        )
        ratio = median_ratio(after, before, paired=True)
        value(f"adjusted.{quantity}", in_words(ratio))


# Fig. 4.2, and the steps from the standard linear stage to CGSP.


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
    for panel, quantity in zip(axes.flat, COMPARED, strict=True):
        for method, stage in CURVES:
            found = [
                median_interval(
                    trials_of(result, PRIMARY, method, stage, quantity, level)
                )
                for level in LEVELS
            ]
            name = LINEAR_NAMES[method]
            look = {
                "look": look_of(name, hollow=stage == "ba"),
                "label": name + STAGES[stage],
            }
            rows += plot_estimates(
                panel, LEVELS, found, (quantity, method, stage), **look
            )
        panel.set(xscale="log", yscale="log", title=QUANTITIES[quantity])
        panel.set_ylabel("Error (deg)" if quantity in ("r2", "r3") else "Error (mm)")
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
    from matplotlib.ticker import FixedFormatter

    result = results["ext_cgsp_steps"]
    drawn, axes = new_figure(height_in=3.4)
    rows = np.arange(len(STEPS))[::-1]
    errors = [astuple(centre_after(result, step)) for step in STEPS]
    middle, low, high = np.array(errors).T
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
    # The last stage follows CGSP only.
    runs = [*product(LINEAR_NAMES, tuple(STAGES)[:3]), ("cgsp", "consistent")]
    rows = [
        (
            LINEAR_NAMES[method] + STAGES[stage],
            *(
                Measured.median(
                    trials_of(result, PRIMARY, method, stage, quantity, NOISE_PX)
                )
                for quantity in SHOWN
            ),
            failures(result, method),
        )
        for method, stage in runs
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
    gains = [Measured(*gain(three, *pair)[:3]) for pair in pairwise(STEPS)]
    return Table(
        {
            "Step": [STEP_NAMES[step] for step in STEPS],
            "Centre, three grids (mm)": [centre_after(three, step) for step in STEPS],
            "Reduction factor": [None, *gains],
            "Failed trials": [failures(three, step) for step in STEPS],
            f"Centre, {MANY_GRIDS} grids (mm)": [
                centre_after(many, step) if step in OF_MANY_GRIDS else None
                for step in STEPS
            ],
        },
        f"Error of the centre at {NOISE_PX} px noise after successive changes of the "
        "standard linear stage: medians over "
        f"{three.trials_per_condition} trials with 95 % intervals, and the factor of "
        "each step. The printed equations require three grids. Failed trials "
        "count as the worst.",
    )


# Tests of the claims of section 4.1.5, as the registry states them.


REDRAWN = "fig_4_2_redrawn"
SWEEP = ("fig_4_2_redrawn",)
BOTH_SWEEPS = ("fig_4_2_redrawn", "fig_4_2_fixed")
ALL = ("noise", "standard_method", "statistic_of_trials")
OF_POSES = ("noise", "standard_method", "translation_error", "statistic_of_trials")
SPREAD = ("noise", "standard_method", "translation_error", "ray_point")
SWEEPS = (
    "noise",
    "standard_method",
    "translation_error",
    "ray_point",
    "statistic_of_trials",
)
LINEAR, ADJUSTED, CGSP = ("standard", "linear"), ("standard", "ba"), ("cgsp", "linear")


def _comparison(results, options, better, worse, quantities=COMPARED):
    """Compare by wins(better < worse) each quantity at every level.

    Returns the arguments of `Reading.of`, with the smallest ratio of medians or means.
    """
    options, result, compared = PRIMARY | options, results[REDRAWN], {}
    for quantity in quantities:
        pairs = [
            tuple(
                trials_of(result, options, *which, quantity, level)
                for which in (better, worse)
            )
            for level in LEVELS
        ]
        won = wins(pairs, options["statistic_of_trials"])
        compared |= zip(product([quantity], LEVELS), won, strict=True)
    at = min(compared, key=lambda key: compared[key].ratio.value)
    decisions = [found.decision for found in compared.values()]
    return (
        all_of(decisions),
        compared[at].ratio,
        "",
        f"smallest ratio of the {options['statistic_of_trials']}s: "
        f"{QUANTITIES[at[0]]} at {at[1]:g}; ahead in {decisions.count(HOLDS)} "
        f"of {len(compared)} comparisons",
    )


@claim("c4_cgsp_beats_std_ba", needs=SWEEP, evidence="synthetic", readings=SWEEPS)
def judge_beats_adjusted(results, options):
    """Unadjusted CGSP against the adjusted standard method."""
    return Reading.of(*_comparison(results, options, CGSP, ADJUSTED))


@claim("c4_cgsp_beats_std", needs=SWEEP, evidence="synthetic", readings=SWEEPS)
def judge_beats_linear(results, options):
    """CGSP against the standard method, both unadjusted."""
    return Reading.of(*_comparison(results, options, CGSP, LINEAR))


@claim("c4_ba_points_better", needs=SWEEP, evidence="synthetic", readings=ALL)
def judge_points_better(results, options):
    """The adjusted poses put the points closer to their true positions."""
    found = _comparison(results, options, ADJUSTED, LINEAR, ("point_mm",))
    return Reading.of(*found)


def _pose_ratios(results, options, over, under):
    """Ratio of the pose errors of two stages: (quantity, level) -> Estimate."""
    options, result = PRIMARY | options, results[REDRAWN]
    return {
        (quantity, level): ratio_of(
            options["statistic_of_trials"],
            trials_of(result, options, *over, quantity, level),
            trials_of(result, options, *under, quantity, level),
            paired=True,
        )
        for quantity, level in product(POSES, LEVELS)
    }


@claim("c4_ba_little_gain", needs=SWEEP, evidence="synthetic", readings=SWEEPS)
def judge_little_gain(results, options):
    """Ray-point error falls; no pose error by more than 20 %."""
    falls, fall, *_ = _comparison(results, options, ADJUSTED, LINEAR, ("ray",))
    ratios = _pose_ratios(results, options, ADJUSTED, LINEAR)
    at = min(ratios, key=lambda key: ratios[key].value)
    return Reading.of(
        all_of([falls, *(found.above(0.8) for found in ratios.values())]),
        ratios[at],
        reason=f"smallest ratio after / before: {QUANTITIES[at[0]]} at {at[1]:g}; "
        f"ray-point error before / after at least {fall.value:.2f}",
    )


@claim("c4_ba_centre_cause", needs=SWEEP, evidence="synthetic", readings=OF_POSES)
def judge_centre_cause(results, options):
    """About the true centre, the adjusted pose errors are half or less."""
    about_true = ("standard", "ba_true_centre")
    ratios = _pose_ratios(results, options, about_true, ADJUSTED)
    at = max(ratios, key=lambda key: ratios[key].value)
    return Reading.of(
        all_of([found.below(0.5) for found in ratios.values()]),
        ratios[at],
        reason=f"largest ratio true / estimated centre: {QUANTITIES[at[0]]} at "
        f"{at[1]:g}",
    )


@claim("c4_ba_rotation_worse", needs=SWEEP, evidence="synthetic", readings=ALL)
def judge_rotation_worse(results, options):
    """The rotation error grows at most levels.

    That of the median by the sign test. In means, which depend on how much a trial
    grows, by the interval of their ratio.
    """
    options, worse, ratios = PRIMARY | options, 0, []
    of_means = options["statistic_of_trials"] == "mean"
    for level in LEVELS:
        before, after = (
            np.concatenate(
                [
                    trials_of(results[REDRAWN], options, *stage, quantity, level)
                    for quantity in ("r2", "r3")
                ]
            )
            for stage in (LINEAR, ADJUSTED)
        )
        ratio = ratio_of(options["statistic_of_trials"], after, before, paired=of_means)
        ratios.append(ratio)
        if of_means:
            worse += ratio.above(1.0) == HOLDS
        else:
            up, down = int(np.sum(after > before)), int(np.sum(after < before))
            sign_test = binomtest(up, up + down, alternative="greater")
            worse += ratio.value > 1 and sign_test.pvalue < 0.05
    by = "the interval of the means' ratio" if of_means else "the sign test"
    return Reading.of(
        worse > len(LEVELS) / 2,
        sorted(ratios, key=lambda found: found.value)[len(ratios) // 2],
        reason=f"after / before at the middle level of that ratio; larger, by "
        f"{by}, at {worse} of {len(LEVELS)} levels",
    )


@claim("c4_sd_smaller", needs=BOTH_SWEEPS, evidence="synthetic", readings=SPREAD)
def judge_sd_smaller(results, options):
    """Scatter of the standard method at least three times that of CGSP."""
    options = PRIMARY | options
    found = {
        (name, quantity, level): bootstrap(
            lambda a, b: _scatter(a) / _scatter(b),
            trials_of(results[name], options, *LINEAR, quantity, level),
            trials_of(results[name], options, *CGSP, quantity, level),
            paired=True,
        )
        for name, quantity, level in product(BOTH_SWEEPS, COMPARED, LEVELS)
    }
    decisions = [one.above(3.0) for one in found.values()]
    name, quantity, level = at = min(found, key=lambda key: found[key].value)
    where = "poses redrawn" if name == REDRAWN else "one configuration"
    return Reading.of(
        all_of(decisions),
        found[at],
        reason=f"smallest ratio of the median absolute deviations: "
        f"{QUANTITIES[quantity]} at {level:g}, {where}; at least 3 in "
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
    settings = results[REDRAWN].settings
    centre = {
        f"fig4_2_c{axis}": Value(at, unit="mm")
        for axis, at in zip("xyz", settings["centre_mm"], strict=True)
    }
    return centre | {
        "fig4_2_fov": Value(settings["fov_deg"], unit="deg"),
        "fig4_2_trials": Value(results[REDRAWN].trials_per_condition, unit="count"),
    }
