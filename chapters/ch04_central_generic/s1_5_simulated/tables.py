"""All methods of section 4.1.5 at one noise level, and the steps between them."""

from itertools import pairwise

from chapters.ch04_central_generic.s1_5_simulated.results import (
    PRIMARY,
    RUNS,
    STAGES,
    STEP_NAMES,
    centre_after,
    failures,
    gain,
)
from chapters.ch04_central_generic.s1_5_simulated.trials import (
    MANY_GRIDS,
    NOISE_PX,
    OF_MANY_GRIDS,
    STEPS,
)
from chapters.shared.methods import LINEAR_NAMES
from repro.run.columns import columns
from repro.run.experiment import table
from repro.run.outcomes import Measured, Table

SHOWN = {
    "centre_mm": "Centre (mm)",
    "t2_mm": "Translation 2 (mm)",
    "r2_deg": "Rotation 2 (deg)",
    "ray_mm": "Ray to true point (mm)",
    "point_mm": "Moved points (mm)",
}


@table("ext_fig_4_2_methods", needs=("fig_4_2_redrawn",), evidence="synthetic")
def ext_fig_4_2_methods(results):
    """Medians at 0.5 px of every method, linear and adjusted."""
    result = results["fig_4_2_redrawn"]
    rows = [
        (
            LINEAR_NAMES[method] + STAGES[stage],
            *(
                Measured.median(
                    PRIMARY.trials(result, method, stage, quantity, NOISE_PX)
                )
                for quantity in SHOWN
            ),
            failures(result, method)[0],
        )
        for method, stage in RUNS
    ]
    return Table(
        columns(("Method", *SHOWN.values(), "Failed trials"), rows),
        "Errors of all methods at 0.5 px noise: medians over trials with 95 % "
        "intervals. *Translation*: here the length of the difference. *Moved "
        "points*: mean displacement of the points of grids 2 and 3 by the pose "
        "errors. *Failed trials*: number at all noise levels; they count as the "
        "worst.",
    )


@table(
    "ext_cgsp_steps_table",
    needs=("ext_cgsp_steps", "ext_cgsp_grids"),
    evidence="synthetic",
)
def cgsp_steps(results):
    """Median error of the centre after every change, with three grids and with ten."""
    three, many = results["ext_cgsp_steps"], results["ext_cgsp_grids"]
    gains = [gain(three, *pair) for pair in pairwise(STEPS)]
    with_many = [
        Measured(*centre_after(many, step)[:3]) if step in OF_MANY_GRIDS else None
        for step in STEPS
    ]
    return Table(
        {
            "Step": [STEP_NAMES[step] for step in STEPS],
            "Centre, three grids (mm)": [
                Measured(*centre_after(three, step)[:3]) for step in STEPS
            ],
            "Reduction factor": [None, *(Measured(*ratio[:3]) for ratio in gains)],
            "Failed trials": [failures(three, step)[0] for step in STEPS],
            f"Centre, {MANY_GRIDS} grids (mm)": with_many,
        },
        f"Error of the centre at {NOISE_PX} px noise after successive changes of the "
        "standard linear stage: medians over "
        f"{three.trials_per_condition} trials with 95 % intervals, and the factor of "
        "each step. The printed equations require three grids. Failed trials "
        "count as the worst.",
    )
