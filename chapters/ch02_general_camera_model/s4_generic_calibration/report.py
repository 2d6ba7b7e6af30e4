"""Results of this page read: values of the prose, figures, tables, judgements."""

import numpy as np

from chapters.ch02_general_camera_model.s4_generic_calibration.experiment import (
    AS_PRINTED,
    TABLE_2_1,
    VECTORS,
    as_maths,
    formula,
)
from repro.run import Check, Reading, Table, claim, table

# Error of the printed Table 2.1, from the result of section 2.4.


def summary_of(result, vector):
    """Return the median over scenes of the largest relative sum, as printed."""
    return float(np.median(result.column("printed", vector, "relative")))


# Table 2.1, printed from the evaluated formulas.


def cell_text(row, vector):
    """Return a cell as LaTeX, bold where it corrects the printed table."""
    text = as_maths(formula(row, vector))
    if (row, vector) in AS_PRINTED:
        return rf"$\boldsymbol{{{text.strip('$')}}}$"
    return text


@table("table_2_1", needs=("table_2_1_sums",), evidence="analytic")
def table_2_1(results):
    """Tabulate Table 2.1 in symbols and check that every sum vanishes."""
    ran = results["table_2_1_sums"]
    columns = {"i": [str(n) for n in range(1, 10)]}
    columns["j"] = [row[0] for row in TABLE_2_1]
    columns["k"] = [row[1] for row in TABLE_2_1]
    for vector in VECTORS:
        columns[f"${vector}_i$"] = [cell_text(row, vector) for row in range(9)]
    return Table(
        columns,
        "Entries of the four coefficient vectors of equations 2.14, with row 3 "
        "corrected (bold). Superscripts name the grid; grid 1 is the base grid.",
        Check(
            bool(ran.column("corrected", VECTORS, "zero").all()),
            "all four sums are exactly zero in every scene, in rational arithmetic",
        ),
    )


# The claim about Table 2.1, tested as the registry words it.


@claim("c2_table_coefficients", needs=("table_2_1_sums",), evidence="analytic")
def judge_table_coefficients(results):
    """Relative residual below 1e-12 corrected, above 1e-3 as printed."""
    ran = results["table_2_1_sums"]
    corrected = ran.column("corrected", VECTORS, "relative").max()
    exact = ran.column("corrected", VECTORS, "zero").all()
    trials = ran.column("printed", ("W", "N"), "relative")
    printed = np.median(trials, axis=1)
    return Reading.of(
        exact and corrected < 1e-12 and printed.min() > 1e-3,
        f"{corrected:.1g} corrected; {printed[0]:.2g} (W), "
        f"{printed[1]:.2g} (N) as printed",
        reason="row 3 of W and N carries a superscript one too low as "
        "printed (E-2.08); largest residual of all scenes corrected, "
        "medians over scenes as printed, where "
        f"{np.count_nonzero(trials <= 1e-3)} of {trials.size} are at most 1e-3",
    )
