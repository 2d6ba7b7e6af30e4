"""Errors against the distance from the image centre, for every model."""

from chapters.ch04_central_generic.ext_lens_formula.results import (
    NAMES,
    TITLES,
    ring_errors,
)
from chapters.ch04_central_generic.ext_lens_formula.trials import LENSES, MODELS, RINGS
from repro.page.method_looks import look_of
from repro.page.style import figure as new_figure
from repro.page.style import legend_below
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing


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
