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


def name_values(open_results):
    """Name the numbers that the prose quotes: medians over scenes."""
    starts = open_results("exp_c4_centre_ba_unstable")
    for name, *path in (
        ("line_fitting", "line_fitting", "ends_mm"),
        ("consistent", "consistent", "ends_mm"),
        ("linear", "consistent", "starts_mm"),
    ):
        errors = np.concatenate(starts.arrays(*path))
        value(f"{name}.centre_mm", np.median(errors))
    rest, spread = starts.column("line_fitting", ("at_rest", "spread_over_starts"))
    value("scenes", starts.trials_per_condition)
    # Ends count as one point if their spread is below 1 % of that of the starts.
    value("scenes.one_place", np.sum((rest == 1) & (spread < 0.01)))
    value("scenes.no_rest", np.sum(rest < 1))


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
        starts, found = (
            result.arrays(scheme, name) for name in ("starts_mm", "ends_mm")
        )
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


QUESTIONS = {
    "third_scheme": {
        "lines pass near the centre": "line_fitting",
        "ray-point distances": "ray_point",
    },
    "centre_spread": {
        "over starts": "spread_over_starts",
        "over draws of noise": "spread_over_draws",
    },
}


@claim(
    "c4_centre_ba_unstable",
    needs=("exp_c4_centre_ba_unstable",),
    evidence="synthetic",
    readings=("third_scheme", "centre_spread"),
)
def judge_centre_ba_unstable(results, options):
    """A fifth of the starts end above 1.1 of the best cost, or a spread over 10."""
    case = Case(QUESTIONS, options)
    share, ratio = map(
        median_interval,
        results["exp_c4_centre_ba_unstable"].column(
            case["third_scheme"], ("above_best", case["centre_spread"])
        ),
    )
    decisions = {share.above(0.2), ratio.above(10.0)}
    decision = HOLDS if HOLDS in decisions else UNDECIDED
    if decisions == {FAILS}:
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
        largest < 1e-9,
        float(largest),
        "mm",
        "largest difference from the least distance found by golden-section search",
    )


@numbers("sec_4_1_4", needs=("exp_c4_ba_param_count",), evidence="analytic")
def values_of_adjustment(results):
    """The number of unknowns, as a formula where it fits every count; of a ray, two."""
    found = _unknowns(results)
    formula = "6*(n-1)" if _as_printed(found) else ", ".join(map(str, found))
    # A ray through the centre: rank of the derivative of its unit direction.
    along = np.array((0.36, 0.48, 0.8))
    freedoms = np.linalg.matrix_rank(np.eye(3) - np.outer(along, along))
    return {"s4_1_4_ba": Value(formula), "s4_1_4_ray": Value(int(freedoms))}


def _unknowns(results):
    result = results["exp_c4_ba_param_count"]
    return [int(result.column("poses", grids=n)[0]) for n in GRIDS]


def _as_printed(found):
    return found == [6 * (n - 1) for n in GRIDS]
