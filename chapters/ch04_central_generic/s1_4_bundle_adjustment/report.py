"""Results of this page read: values of the prose, figures, tables, judgements."""

import numpy as np

from chapters.ch04_central_generic.s1_4_bundle_adjustment.experiment import GRIDS
from repro.page import INK, look_of, new_figure, value
from repro.run import (
    FAILS,
    HOLDS,
    UNDECIDED,
    Case,
    Drawing,
    Reading,
    Value,
    claim,
    columns,
    figure,
    median_interval,
    numbers,
)

# Numbers quoted on the page of section 4.1.4.


ONE_POINT = 0.01  # maximum spread of ends that count as one, in spreads of the starts


def name_values(open_results):
    """Name the numbers that the prose quotes: medians over scenes."""
    starts = open_results("exp_c4_centre_ba_unstable")
    rest = starts.column("line_fitting.at_rest")
    spread = starts.column("line_fitting.spread_over_starts")
    found = {
        **{
            f"{scheme}.centre_mm": np.median(
                np.concatenate(starts.arrays(f"{scheme}.ends_mm"))
            )
            for scheme in ("line_fitting", "consistent")
        },
        "linear.centre_mm": np.median(
            np.concatenate(starts.arrays("consistent.starts_mm"))
        ),
        "scenes": starts.trials_per_condition,
        "scenes.one_place": np.sum((rest == 1) & (spread < ONE_POINT)),
        "scenes.no_rest": np.sum(rest < 1),
    }
    for name, number in found.items():
        value(name, number)


# Figure of section 4.1.4: final error of a free centre.


TITLES = {
    "line_fitting": "line fitting",
    "ray_point": "ray-point distances",
    "consistent": "consistent",
}


@figure(
    "ext_free_centre_starts", needs=("exp_c4_centre_ba_unstable",), evidence="synthetic"
)
def free_centre_starts(results):
    """Final against initial error of the centre."""
    result = results["exp_c4_centre_ba_unstable"]
    drawn, axes = new_figure(1, 3, height_in=3.4, sharex=True, sharey=True)
    rows, ends = [], []
    for panel, scheme in zip(axes, TITLES, strict=True):
        starts = result.arrays(f"{scheme}.starts_mm")
        found = result.arrays(f"{scheme}.ends_mm")
        look = look_of(TITLES[scheme]) | {"linestyle": "", "ms": 3, "alpha": 0.6}
        for scene, (x, y) in enumerate(zip(starts, found, strict=True)):
            panel.plot(x, y, **look)
            rows += [(scheme, scene, *run) for run in zip(x, y, strict=True)]
        ends += [*starts, *found]
        panel.set(xscale="log", yscale="log", title=TITLES[scheme])
        panel.set_xlabel("Initial centre error (mm)")
    axes[0].set_ylabel("Final centre error (mm)")
    limits = np.array([np.min(ends), np.max(ends)])
    for panel in axes:
        panel.plot(limits, limits, color=INK, lw=1, ls=":", marker="")
    return Drawing(
        drawn,
        columns(("scheme", "scene", "start_mm", "end_mm"), rows),
        "Final against initial error of the centre for three adjustments that "
        "free it. Each point is one start, and the starts of a scene use the "
        "same data. Above the dotted line the adjustment increases the error. "
        "The starts are linear solutions. A scheme that is independent of its "
        "start gives a horizontal row for each scene.",
    )


# Tests of the claims of section 4.1.4, as the registry states them.


READINGS = {
    "third_scheme": {
        "lines pass near the centre": "line_fitting",
        "ray-point distances": "ray_point",
    },
    "centre_spread": {
        "over starts": "spread_over_starts",
        "over draws of noise": "spread_over_draws",
    },
}
MIN_SHARE, MIN_SPREAD = 0.2, 10.0
EXACT_MM = 1e-9


@claim(
    "c4_centre_ba_unstable",
    needs=("exp_c4_centre_ba_unstable",),
    evidence="synthetic",
    readings=("third_scheme", "centre_spread"),
)
def judge_centre_ba_unstable(results, options):
    """A fifth of the starts end above 1.1 of the best cost, or a spread over 10."""
    case = Case(READINGS, options)
    share, ratio = (
        median_interval(
            results["exp_c4_centre_ba_unstable"].column(
                f"{case['third_scheme']}.{name}"
            )
        )
        for name in ("above_best", case["centre_spread"])
    )
    decisions = (share.above(MIN_SHARE), ratio.above(MIN_SPREAD))
    decision = HOLDS if HOLDS in decisions else UNDECIDED
    if decisions == (FAILS, FAILS):
        decision = FAILS
    return Reading.of(
        decision,
        ratio,
        reason="spread of the centre over that of fixed-centre runs, "
        "median over scenes; a share of "
        f"{share.value:.2f} ({share.low:.2f} to {share.high:.2f}) of "
        "the starts ends above 1.1 times the best cost",
    )


@claim("c4_ba_param_count", needs=("exp_c4_ba_param_count",), evidence="analytic")
def judge_param_count(results):
    """The optimiser's vector has 6 (n - 1) entries."""
    found = _unknowns(results)
    grids, unknowns = (", ".join(map(str, counts)) for counts in (GRIDS, found))
    return Reading.of(
        _as_printed(found),
        float(found[0]),
        "unknowns",
        f"three grids; for {grids} grids {unknowns}",
    )


@claim("c4_raypoint_formula", needs=("exp_c4_raypoint_formula",), evidence="analytic")
def judge_raypoint_formula(results):
    """The closed form equals a search along the line within 1e-9."""
    largest = results["exp_c4_raypoint_formula"].column("largest_mm").max()
    return Reading.of(
        largest < EXACT_MM,
        float(largest),
        "mm",
        "largest difference from the least distance found by golden-section search",
    )


@numbers("sec_4_1_4", needs=("exp_c4_ba_param_count",), evidence="analytic")
def values_of_adjustment(results):
    """The number of unknowns, as a formula where it fits every count; of a ray, two."""
    found = _unknowns(results)
    formula = "6*(n-1)" if _as_printed(found) else ", ".join(map(str, found))
    return {"s4_1_4_ba": Value(formula), "s4_1_4_ray": Value(freedoms_of_a_ray())}


def freedoms_of_a_ray(direction=(0.36, 0.48, 0.8)):
    """Degrees of freedom of a ray through the centre: the rank of its unit direction's
    derivative by three free components.
    """
    along = np.array(direction)
    return int(np.linalg.matrix_rank(np.eye(3) - np.outer(along, along)))


def _unknowns(results):
    result = results["exp_c4_ba_param_count"]
    return [int(result.column("poses", grids=n)[0]) for n in GRIDS]


def _as_printed(found):
    return found == [6 * (n - 1) for n in GRIDS]
