"""The claims about Fig. 4.4, tested as the ledger words them, and its numbers."""

from __future__ import annotations

import numpy as np

from chapters.ch04_central_generic.s2_pose.results import (
    IN_WORDS,
    MEASURES,
    TABLE_MEASURES,
    levels_of,
    ratio,
    ratio_reading,
    readings_of_noise,
    trials_of,
)
from chapters.ch04_central_generic.s2_pose.trials.estimators import STANDARD
from chapters.ch04_central_generic.s2_pose.trials.simulated import SIZES
from repro.judge.statistics import all_of, wins
from repro.run.experiment import claim, numbers
from repro.run.outcomes import Value

NEUTRAL = (0.95, 1.25)


def domain_of(reading):
    """The condition of the simulation that a reading asks for."""
    return {
        "domain": reading["noise"],
        "rays": reading["pose_rays"],
        "unit": reading["pose_threshold"],
    }


@claim("c4_pose_cgsp_better", needs=("fig_4_4_noise",), evidence="synthetic")
def judge_cgsp_better(results):
    """wins(CGSP + RANSAC < standard + RANSAC) in both, at every level."""
    result, out = results["fig_4_4_noise"], []
    for reading in readings_of_noise():
        standard = STANDARD[reading["standard_pose"]]
        found = {}
        for measure in MEASURES:
            found[measure] = wins(
                [
                    tuple(
                        trials_of(result, name, measure, level, **domain_of(reading))
                        for name in ("cgsp_ransac", standard)
                    )
                    for level in levels_of(result)
                ]
            )
        every = [c for comparisons in found.values() for c in comparisons]
        least = min(every, key=lambda c: c.ratio.value)
        won = {
            IN_WORDS[measure]: sum(c.decision == "holds" for c in comparisons)
            for measure, comparisons in found.items()
        }
        told = ", ".join(
            f"{name} at {count} of {len(levels_of(result))}"
            for name, count in won.items()
        )
        out.append(
            ratio_reading(
                all_of([c.decision for c in every]),
                least.ratio,
                "standard over CGSP, the smallest ratio of all levels; CGSP "
                f"wins in {told} levels",
                reading,
            )
        )
    return out


@claim("c4_pose_ransac_neutral", needs=("fig_4_4_noise",), evidence="synthetic")
def judge_ransac_neutral(results):
    """With over without RANSAC within 0.95 and 1.25 at every level."""
    result, out = results["fig_4_4_noise"], []
    for reading in readings_of_noise(with_standard=False):
        found = [
            ratio(
                *(
                    trials_of(result, name, measure, level, **domain_of(reading))
                    for name in ("cgsp_ransac", "cgsp")
                )
            )
            for measure in MEASURES
            for level in levels_of(result)
        ]
        farthest = max(found, key=lambda r: abs(np.log(r.value)))
        out.append(
            ratio_reading(
                all_of([r.within(*NEUTRAL) for r in found]),
                farthest,
                "with over without RANSAC, the ratio farthest from 1 of all "
                "levels, rotation and translation",
                reading,
            )
        )
    return out


@claim("c4_real_larger", needs=("exp_c4_real_larger",), evidence="synthetic")
def judge_real_larger(results):
    """wins(error as simulated < half the grid at twice the distance)."""
    result = results["exp_c4_real_larger"]
    found = [
        wins([tuple(result.column(f"{size}.{name}.{measure}") for size in SIZES)])[0]
        for name in ("standard", "cgsp_ransac")
        for measure in TABLE_MEASURES
    ]
    least = min(found, key=lambda c: c.ratio.value)
    return [
        ratio_reading(
            all_of([c.decision for c in found]),
            least.ratio,
            "halved and doubled over usual, the smallest ratio of rotation "
            "and translation by both methods within RANSAC",
        )
    ]


@numbers("fig_4_4", needs=("fig_4_4_noise",), evidence="synthetic")
def numbers_fig_4_4(results):
    """The settings that the text states, as they were run."""
    result = results["fig_4_4_noise"]
    low, high = result.settings["shift_mm"]
    least, most = result.settings["euler_deg"]
    return {
        "fig4_4_cz": Value(result.settings["centre_mm"][2], unit="mm"),
        "fig4_4_tmin": Value(low, unit="mm"),
        "fig4_4_tmax": Value(high, unit="mm"),
        "fig4_4_rmin": Value(least, unit="deg"),
        "fig4_4_rmax": Value(most, unit="deg"),
        "fig4_4_trials": Value(result.trials_per_condition, unit="count"),
    }
