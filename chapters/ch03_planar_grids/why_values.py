"""Numbers that the page on CELECT's failures quotes."""

from __future__ import annotations

import numpy as np

from chapters.ch03_planar_grids.failure_stages import DONE
from chapters.ch03_planar_grids.why_cases import CASES
from chapters.ch03_planar_grids.why_figures import stages_of
from chapters.ch03_planar_grids.why_tables import first_failure
from repro.reader import value

# What the prose calls the drawn levels, in their order.
DRAWN = {
    2: ("broken", "kept"),
    3: ("broken", "kept", "other"),
}
FORETOLD = ("first_corner", "wrong_contour", "direction")


def name_values(open_results):
    """Name every quoted number, from the results of this effort."""
    results = {case: open_results(f"ext_why_{case}") for case in CASES}
    for case, result in results.items():
        drawn = CASES[case]["drawn"].values()
        for name, level in zip(DRAWN[len(drawn)], drawn, strict=True):
            lost = stages_of(result)[level]
            value(f"{case}_{name}", f"{lost.count(DONE)} of {len(lost)}")
    agree = np.concatenate([foretold(results[case]) for case in FORETOLD])
    value("foretold", f"{int(agree.sum())} of {len(agree)}")
    orderings = open_results("ext_why_orderings")
    for ordering in ("line", "homography"):
        for family in ("arc", "fov"):
            value(
                f"{ordering}_{family}",
                first_failure(orderings, ordering, family),
            )
    value("line_criterion", agreeing_criterion(orderings))


def foretold(result):
    """Whether each run was lost on side 1 exactly where 3.1.2 says so: (n,) bool."""
    agree = []
    for level in result.conditions[0]["levels"]:
        wrong = result.column(f"{level}.first_line_wrong") == 1
        lost = [
            contour == "side 1"
            for contour in result.texts(f"{level}.contour")
        ]
        agree.append(wrong == np.array(lost))
    return np.concatenate(agree)


def agreeing_criterion(result):
    """Share of trials in which the margin's sign tells the first ordering's outcome."""
    agree = [
        (result.column("margin", **condition) > 0)
        == (result.column("line", **condition) == 1)
        for condition in result.conditions
    ]
    return f"{100 * np.concatenate(agree).mean():.0f} %"
