"""Results of the page on CELECT's failures: stages that lost a run, quoted numbers."""

from collections import Counter

import numpy as np

from chapters.ch03_planar_grids.ext_why_it_fails.trials.cases import CASES
from chapters.ch03_planar_grids.ext_why_it_fails.trials.stages import (
    CLICK,
    DONE,
    NO_EDGE,
    TOO_LONG,
    UNSEEN,
    WRONG_EDGE,
)
from chapters.shared.robustness import DEFAULTS
from repro.page.reader import value
from repro.run.columns import columns

SWEEPS = {
    "noise_sd": "noise {0}",
    "blur_px": "blur {0} px",
    "squares_across": "squares {1:.0f} px",
    "fov_deg": "FOV {0}°",
    "yaw_deg": "yaw {0}°",
}
# What the prose calls the drawn levels, in their order.
DRAWN = {2: ("broken", "kept"), 3: ("broken", "kept", "other")}
FORETOLD = ("first_corner", "wrong_contour", "direction")
# Further levels that the prose quotes; a quick build does not run them.
ALSO = (
    ("clearance", "0.05"),
    ("clearance", "0.3"),
    ("window", "0.7"),
    ("window", "1.5"),
)
NOT_RUN = "(not in a quick build)"
TRACED = (NO_EDGE, TOO_LONG, WRONG_EDGE)


def stages_of(result):
    """Level -> stage of every trial, of the levels that were run."""
    levels = result.conditions[0]["levels"]
    return {level: result.texts(f"{level}.stage") for level in levels}


def shares_of(stages):
    """Level -> stage -> share of the trials in %."""
    return {
        level: {
            stage: 100 * count / len(lost) for stage, count in Counter(lost).items()
        }
        for level, lost in stages.items()
    }


def counted(stages):
    """Columns of level, stage, and how many trials it lost there."""
    rows = [
        (level, stage, count)
        for level, lost in stages.items()
        for stage, count in sorted(Counter(lost).items())
    ]
    return columns(("level", "stage", "trials"), rows)


def name_values(open_results):
    """Name every quoted number, from the results of this effort."""
    results = {case: open_results(f"ext_why_{case}") for case in CASES}
    pairs, drawn = {"broken": [], "kept": []}, {}
    for case, result in results.items():
        levels = CASES[case]["drawn"].values()
        for name, level in zip(DRAWN[len(levels)], levels, strict=True):
            lost = stages_of(result)[level]
            drawn[f"{case}_{name}"] = rights(lost)
            pairs["kept" if name == "kept" else "broken"] += lost
    small = stages_of(results["window"])[CASES["window"]["drawn"]["too small"]]
    agree = np.concatenate([foretold(results[case]) for case in FORETOLD])
    orderings = open_results("ext_why_orderings")
    quoted = {
        **drawn,
        **{
            f"{case}_{level}": rights(stages_of(results[case]).get(level))
            for case, level in ALSO
        },
        **of_pairs(pairs),
        **of_sweeps(open_results("ext_why_sweeps")),
        "window_broken_stage": commonest(small).partition(" (")[0],
        "foretold": f"{int(agree.sum())} of {len(agree)}",
        **{
            f"{ordering}_{family}": in_degrees(
                first_failure(orderings, ordering, family)
            )
            for ordering in ("line", "homography")
            for family in ("arc", "fov")
        },
        "line_criterion": agreeing_criterion(orderings),
    }
    for name, text in quoted.items():
        value(name, text)


def in_degrees(bend):
    """Text: the bend at which an ordering fails, or that it never did."""
    return "none that was run" if bend is None else f"{bend:.0f}°"


def rights(stages):
    """Text: how many of the runs ended well; that they were not run, of None."""
    if stages is None:
        return NOT_RUN
    return f"{stages.count(DONE)} of {len(stages)}"


def commonest(stages):
    """Text: the stage that lost the most runs, and how many of the lost."""
    lost = Counter(s for s in stages if s not in (DONE, UNSEEN))
    if not lost:
        return "none"
    stage, count = lost.most_common(1)[0]
    return f"{stage} ({count} of {lost.total()} lost)"


def of_pairs(pairs):
    """pairs: 'broken' and 'kept' -> stages of all runs of such drawn levels."""
    lost = [s for stages in pairs.values() for s in stages if s != DONE]
    traced, clicked = sum(s in TRACED for s in lost), lost.count(CLICK)
    return {
        "pairs_broken": rights(pairs["broken"]),
        "pairs_kept": rights(pairs["kept"]),
        "pairs_lost": len(lost),
        "pairs_traced": traced,
        "pairs_clicked": clicked,
        "pairs_processed": len(lost) - traced - clicked,
    }


def of_sweeps(result):
    """The stage that lost the most runs of each sweep, and of all."""
    stages = {
        name: [
            stage
            for level, trials in result.by(name).items()
            if level != DEFAULTS[name]
            for stage in trials.texts("stage")
        ]
        for name in SWEEPS
    }
    return {
        f"sweep_{name}": commonest(ends) if ends else NOT_RUN
        for name, ends in stages.items()
    } | {"sweep_all": commonest([s for e in stages.values() for s in e])}


def foretold(result):
    """Whether each run was lost on side 1 exactly where 3.1.2 says so: (n,) bool."""
    return np.concatenate(
        [
            (result.column(f"{level}.first_line_wrong") == 1)
            == (np.array(result.texts(f"{level}.contour")) == "side 1")
            for level in result.conditions[0]["levels"]
        ]
    )


def agreeing_criterion(result):
    """Share of trials in which the margin's sign tells the first ordering's outcome."""
    trials = result.select()
    agree = (trials.column("margin") > 0) == (trials.column("line") == 1)
    return f"{100 * agree.mean():.0f} %"


def first_failure(result, name, family):
    """The smallest bend (deg) at which an ordering fails in a trial; None if none."""
    of_bend = result.by("bend_deg", family=family).items()
    return next((b for b, trials in of_bend if trials.column(name).mean() < 1), None)
