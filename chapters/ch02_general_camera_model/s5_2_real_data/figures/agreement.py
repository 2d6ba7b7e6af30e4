"""Real and simulated data compared: the error against the distortion."""

from __future__ import annotations

from functools import cache
from itertools import product

import numpy as np

from chapters.ch02_general_camera_model.s5_2_real_data.claims import (
    RESIDUAL,
    rendered_slopes,
)
from chapters.shared.synthetic_readings import (
    QUESTIONS as OF_SWEEP,
)
from chapters.shared.synthetic_readings import SweepCase, readings_of
from chapters.shared.three_planes import FOVS_DEG
from chapters.shared.zoom_readings import (
    QUESTIONS as OF_SETS,
)
from chapters.shared.zoom_readings import ZoomCase
from repro.judge.statistics import all_of, trend
from repro.run.experiment import claim

ASKED = OF_SWEEP | {question: OF_SETS[question] for question in RESIDUAL}


def distortion_level(angle_deg: float) -> float:
    """|r_distorted / r_pinhole - 1| of the equidistance law at an angle.

    It rises with the angle from the axis: the widest one has the largest.
    """
    angle = np.radians(angle_deg)
    return float(1 - angle / np.tan(angle))


def _log_slope(x: np.ndarray, medians: np.ndarray) -> float:
    return float(np.polyfit(x, np.log(medians), 1)[0])


def _depends(parametric, generic) -> str:
    """Parametric slope above zero, generic within a fifth of it."""
    bound = abs(parametric.value) / 5
    return all_of([parametric.above(0.0), generic.within(-bound, bound)])


def _as_text(parametric, generic) -> str:
    """Both slopes with their intervals, and what they decide."""
    slopes = ", ".join(
        f"{name} {s.value:.2f} ({s.low:.2f} to {s.high:.2f})"
        for name, s in (("parametric", parametric), ("generic", generic))
    )
    return f"{slopes}: {_depends(parametric, generic)}"


def swept_slopes(case):
    """Slopes of both methods over the simulated sweep, with intervals."""
    widest = [case.column("widest_angle_deg", fov_deg=f) for f in FOVS_DEG]
    levels = np.array([distortion_level(np.median(w)) for w in widest])
    return [
        trend(
            levels,
            [one("mean_px", fov_deg=f) for f in FOVS_DEG],
            _log_slope,
        )
        for one in (case.parametric, case.generic)
    ]


def every_case(result):
    """One case per combination of options, of the sweep and of the sets."""
    for options in product(*ASKED.values()):
        yield SweepCase(result, dict(zip(ASKED, options, strict=True)))


def _taken(case, questions):
    return tuple(
        (question, case.options[question]) for question in questions
    )


@claim(
    "c2_real_vs_sim_agree",
    needs=("fig_2_3_fov", "table_2_2_redrawn"),
    evidence="rendered",
)
def judge_depends_on_distortion(results):
    """Parametric error depends on distortion, generic a fifth at most.

    In the simulated sweep and in the three rendered sets: both must agree.
    """
    fov, sets = results["fig_2_3_fov"], results["table_2_2_redrawn"]

    @cache
    def of_sweep(options):
        return swept_slopes(SweepCase(fov, dict(options)))

    @cache
    def of_sets(options):
        return rendered_slopes(ZoomCase(sets, dict(options)))

    def judge(case):
        halves = (
            of_sweep(_taken(case, OF_SWEEP)),
            of_sets(_taken(case, RESIDUAL)),
        )
        _, generic = halves[0]
        return (
            all_of([_depends(*half) for half in halves]),
            generic.value,
            (generic.low, generic.high),
            "generic slope of log residual in the sweep; "
            + "; ".join(
                f"{name}: {_as_text(*half)}"
                for name, half in zip(
                    ("sweep", "three sets"), halves, strict=True
                )
            ),
        )

    return readings_of(every_case(fov), judge)
