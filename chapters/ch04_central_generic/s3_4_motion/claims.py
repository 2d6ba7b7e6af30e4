"""The claims about Fig. 4.10, tested as the registry words them, and its settings."""

from chapters.ch04_central_generic.s3_4_motion.results import (
    MIN_GAIN,
    READINGS,
    SCALE,
    ahead_at,
)
from chapters.shared.noise_sweep import over_the_sweep
from repro.run.experiment import claim, numbers
from repro.run.outcomes import Reading, Value
from repro.run.readings import Case

QUESTIONS = ("decoding_noise", "standard_method", "motion_corners")
SEEDS = ("fig_4_10_seeds",)


def _judged(results, options, motion, what):
    """wins(CGSP < standard) in one motion's measure."""
    result = results["fig_4_10_seeds"]

    def reading_at(noise):
        found = ahead_at(result, options, motion, noise)
        return Reading.of(
            found.decision,
            found.ratio,
            "x",
            f"{what}, standard over CGSP; p = {found.p:.1g} over "
            f"{result.trials_per_condition} seeds",
        )

    def ahead(noise):
        return ahead_at(result, options, motion, noise).ratio.value >= MIN_GAIN

    return over_the_sweep(Case(READINGS, options), reading_at, ahead)


@claim("c4_motion_trans", needs=SEEDS, evidence="rendered", readings=QUESTIONS)
def judge_translation(results, options):
    """The deviation from the mean step is smaller with CGSP."""
    return _judged(results, options, "translation", "RMS deviation from the mean step")


@claim("c4_motion_rot", needs=SEEDS, evidence="rendered", readings=QUESTIONS)
def judge_rotation(results, options):
    """The total rotation is nearer to 110 degrees with CGSP."""
    what = "difference of the total rotation from 110 degrees"
    return _judged(results, options, "rotation", what)


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
