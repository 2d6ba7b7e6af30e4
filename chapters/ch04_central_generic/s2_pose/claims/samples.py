"""The claims about samples of three and four points, as the ledger words them."""

import numpy as np

from chapters.ch04_central_generic.s2_pose.results import (
    TABLE_MEASURES,
    finite_of_four,
    without_solution,
)
from repro.judge.statistics import all_of, median_ratio, proportion
from repro.run.experiment import claim
from repro.run.outcomes import Reading

FOUR_PLANES = {"that of (4.24)": "of_4_24", "one that all rays meet": "facing"}
SENSITIVE = 3.0
OFTEN = 0.05


@claim("c4_3pt_sensitive", needs=("exp_c4_3pt_sensitive",), evidence="synthetic")
def judge_sensitive(results):
    """Errors of close triplets at least three times those of far ones."""
    result = results["exp_c4_3pt_sensitive"]
    turn, shift = found = [
        median_ratio(
            result.column(f"close together.{measure}"),
            result.column(f"far apart.{measure}"),
            paired=True,
        )
        for measure in TABLE_MEASURES
    ]
    return Reading.of(
        all_of([r.above(np.nextafter(SENSITIVE, 0)) for r in found]),
        min(found, key=lambda r: r.value),
        "x",
        "close over far, the smaller ratio of rotation "
        f"({turn.value:.3g}) and translation ({shift.value:.3g})",
    )


@claim(
    "c4_3pt_no_solution",
    needs=("exp_c4_3pt_no_solution",),
    evidence="synthetic",
    readings=("triplets",),
)
def judge_no_solution(results, options):
    """More than 5 % of noisy triplets without an admissible root."""
    counts = results["exp_c4_3pt_no_solution"]
    lost, total = without_solution(counts, options["triplets"])
    share = proportion(np.arange(total) < lost)
    return Reading.of(
        share.above(OFTEN),
        share.times(100),
        "%",
        f"{lost} of {total} triplets have no real solution ahead of the camera",
    )


@claim(
    "c4_linear_always",
    needs=("exp_c4_linear_always",),
    evidence="synthetic",
    readings=("four_plane",),
)
def judge_linear_always(results, options):
    """A finite pose from every sample of four noisy points."""
    plane = FOUR_PLANES[options["four_plane"]]
    finite, total = finite_of_four(results["exp_c4_linear_always"], plane)
    return Reading.of(
        finite == total,
        100 * finite / total,
        "%",
        f"{finite} of {total} samples of four points, the fewest that give a pose",
    )
