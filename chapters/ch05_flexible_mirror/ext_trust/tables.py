"""Targets beside what was measured, and predicted beside true errors."""

import numpy as np

from chapters.ch05_flexible_mirror.ext_trust.results import (
    ASTRAY_DEG,
    KNOWN_VIEWER,
    OWN_SPACE,
    RUNS,
    STAGES,
    SURFACES,
    TARGETS,
    WAYS,
    astray,
    coverage,
    measured,
    met,
)
from repro.run.columns import columns
from repro.run.experiment import table
from repro.run.outcomes import Measured, Table

PHYSICAL, SPLINES = "0.5 to 2", "0.7 to 1.4"


@table("ext_mirror_targets", needs=("ext_mirror_trust_runs",), evidence="synthetic")
def targets(results):
    """Every target, on both geometries, with the prior and without."""
    result, rows = results[RUNS], []
    for target in TARGETS:
        found = {
            (geometry, way): measured(result, target, geometry, way)
            for geometry in "AB"
            for way in WAYS
        }
        rows.append(
            (
                f"{target.words} ({target.unit})",
                f"below {target.bound:g}",
                *(met(found[geometry, "prior"], target.bound) for geometry in "AB"),
                *(Measured.median_or_none(values) for values in found.values()),
            )
        )
    lost = {(g, way): astray(result, g, way) for g in "AB" for way in WAYS}
    said = ("met" if lost[g, "prior"] == 0 else "not met" for g in "AB")
    rows.append((f"Gone astray ({seeds(result)} seeds)", "0", *said, *lost.values()))
    names = [f"{g}, {words}" for g in "AB" for words in WAYS.values()]
    return Table(
        columns(("Error", "Wanted", "A", "B", *names), rows),
        "What was aimed at before the first run, and what was measured: medians over "
        f"{result.trials_per_condition} seeds with 95 % intervals, for geometries A "
        "and B, with the prior and without. *Not surely*: the interval holds the "
        "bound. Seeds that were refused count as the worst; no number: most were. "
        "Deflections are from stage 0 on, in percent of the true one; rays are "
        "compared over the whole mirror. A seed has gone astray where it was refused "
        f"at a stage, or a mean ray is off by more than {ASTRAY_DEG:g} degree. All "
        "corners after: added when the row above had been missed, and no aim.",
    )


def seeds(result):
    """Number of all seeds of one geometry, smooth and uneven."""
    return result.trials_per_condition * len(SURFACES)


@table(
    "ext_mirror_coverage_table",
    needs=("ext_mirror_trust_runs", "ext_mirror_own_space", "ext_mirror_known_viewer"),
    evidence="synthetic",
)
def coverage_table(results):
    """Squared ray errors over predicted ones, by how the prediction was made."""
    runs, own, rows = results[RUNS], results[OWN_SPACE], []
    for geometry in "AB":
        trials = own.select(geometry=geometry)
        rows += [
            _row(trials, geometry, "a spline itself", "bundle", part, "", SPLINES)
            for part in PARTS
        ]
        for name, surface in SURFACES.items():
            trials = runs.select(geometry=geometry, **surface)
            rows += [
                _row(trials, geometry, name, "bundle", part, "prior.bundle.", PHYSICAL)
                for part in PARTS
            ]
            rows.append(_row(trials, geometry, name, "stage", None, "prior.", PHYSICAL))
    sure = results[KNOWN_VIEWER]
    rows += [
        _row(sure.select(), "B", "smooth, viewer exact", "bundle", part, "", PHYSICAL)
        for part in PARTS
    ]
    stages = [f"Stage {k} (1)" for k in STAGES]
    return Table(
        columns(("Rig", "Mirror", "Prediction", "Rays", *stages, "Wanted"), rows),
        "Mean squared error of the rays over what was predicted: 1 where a prediction "
        "is right, more where it promises too much. Means over "
        f"{runs.trials_per_condition} seeds with 95 % intervals, without the "
        f"{refused_splines(own)} splines that were refused. *Bundle*: of all "
        "stages together. *Stage*: of each stage by itself, which knows nothing of "
        "what it was handed on. *Viewer exact*: "
        f"{sure.trials_per_condition} seeds in which the viewer's own calibration has "
        "no error.",
    )


def refused_splines(own):
    """How many seeds of the mirrors that are splines were refused."""
    return sum(text is not None for text in own.select().texts("refused"))


PARTS = {"among": "among the corners", "whole": "all"}


def _row(trials, geometry, mirror, kind, part, prefix, wanted):
    tail = f".{part}" if part else ""
    cells = [coverage(trials, f"{prefix}stage{k}{tail}")[:3] for k in STAGES]
    cells = [Measured(*cell) if np.isfinite(cell[0]) else None for cell in cells]
    return geometry, mirror, kind, PARTS.get(part, "all"), *cells, wanted
