"""Results of this page read: values of the prose, figures, tables."""

import re

from repro.page import checkout
from repro.run import Table, table

# Times of the commands, from the README.


ROW = re.compile(r"^\| `make (\w+)` \| (\d+ (?:min|s)) \|$", re.MULTILINE)


def stated_times():
    """Return command -> its time as text, from the table of the README."""
    return dict(ROW.findall((checkout() / "README.md").read_text("utf-8")))


# Conditions and trials of the experiments that a class can repeat.


@table(
    "ext_class_runs",
    needs=(
        "fig_2_2_error",
        "fig_2_3_noise",
        "fig_2_3_fov",
        "fig_2_3_laws",
        "fig_3_11_noise",
        "fig_3_11_blur",
    ),
    evidence="synthetic",
)
def ext_class_runs(results):
    """Tabulate conditions and trials of the experiments of the lessons."""
    return Table(
        {
            "Experiment": list(results),
            "Conditions": [len(r.conditions) for r in results.values()],
            "Trials each": [r.trials_per_condition for r in results.values()],
        },
        "Conditions and trials of the experiments of Figs. 2.2, 2.3 and 3.11.",
    )
