"""Known lenses and models: held-out errors, and results of the pupil test."""

from chapters.ch04_central_generic.ext_lens_formula.results import (
    NAMES,
    TITLES,
    error,
    moved,
    shift,
)
from chapters.ch04_central_generic.ext_lens_formula.trials import LENSES, MODELS
from repro.run.experiment import table
from repro.run.outcomes import Measured, Table


@table("ext_lens_formula_table", needs=("ext_lens_known",), evidence="synthetic")
def lens_formula_table(results):
    """Median errors of every model on every known lens."""
    result = results["ext_lens_known"]
    return Table(
        {
            "Lens": [TITLES[lens] for lens in LENSES],
            **{
                f"{NAMES[model]} (px)": [
                    _measured(error(result, lens, model)) for lens in LENSES
                ]
                for model in MODELS
            },
            "Pupil shift found (trials)": [moved(result, lens) for lens in LENSES],
            "Trials": [result.trials_per_condition for _ in LENSES],
            "Pupil shift (mm)": [_measured(shift(result, lens)) for lens in LENSES],
        },
        "RMS error on exact held-out boards, medians over trials with 95 % "
        "intervals. The fitted corners have 0.1 px noise. The pupil shift is "
        "that from the axis to the largest angle in the data, 0 where the test "
        "finds none.",
    )


def _measured(found):
    return Measured(*found[:3])
