"""Results of this page read: values of the prose, figures, tables."""

import numpy as np

from chapters.ch04_central_generic.ext_lens_formula.experiment import (
    LENSES,
    MODELS,
    RINGS,
)
from repro.page import legend_below, look_of, new_figure, value
from repro.run import Drawing, Measured, Table, columns, figure, median_interval, table

# Names, medians over trials, and the numbers that the page quotes.


NAMES = {
    "zhang": "pinhole, two radial terms",
    "kannala-brandt": "Kannala-Brandt",
    "unified": "unified sphere",
    "pupil": "Kannala-Brandt, pupil by test",
}
TITLES = {
    "fisheye": "fisheye of 183°",
    "mirror": "mirror, decentred",
    "pupil": "fisheye, moving pupil",
}


def error(result, lens, model):
    """Return the median held-out error (px) over trials, an Estimate."""
    return median_interval(result.column(model, "rms_px", lens=lens))


def ring_errors(result, lens, model):
    """Return the median errors (px) in rings about the image centre; NaN if empty."""
    rings = np.array(result.arrays(model, "ring_px", lens=lens))
    if not len(rings):
        return None
    known = np.isfinite(rings).any(axis=0)
    return np.where(known, np.nanmedian(np.where(known, rings, 0.0), axis=0), np.nan)


def name_values(open_results):
    """Name the numbers of the prose."""
    result = open_results("ext_lens_known")
    value("trials", result.trials_per_condition)
    for lens, model in (
        ("fisheye", "kannala-brandt"),
        ("mirror", "unified"),
        ("mirror", "kannala-brandt"),
        ("pupil", "kannala-brandt"),
        ("pupil", "pupil"),
    ):
        value(f"{lens}.{model}", error(result, lens, model).value)


# Errors against the distance from the image centre, for every model.


@figure("ext_lens_formula_figure", needs=("ext_lens_known",), evidence="synthetic")
def lens_formula(results):
    """Three known lenses: RMS error in rings, every model."""
    drawn, axes = new_figure(1, len(LENSES), height_in=3.4, sharey=True)
    rows = []
    middle = (RINGS[1:] + RINGS[:-1]) / 2
    for panel, lens in zip(axes, LENSES, strict=True):
        for model in MODELS:
            rms = ring_errors(results["ext_lens_known"], lens, model)
            if rms is None:
                continue
            label = NAMES[model]
            panel.plot(middle, rms, label=label, **(look_of(label) | {"ms": 3}))
            rows += [(lens, model, *at) for at in zip(middle, rms, strict=True)]
        panel.set(yscale="log", title=TITLES[lens])
        panel.set_xlabel("Distance from the image centre (px)")
    axes[0].set(ylabel="RMS error, held out (px)", ylim=(None, 3e3))
    legend_below(drawn, axes[0], ncols=2)
    return Drawing(
        drawn,
        columns(("camera", "model", "radius_px", "rms_px"), rows),
        "Errors on held-out boards against the distance from the image centre, for "
        "three known lenses and four models. The fit uses 12 boards with 0.1 px "
        "noise. The held-out corners are exact. Medians over trials.",
    )


# Known lenses and models: held-out errors, and results of the pupil test.


@table("ext_lens_formula_table", needs=("ext_lens_known",), evidence="synthetic")
def lens_formula_table(results):
    """Median errors of every model on every known lens."""
    result = results["ext_lens_known"]
    tests = [
        result.column("pupil.test", ("moves", "shift_mm"), lens=lens) for lens in LENSES
    ]
    errors = {
        f"{NAMES[model]} (px)": [
            Measured(*error(result, lens, model)[:3]) for lens in LENSES
        ]
        for model in MODELS
    }
    return Table(
        {
            "Lens": [TITLES[lens] for lens in LENSES],
            **errors,
            "Pupil shift found (trials)": [int(np.nansum(moves)) for moves, _ in tests],
            "Trials": [result.trials_per_condition for _ in LENSES],
            "Pupil shift (mm)": [Measured.median(shift) for _, shift in tests],
        },
        "RMS error on exact held-out boards, medians over trials with 95 % "
        "intervals. The fitted corners have 0.1 px noise. The pupil shift is "
        "that from the axis to the largest angle in the data, 0 where the test "
        "finds none.",
    )
