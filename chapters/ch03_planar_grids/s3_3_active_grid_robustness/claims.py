"""Claims of section 3.3.3, decided by the share of the sets that support them."""

import numpy as np
from scipy.stats import spearmanr

from chapters.ch03_planar_grids.s3_3_active_grid_robustness.results import (
    NAMES,
    SWEPT,
    blur_ratios,
    blur_tie,
    lost,
    points_along,
    points_of,
    shares,
    swept,
    wins,
)
from chapters.ch03_planar_grids.s3_3_active_grid_robustness.trials.sweeps import (
    ACTIVE,
    METHODS,
    STATIC,
)
from repro.judge.statistics import median_and_range
from repro.run.experiment import claim
from repro.run.outcomes import Reading
from repro.run.readings import Case

MIN_CONDITIONS, MIN_LEVELS = 0.8, 0.7
MAX_BLUR_RATIO = 1.5
MAX_RANK, MIN_FALL = -0.9, 0.01
VIEWED = {
    "decodable": {"with the rim": "share", "without the rim": "without_rim"},
    "camera_file": {"gamma 2.2": 2.2, "linear": 1.0},
}
ALL = ("corner_window", "second_grid_pictures", "exposure", "corner_measure")
OF_FIRST = ("corner_window", "exposure", "corner_measure")


def of_share(results, options, sweep=None):
    """Return the Reading that no method leaves less in a share of the conditions.

    It must hold in nearly all sets: over the levels of a sweep, or over all
    conditions. Ties count.
    """
    result, taken = swept(results), Case(NAMES, options)
    points = points_along(result, sweep) if sweep else points_of(result)
    least = MIN_LEVELS if sweep else MIN_CONDITIONS
    won = wins(result, points, taken)
    share = won.mean(axis=0)
    beaten = [
        f"{sweep} {level:g}"
        for (sweep, level), sets in zip(points, won, strict=True)
        if not sets.all()
    ]
    return Reading.of_seeds(
        share >= least,
        median_and_range(share),
        "1",
        f"median and range over {len(share)} sets, of {len(points)} conditions each; "
        f"holds in {int(np.sum(share >= least))}; beaten in some set "
        f"at: {', '.join(beaten) or 'none'}; corners left out: "
        f"{left_out(result, points, taken)}",
    )


def left_out(result, points, taken):
    """Return the number of corners that each method missed, as text."""
    counts = {m: int(lost(result, points, m, taken).sum()) for m in METHODS}
    corners = np.prod(result.settings["corners"]) * len(result.levels("set"))
    said = ", ".join(f"{method} {count}" for method, count in counts.items())
    return f"{said} of {corners * len(points)}"


@claim("c3_active_best", needs=SWEPT, evidence="rendered", readings=ALL)
def judge_active_best(results, options):
    """In four fifths of the conditions no method leaves less."""
    return of_share(results, options)


@claim("c3_active_distance", needs=SWEPT, evidence="rendered", readings=OF_FIRST)
def judge_active_distance(results, options):
    """At seven tenths of the distances no method leaves less."""
    return of_share(results, options, "distance")


@claim("c3_active_orientation", needs=SWEPT, evidence="rendered", readings=OF_FIRST)
def judge_active_orientation(results, options):
    """At seven tenths of the orientations no method leaves less."""
    return of_share(results, options, "orientation")


@claim("c3_active_noise", needs=SWEPT, evidence="rendered", readings=ALL)
def judge_active_noise(results, options):
    """At seven tenths of the levels of noise no method leaves less."""
    return of_share(results, options, "noise")


@claim("c3_active_blur", needs=SWEPT, evidence="rendered", readings=ALL)
def judge_active_blur(results, options):
    """Strongest blur over none: no larger than others' or a tie, and at most 1.5."""
    result, taken = swept(results), Case(NAMES, options)
    ratios, tie = blur_ratios(result, taken), blur_tie(result, taken)
    ours, theirs = ratios[ACTIVE], [ratios[method] for method in STATIC]
    holds = (ours <= np.minimum(*theirs) + tie) & (ours <= MAX_BLUR_RATIO)
    medians = ", ".join(f"{m} {np.median(ratio):.3f}" for m, ratio in ratios.items())
    return Reading.of_seeds(
        holds,
        median_and_range(ours),
        "1",
        f"median ratios over {len(ours)} sets: {medians}; a tie is up to "
        f"{np.median(tie):.3f}; holds in {int(holds.sum())}",
    )


@claim(
    "c3_active_viewing_angle",
    needs=("exp_c3_active_viewing_angle",),
    evidence="rendered",
    readings=("decodable", "camera_file"),
)
def judge_active_viewing_angle(results, options):
    """The decoded share of the visible area falls as the monitor rotates."""
    result, taken = results["exp_c3_active_viewing_angle"], Case(VIEWED, options)
    turns = sorted(result.levels("turn_deg"))
    name, gamma = taken["decodable"], taken["camera_file"]
    found = np.array([shares(result, t, name, gamma=gamma) for t in turns])
    fall = np.round(found[0] - found[-1], 9)
    holds = [
        drop > MIN_FALL and spearmanr(turns, along)[0] <= MAX_RANK
        for drop, along in zip(fall, found.T, strict=True)
    ]
    reason = f"fall of the share from 0 to {turns[-1]} deg, median and range over "
    reason += f"{len(fall)} seeds; holds in {sum(holds)}"
    if gamma > 1:
        plain = found[0] - shares(result, turns[-1], name, falloff=0)
        reason += f"; a monitor without fall-off loses {np.median(plain):.3f}"
    return Reading.of_seeds(holds, median_and_range(fall), "1", reason)
