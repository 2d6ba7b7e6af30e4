"""Fig. 4.10: the motion of the stage, reconstructed from rays."""

import numpy as np

from chapters.ch04_central_generic.s3_4_motion.results import (
    METHODS,
    NAMES,
    QUOTED_DETECTOR,
    SCALE,
    trials_of,
)
from chapters.ch04_central_generic.s3_4_motion.trials.stage import (
    STEP_DEG,
    STEP_MM,
    STEPS,
)
from chapters.shared.bench_noise import BENCH
from repro.page.method_looks import look_of
from repro.page.style import INK
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing

EXACT = 1e-9


def drawn_arrays(result, motion, method, name):
    """Return one array of the first rendered run, corners by CELECT."""
    return result.arrays(f"{BENCH}.{motion}.{QUOTED_DETECTOR}.{method}.{name}", seed=0)[
        0
    ]


def path_of(shifts, across):
    """Return positions (steps + 1, 2) after each step, mm: along the mean, lateral.

    Deviations along the mean step are enlarged SCALE times; lateral ones are not.
    """
    mean = shifts.mean(axis=0)
    ahead = mean / np.linalg.norm(mean)
    off = shifts - mean
    steps = np.column_stack([(mean + SCALE * off) @ ahead, off @ across])
    return np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])


def widest(every):
    """Return the unit vector perpendicular to the motion with most deviation."""
    off = np.concatenate([s - s.mean(axis=0) for s in every])
    mean = np.mean([s.mean(axis=0) for s in every], axis=0)
    ahead = mean / np.linalg.norm(mean)
    off = off - np.outer(off @ ahead, ahead)
    return np.linalg.svd(off)[2][0]


@figure("fig_4_10", needs=("fig_4_10_rendered",), evidence="rendered")
def fig_4_10(results):
    """Draw (a) the translation, deviations enlarged; (b) the rotation."""
    result = results["fig_4_10_rendered"]
    drawn, (left, right) = new_figure(1, 2, height_in=3.8)
    shifts = {
        method: drawn_arrays(result, "translation", method, "shifts")
        for method in METHODS
    }
    across = widest(list(shifts.values()))
    rows, gaps = [], []
    stage = STEP_DEG * np.arange(STEPS["rotation"] + 1)
    for method in METHODS:
        path = path_of(shifts[method], across)
        left.plot(*path.T, label=NAMES[method], **look_of(NAMES[method]))
        turned = drawn_arrays(result, "rotation", method, "turned")
        off = np.concatenate([[0.0], turned]) - stage
        right.plot(stage, off, **look_of(NAMES[method]))
        rows += [("a", method, *place) for place in path]
        rows += [("b", method, *pair) for pair in zip(stage, off, strict=True)]
        lateral = shifts[method] - shifts[method].mean(axis=0)
        judged = trials_of(
            result, "translation", "deviation_mm", method, QUOTED_DETECTOR
        )[0]
        gaps.append(abs(np.sqrt(np.mean(np.sum(lateral**2, axis=1))) - judged))
    for panel in (left, right):
        panel.axhline(0, color=INK, lw=0.8)
    left.set(
        xlabel=f"Along the mean step, deviations × {SCALE} (mm)",
        ylabel="Lateral deviation (mm)",
        title="(a)",
    )
    left.set_xticks(STEP_MM * np.arange(STEPS["translation"] + 1))
    right.set(
        xlabel="Rotation of the stage (deg)",
        ylabel="Error of the rotation (deg)",
        title="(b)",
    )
    drawn.legend(loc="outside lower center", ncols=3)
    return Drawing(
        drawn,
        columns(("panel", "method", "x", "y"), rows),
        "Motion of the stage reconstructed from the rays of three calibrations, one "
        "rendered run at the thesis-matched level, corners by CELECT: (a) translation "
        f"in steps of {STEP_MM:g} mm, lateral position against position along the mean "
        f"step, where deviations are enlarged {SCALE} times; (b) error of the "
        "accumulated rotation after each step of 10°.",
        Check(
            bool(max(gaps) < EXACT),
            "the drawn steps have the deviations that the claims judge, to "
            f"{max(gaps):.0e} mm",
        ),
    )
