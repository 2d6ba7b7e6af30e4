"""The claims about Fig. 4.10, tested as the ledger words them, and its settings."""

from __future__ import annotations

from chapters.ch04_central_generic.s3_4_motion.results import SCALE, STANDARD, trials_of
from chapters.ch04_central_generic.s3_4_motion.trials.corners import DETECTORS
from repro.judge.statistics import wins
from repro.run.experiment import claim, numbers
from repro.run.outcomes import DECISIONS, Reading, Value


def judged(result, motion, measure, what):
    """wins(CGSP < standard) in every reading, the primary one first."""
    out = []
    for method in STANDARD:
        for detector in DETECTORS:
            ours, theirs = (
                trials_of(result, motion, measure, name, detector)
                for name in ("CGSP", method)
            )
            found = wins([(ours, theirs)])[0]
            out.append(
                Reading(
                    DECISIONS[found.decision],
                    found.ratio.value,
                    {"standard_method": method, "motion_corners": detector},
                    (found.ratio.low, found.ratio.high),
                    "x",
                    f"{what}, standard over CGSP; p = {found.p:.1g} over "
                    f"{len(ours)} seeds",
                )
            )
    return out


@claim("c4_motion_trans", needs=("fig_4_10_seeds",), evidence="rendered")
def judge_translation(results):
    """The deviation from the mean step is smaller with CGSP."""
    return judged(
        results["fig_4_10_seeds"],
        "translation",
        "deviation_mm",
        "RMS deviation from the mean step",
    )


@claim("c4_motion_rot", needs=("fig_4_10_seeds",), evidence="rendered")
def judge_rotation(results):
    """The total rotation is nearer to 110 degrees with CGSP."""
    return judged(
        results["fig_4_10_seeds"],
        "rotation",
        "off_deg",
        "difference of the total rotation from 110 degrees",
    )


@numbers("fig_4_10", needs=("fig_4_10_seeds",), evidence="rendered")
def numbers_fig_4_10(results):
    """The settings that the text states, as they were run."""
    settings = results["fig_4_10_seeds"].settings
    steps = settings["steps"]
    return {
        "fig4_10_t": Value(steps["translation"] * settings["step_mm"], unit="mm"),
        "fig4_10_ts": Value(settings["step_mm"], unit="mm"),
        "fig4_10_r": Value(steps["rotation"] * settings["step_deg"], unit="deg"),
        "fig4_10_rs": Value(settings["step_deg"], unit="deg"),
        "fig4_10_scale": Value(SCALE, unit="x"),
    }
