"""Which order white residuals choose, and whether it is the best one for the rays."""

import numpy as np

from chapters.ch05_flexible_mirror.ext_orders.results.orders import (
    ORDERS,
    WORDS,
    courses,
    published_of,
)
from repro.run.columns import columns
from repro.run.experiment import table
from repro.run.outcomes import Measured, Table

STAGE_WORDS = {"primary": "primary", "stage": "5 mm step"}


@table("ext_orders_table", needs=("ext_orders_runs",), evidence="rendered")
def orders_table(results):
    """Chosen order and rays, beside the best of the course and the published order."""
    rows = []
    for case, words in WORDS.items():
        for stage, name in STAGE_WORDS.items():
            found = courses(results, case, stage)
            white = sum(one.white >= 0 for one in found)
            shapes = {
                f"{one.chosen('functions_u'):.0f} x {one.chosen('functions_v'):.0f}"
                f", degree {one.chosen('degree'):.0f}"
                for one in found
            }
            rows.append(
                (
                    words, name, f"{white} of {len(found)}",
                    "; ".join(sorted(shapes)),
                    _cell([one.chosen("angle_deg") for one in found]),
                    _cell([one.least("angle_deg") for one in found]),
                    _cell([one.with_least("kept_mm", "angle_deg") for one in found]),
                    _cell(published_of(found, "angle_deg")),
                )
            )  # fmt: skip
    names = ("Mirror and errors", "Stage", "White", "Order taken", "Rays, taken (deg)",
             "Rays, best order (deg)", "Rays, least kept-out error (deg)",
             "Rays, 7 x 3 quadratic (deg)")  # fmt: skip
    return Table(
        columns(names, rows),
        "The order that is taken: the first whose residuals are white, or else the "
        "last that features support and the run tried. Beside its rays those of the "
        "best order of the same course, which only the truth knows, of the order "
        "with the least kept-out error, and of the published one. Medians over "
        f"{results[ORDERS].trials_per_condition} seeds with their range.",
    )


def _cell(values):
    return Measured.of_seeds(np.array(values)) if len(values) else None
