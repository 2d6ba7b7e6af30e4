"""What the steps of the loop have to see, and what the board's known metric holds."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_repeatability.results import causes
from chapters.ch05_flexible_mirror.s3_3_repeatability.results.runs import STEPS
from chapters.ch05_flexible_mirror.s3_3_repeatability.trials.run import LOOP, OUT
from chapters.shared.mirror_bench import BENCHES
from repro.judge.statistics import median_interval
from repro.page.style import INK, plot_estimates, series
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

SEEN = {
    "covered": "Mirror covered by corners (1)",
    "reciprocal": "Reciprocal condition (1)",
}
ARM_WORDS = {"metric": "metric imposed", "without": "corners on their own rays"}


@figure(
    "ext_step_causes",
    needs=("exp_c5_concave_conditioning", "exp_c5_metric_fit_helps"),
    evidence="rendered",
)
def ext_step_causes(results):
    """Covered share, condition number and back-projection error, step by step."""
    drawn, axes = new_figure(1, 3, height_in=3.6)
    rows = []
    for panel, (name, label) in zip(axes, SEEN.items(), strict=False):
        for number, bench in enumerate(reversed(BENCHES)):
            found = [
                median_interval(_known(one))
                for one in causes.of_steps(results, bench, name)
            ]
            rows += plot_estimates(
                panel, np.add(STEPS, 0.12 * number - 0.06), found, (label, bench),
                look=series(number), label=bench, bars=True,
            )  # fmt: skip
        panel.set_ylabel(label)
        panel.axvline(OUT + 0.5, color=INK, ls=":", marker="")
    for number, (arm, words) in enumerate(ARM_WORDS.items()):
        errors = causes.errors_of(results[causes.METRIC], arm)
        steps = [k for k, one in zip(STEPS, errors, strict=True) if len(_known(one))]
        found = [median_interval(_known(errors[k - 1])) for k in steps]
        rows += plot_estimates(
            axes[2], np.add(steps, 0.12 * number - 0.06), found, ("back_mm", words),
            look=series(number + 2), label=words, bars=True,
        )  # fmt: skip
    axes[2].set_ylabel("Back-projection, own pose (mm)")
    axes[0].set_ylim(0, 1)
    axes[1].set_ylim(0, None)
    axes[2].set_ylim(0, None)
    for panel in axes:
        panel.set_xticks(STEPS, [f"{k}\n{LOOP[k]}" for k in STEPS])
        panel.set_xlabel("Step, and its end (1)")
    axes[0].legend(loc="lower right", fontsize=8)
    axes[2].legend(loc="upper left", fontsize=8)
    return Drawing(
        drawn,
        columns(("measure", "series", "step", "median", "low", "high"), rows),
        "Left and middle: how much of the mirror the common corners span after a step, "
        "and how well the data matrix of the linear stage is conditioned; steps out, "
        "and right of the dotted line steps back. Right: the loop on the bench with "
        "the board's known metric, and with each corner left where the camera's own "
        "ray meets the board's plane. Medians with 95 % intervals of the seeds that "
        "got so far, which without the metric are few in the end.",
    )


def _known(values):
    return values[np.isfinite(values)]
