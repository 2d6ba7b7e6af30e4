"""Conditions and trials of the experiments that a class can repeat."""

from repro.run.experiment import table
from repro.run.outcomes import Table


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
