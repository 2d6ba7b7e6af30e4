"""Tables of 6.3.1: further stages of CELECT, and places on the coded grid."""

from __future__ import annotations

import numpy as np

from chapters.ch03_planar_grids.ext_corner_detection.results import (
    SIGNIFICANT,
    comparisons,
    counts,
    error_ratio,
    name_of,
    of_marks,
    silently_wrong,
    successes,
)
from chapters.ch03_planar_grids.ext_corner_detection.trials.coded import MARKS, OUTCOMES
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
    pictures = [c["picture"] for c in result.conditions]
    cells = {
        "Picture": pictures,
        **{
            f"{method} (%)": [
                100 * float(successes(result, p, method).mean()) for p in pictures
            ]
            for method in METHODS
        },
        "Better than published": [_named(compared, p, better=True) for p in pictures],
        "Worse": [_named(compared, p, better=False) for p in pictures],
    }
    answered = all(
        None not in result.texts(f"{method}.success", picture=picture)
        for picture in pictures
        for method in METHODS
    )
    return Table(
        cells,
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
    rows = []
    for condition in result.conditions:
        picture = condition["picture"]
        for method in METHODS:
            rows.append((picture, method, *_errors(result, picture, method)))
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


def _errors(result, picture, method):
    """(mean, the published mean, largest, candidates per corner)."""
    both = successes(result, picture, method)
    both = both & successes(result, picture, PUBLISHED)
    candidates = result.column(f"{method}.candidates", picture=picture)
    seen = candidates[np.isfinite(candidates)]
    per_corner = float(np.median(seen)) if len(seen) else None
    if not both.any():
        return None, None, None, per_corner
    mean, before, largest = (
        result.column(name, picture=picture)[both]
        for name in (f"{method}.mean_px", f"{PUBLISHED}.mean_px", f"{method}.max_px")
    )
    middle = float(np.median(mean)), float(np.median(before))
    return *middle, float(largest.max()), per_corner


@table("ext_coded_outcomes", needs=("ext_coded_grid_runs",), evidence="rendered")
def ext_coded_outcomes(results):
    """Outcomes by the contrast of the marks, and of grids that are another."""
    result = results["ext_coded_grid_runs"]
    groups = {f"{marks} marks": of_marks(result, marks) for marks in MARKS}
    groups["another code, or no marks"] = [
        c for c in result.conditions if c["grid"] != "coded"
    ]
    rows = [
        (name, *(int(n) for n in sum(counts(result, c) for c in group)))
        for name, group in groups.items()
    ]
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
    found = [counts(result, c) for c in result.conditions]
    cells = {"Picture": [name_of(c) for c in result.conditions]}
    for number, outcome in enumerate(OUTCOMES):
        cells[f"{outcome} (%)"] = [100 * float(n[number]) / trials for n in found]
    cells["wrong marks"] = [_marks(result, c) for c in result.conditions]
    total = int(sum(n.sum() for n in found))
    wrong = int(sum(n[-1] for n in found))
    return Table(
        cells,
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


def _marks(result, condition):
    ordered = result.column("ordered", **condition) == 1
    errors = result.column("errors", **condition)[ordered]
    return float(errors.mean()) if len(errors) else None
