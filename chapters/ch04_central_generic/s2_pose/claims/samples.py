"""The claims about samples of three and four points, as the ledger words them."""

from __future__ import annotations

import numpy as np

from chapters.ch04_central_generic.s2_pose.results import (
    TABLE_MEASURES,
    finite_of_four,
    ratio,
    ratio_reading,
    without_solution,
)
from chapters.ch04_central_generic.s2_pose.trials.triplets import APART
from repro.judge.statistics import all_of, proportion
from repro.run.experiment import claim
from repro.run.outcomes import DECISIONS, Reading

FOUR_PLANES = {"that of (4.24)": "of_4_24", "one that all rays meet": "facing"}
SENSITIVE = 3.0
OFTEN = 0.05


@claim("c4_3pt_sensitive", needs=("exp_c4_3pt_sensitive",), evidence="synthetic")
def judge_sensitive(results):
    """Errors of close triplets at least three times those of far ones."""
    result = results["exp_c4_3pt_sensitive"]
    found = [
        ratio(
            *(
                result.column(f"{kind}.{measure}")
                for kind in ("close together", "far apart")
            )
        )
        for measure in TABLE_MEASURES
    ]
    return [
        ratio_reading(
            all_of([r.above(np.nextafter(SENSITIVE, 0)) for r in found]),
            min(found, key=lambda r: r.value),
            "close over far, the smaller ratio of rotation "
            f"({found[0].value:.3g}) and translation ({found[1].value:.3g})",
        )
    ]


@claim("c4_3pt_no_solution", needs=("exp_c4_3pt_no_solution",), evidence="synthetic")
def judge_no_solution(results):
    """More than 5 % of noisy triplets without an admissible root."""
    out = []
    for kind in APART:
        lost, total = without_solution(results["exp_c4_3pt_no_solution"], kind)
        share = proportion(np.arange(total) < lost)
        out.append(
            Reading(
                DECISIONS[share.above(OFTEN)],
                100 * share.value,
                {"triplets": kind},
                (100 * share.low, 100 * share.high),
                "%",
                f"{lost} of {total} triplets have no real solution ahead of the camera",
            )
        )
    return out


@claim("c4_linear_always", needs=("exp_c4_linear_always",), evidence="synthetic")
def judge_linear_always(results):
    """A finite pose from every sample of four noisy points."""
    out = []
    for option, plane in FOUR_PLANES.items():
        finite, total = finite_of_four(results["exp_c4_linear_always"], plane)
        out.append(
            Reading(
                DECISIONS["holds" if finite == total else "fails"],
                100 * finite / total,
                {"four_plane": option},
                unit="%",
                reason=f"{finite} of {total} samples of four points, the "
                "fewest that give a pose",
            )
        )
    return out
