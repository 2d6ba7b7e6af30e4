"""Tables of 6.3.1: further stages of CELECT, and places on the coded grid."""

from __future__ import annotations

import numpy as np

from chapters.ch03_planar_grids.ext_corner_detection.results import (
    SIGNIFICANT,
    comparisons,
    counts,
    name_of,
    successes,
)
from chapters.ch03_planar_grids.ext_corner_detection.trials.coded import (
    OUTCOMES,
)
from chapters.ch03_planar_grids.ext_corner_detection.trials.further import (
    METHODS,
    OTHERS,
    PUBLISHED,
)
from repro.run.experiment import table
from repro.run.outcomes import Check, Table


@table(
    "ext_further_ideas",
    needs=("ext_further_ideas_runs",),
    evidence="synthetic",
)
def ext_further_ideas(results):
    """Share of pictures in which every corner is right, method by method."""
    result = results["ext_further_ideas_runs"]
    compared = comparisons(result)
    pictures = [c["picture"] for c in result.conditions]
    columns = {
        "picture": pictures,
        "published (%)": [
            f"{100 * successes(result, p, PUBLISHED).mean():.0f}"
            for p in pictures
        ],
    }
    for method in OTHERS:
        columns[f"{method} (%)"] = [
            _cell(compared[picture, method]) for picture in pictures
        ]
    consistent = all(
        np.isclose(
            v["after"] - v["before"],
            (v["gained"] - v["lost"]) / result.trials_per_condition,
        )
        for v in compared.values()
    )
    return Table(
        columns,
        "Pictures in which every corner is found within 8 px, "
        f"{result.trials_per_condition} of each kind. In brackets: pictures "
        "gained and lost against the published stages. *: p < 0.05 by "
        "McNemar's exact test, corrected over the table (Holm).",
        Check(
            consistent,
            "shares differ by just the pictures gained and lost",
        ),
    )


def _cell(values):
    star = " *" if values["p"] < SIGNIFICANT else ""
    return (
        f"{100 * values['after']:.0f} "
        f"(+{values['gained']} −{values['lost']}){star}"
    )


@table(
    "ext_further_errors",
    needs=("ext_further_ideas_runs",),
    evidence="synthetic",
)
def ext_further_errors(results):
    """Errors before localisation and candidates, where both succeed."""
    result = results["ext_further_ideas_runs"]
    rows = []
    for condition in result.conditions:
        picture = condition["picture"]
        for method in METHODS:
            rows.append(
                (picture, method, *_errors(result, picture, method))
            )
    heads = (
        "picture",
        "method",
        "mean error (px)",
        "published, same trials (px)",
        "largest error (px)",
        "candidates per corner",
    )
    candidates = np.array([row[5] for row in rows], float)
    least = float(np.nanmin(candidates)) if len(candidates) else np.nan
    cells = [
        [_text(value) for value in column]
        for column in zip(*rows, strict=True)
    ]
    return Table(
        dict(zip(heads, cells, strict=True)),
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
    per_corner = float(np.median(seen)) if len(seen) else np.nan
    if not both.any():
        return np.nan, np.nan, np.nan, per_corner
    mean, before, largest = (
        result.column(name, picture=picture)[both]
        for name in (
            f"{method}.mean_px",
            f"{PUBLISHED}.mean_px",
            f"{method}.max_px",
        )
    )
    middle = float(np.median(mean)), float(np.median(before))
    return *middle, float(largest.max()), per_corner


def _text(value):
    if isinstance(value, str):
        return value
    return "" if np.isnan(value) else f"{value:.2f}"


@table(
    "ext_coded_places",
    needs=("ext_coded_grid_runs",),
    evidence="rendered",
)
def ext_coded_places(results):
    """What became of the clicked blocks, and how their marks were read."""
    result = results["ext_coded_grid_runs"]
    trials = result.trials_per_condition
    found = [counts(result, c) for c in result.conditions]
    columns = {"picture": [name_of(c) for c in result.conditions]}
    for number, outcome in enumerate(OUTCOMES):
        columns[f"{outcome} (%)"] = [
            f"{100 * n[number] / trials:.0f}" for n in found
        ]
    columns["wrong marks"] = [_marks(result, c) for c in result.conditions]
    total = int(sum(n.sum() for n in found))
    wrong = int(sum(n[-1] for n in found))
    return Table(
        columns,
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
    return f"{errors.mean():.2f}" if len(errors) else ""
