"""Table 4.1, from rendered images and redrawn scenes."""

from itertools import product

import numpy as np

from chapters.ch04_central_generic.s2_pose.results import TABLE_MEASURES, table_trials
from chapters.ch04_central_generic.s2_pose.trials.estimators import ESTIMATORS, NAMES
from chapters.ch04_central_generic.s2_pose.trials.kodak import (
    ADDED_OUTLIERS,
    OUTLIERS,
    TABULATED,
)
from repro.run.columns import columns
from repro.run.experiment import table
from repro.run.outcomes import Measured, Table

PRINTED = ("standard", "cgsp", "cgsp_ransac")
BOTH = ("table_4_1_rendered", "table_4_1_redrawn")
LEVELS = {"bench": "thesis-matched", "laboratory": "low-noise"}


@table("table_4_1", needs=("table_4_1_rendered",), evidence="rendered")
def table_4_1(results):
    """Tabulate pose errors of the three estimators, from rendered images."""
    result = results["table_4_1_rendered"]
    units = ("Rotation error (°)", "Translation error (mm)")
    rows = [
        (unit, *(float(np.median(table_trials(result, e, measure))) for e in PRINTED))
        for unit, measure in zip(units, TABLE_MEASURES, strict=True)
    ]
    estimators = ("Standard + RANSAC", "CGSP", "CGSP + RANSAC")
    printed = {
        head: [f"t4_1_{short}_rot", f"t4_1_{short}_trans"]
        for head, short in zip(
            estimators, ("std_ransac", "cgsp", "cgsp_ransac"), strict=True
        )
    }
    return Table(
        columns(("Error", *estimators), rows),
        "Errors of the relative pose of two active grids, decoded from rendered images "
        f"at the thesis-matched level, with {ADDED_OUTLIERS} of outliers added: "
        f"medians over {len(result.conditions)} runs, against a laser scan. The "
        "standard pose is refined on its inliers.",
        printed=printed,
    )


@table("ext_table_4_1", needs=BOTH, evidence="rendered")
def all_of_table_4_1(results):
    """Tabulate every estimator, with and without outliers, rendered and redrawn."""
    rendered, redrawn = (results[name] for name in BOTH)
    rows = []
    for noise, outliers, name in product(TABULATED, OUTLIERS, ESTIMATORS):
        cells = []
        for measure in TABLE_MEASURES:
            of_seeds, of_scenes = (
                table_trials(result, name, measure, outliers, noise)
                for result in (rendered, redrawn)
            )
            cells += [float(np.median(of_seeds)), Measured.median_or_none(of_scenes)]
        rows.append((LEVELS[noise], outliers, NAMES[name], *cells))
    return Table(
        columns(
            (
                "Noise level",
                "Outliers",
                "Estimator",
                "Rotation, rendered (°)",
                "Rotation, redrawn (°)",
                "Translation, rendered (mm)",
                "Translation, redrawn (mm)",
            ),
            rows,
        ),
        "Errors of the relative pose of two active grids, by estimator: medians over "
        f"{len(rendered.conditions)} rendered runs, and over "
        f"{redrawn.trials_per_condition} redrawn scenes with 95 % intervals, at both "
        "noise levels.",
    )
