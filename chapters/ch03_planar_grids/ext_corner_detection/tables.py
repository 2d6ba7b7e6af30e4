"""Tables of 6.3.1: further stages of CELECT, and places on the coded grid."""

import numpy as np

from chapters.ch03_planar_grids.ext_corner_detection.results import (
    SIGNIFICANT,
    by_picture,
    comparisons,
    counts,
    error_ratio,
    of_both,
    silently_wrong,
    successes,
)
from chapters.ch03_planar_grids.ext_corner_detection.trials.coded import (
    FALSE_GRIDS,
    MARKS,
    OUTCOMES,
)
from chapters.ch03_planar_grids.ext_corner_detection.trials.further import (
    METHODS,
    OTHERS,
    PUBLISHED,
)
from repro.run.columns import columns
from repro.run.experiment import table
from repro.run.outcomes import Check, Table


@table("ext_further_ideas", needs=("ext_further_ideas_runs",), evidence="synthetic")
def ext_further_ideas(results):
    """Share of pictures in which every corner is right, method by method."""
    result = results["ext_further_ideas_runs"]
    compared = comparisons(result)
    rows = [
        (
            picture,
            *(100 * float(successes(result, picture, m).mean()) for m in METHODS),
            _named(compared, picture, better=True),
            _named(compared, picture, better=False),
        )
        for picture in result.levels("picture")
    ]
    heads = (f"{method} (%)" for method in METHODS)
    outcomes = [result.select().texts(f"{method}.success") for method in METHODS]
    answered = not any(None in of_method for of_method in outcomes)
    return Table(
        columns(("Picture", *heads, "Better than published", "Worse"), rows),
        "Pictures in which every corner is found within 8 px, "
        f"{result.trials_per_condition} of each kind. Better, worse: p < 0.05 "
        "by McNemar's exact test, corrected over the table (Holm).",
        Check(answered, "every method has an outcome in every picture"),
    )


def _named(compared, picture, better):
    """Names of the methods that are significantly better, or worse, or None."""
    found = [
        method
        for method in OTHERS
        if compared[picture, method]["p"] < SIGNIFICANT
        and (compared[picture, method]["after"] > compared[picture, method]["before"])
        == better
    ]
    return ", ".join(found) or None


@table("ext_further_gains", needs=("ext_further_ideas_runs",), evidence="synthetic")
def ext_further_gains(results):
    """What every further stage gains and loses over all kinds of pictures."""
    result = results["ext_further_ideas_runs"]
    compared = comparisons(result)
    rows = []
    for method in OTHERS:
        found = [v for (_, m), v in compared.items() if m == method]
        sure = [v for v in found if v["p"] < SIGNIFICANT]
        rows.append(
            (
                method,
                sum(v["gained"] for v in found),
                sum(v["lost"] for v in found),
                sum(v["after"] > v["before"] for v in sure),
                sum(v["after"] < v["before"] for v in sure),
                error_ratio(result, method),
                silently_wrong(result, method),
            )
        )
    names = (
        "Stage", "Trials gained", "Trials lost", "Kinds better", "Kinds worse",
        "Error, times the published", "Returned with a corner off",
    )  # fmt: skip
    return Table(
        columns(names, rows),
        "The further stages of 6.3.1 against the published ones, over "
        f"{len(result.conditions)} kinds of pictures. Error: of corners before "
        "localisation, median over trials in which both succeed. With the "
        f"published stages, {silently_wrong(result, PUBLISHED)} trials were "
        "returned with a corner more than 8 px off.",
    )


@table("ext_further_errors", needs=("ext_further_ideas_runs",), evidence="synthetic")
def ext_further_errors(results):
    """Errors before localisation and candidates, where both succeed."""
    result = results["ext_further_ideas_runs"]
    rows = [
        (picture, method, *_errors(trials, method))
        for picture, trials in result.by("picture").items()
        for method in METHODS
    ]
    heads = (
        "picture",
        "method",
        "mean error (px)",
        "published, same trials (px)",
        "largest error (px)",
        "candidates per corner",
    )
    candidates = np.array([row[5] for row in rows], float)
    least = float(np.nanmin(candidates))
    return Table(
        columns(heads, rows),
        "Corners before localisation. Errors: median over trials of the "
        "mean, and largest of all corners, in the trials in which both the "
        "method and the published stages succeed. Candidates: detected "
        "along a contour, for every corner on it, in all trials (median).",
        Check(least > 0, f"at least {least:.2g} candidates per corner"),
    )


def _errors(trials, method):
    """(mean, the published mean, largest, candidates per corner)."""
    candidates = trials.column(f"{method}.candidates")
    seen = candidates[np.isfinite(candidates)]
    per_corner = float(np.median(seen)) if len(seen) else None
    names = f"{method}.mean_px", f"{PUBLISHED}.mean_px", f"{method}.max_px"
    mean, before, largest = of_both(trials, method, names)
    if not len(mean):
        return None, None, None, per_corner
    middle = float(np.median(mean)), float(np.median(before))
    return *middle, float(largest.max()), per_corner


@table("ext_coded_outcomes", needs=("ext_coded_grid_runs",), evidence="rendered")
def ext_coded_outcomes(results):
    """Outcomes by the contrast of the marks, and of grids that are another."""
    result = results["ext_coded_grid_runs"]
    groups = {
        f"{marks} marks": [counts(result.select(grid="coded", marks=marks))]
        for marks in MARKS
    }
    groups["another code, or no marks"] = [
        counts(result.select(grid=grid)) for grid in FALSE_GRIDS
    ]
    rows = [(name, *sum(found).tolist()) for name, found in groups.items()]
    return Table(
        columns(("Grid", *OUTCOMES), rows),
        "Clicked blocks of 6 × 6 corners by what became of them, over all "
        "fields of view and noises. Of grids that are not the one looked for, "
        "every answer would be wrong.",
    )


@table("ext_coded_places", needs=("ext_coded_grid_runs",), evidence="rendered")
def ext_coded_places(results):
    """What became of the clicked blocks, and how their marks were read."""
    result = results["ext_coded_grid_runs"]
    trials = result.trials_per_condition
    found = {name: counts(of) for name, of in by_picture(result).items()}
    rows = [
        (name, *(100 * found[name] / trials).tolist(), _marks(of))
        for name, of in by_picture(result).items()
    ]
    of_all = sum(found.values())
    total, wrong = int(of_all.sum()), int(of_all[-1])
    heads = (f"{outcome} (%)" for outcome in OUTCOMES)
    return Table(
        columns(("Picture", *heads, "wrong marks"), rows),
        f"Blocks of 6 × 6 corners, {trials} of each kind: contrast of the "
        "marks, field of view, noise SD in grey levels. Right: every corner "
        "within 8 px and with its true number on the grid. A corner off: "
        "the numbers are true, but not all corners within 8 px. Wrong marks: "
        "of the 25 of a block, at the best place, on average where all "
        "corners are within 8 px.",
        Check(
            total == trials * len(found) and wrong <= 0.01 * total,
            f"{wrong} of {total} blocks are put in a wrong place",
        ),
    )


def _marks(trials):
    errors = trials.column("errors")[trials.column("ordered") == 1]
    return float(errors.mean()) if len(errors) else None
