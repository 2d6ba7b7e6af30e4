"""Table 2.1, printed from the evaluated formulas."""

from chapters.ch02_general_camera_model.s4_generic_calibration.trials import (
    AS_PRINTED,
    TABLE_2_1,
    VECTORS,
    as_maths,
    formula,
)
from repro.run.experiment import table
from repro.run.outcomes import Check, Table


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
    zero = [ran.column(f"corrected.{vector}.zero").all() for vector in VECTORS]
    return Table(
        columns,
        "Entries of the four coefficient vectors of equations 2.14, with row 3 "
        "corrected (bold). Superscripts name the grid; grid 1 is the base grid.",
        Check(
            all(zero),
            "all four sums are exactly zero in every scene, in rational arithmetic",
        ),
    )
