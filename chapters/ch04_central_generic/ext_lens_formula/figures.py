"""Errors by distance from the middle of the image, for every model."""

import numpy as np

from chapters.ch04_central_generic.ext_lens_formula.results import (
    NAMES,
    SHOWN,
    TITLES,
    first_study,
    residuals_by_radius,
    ring_errors,
)
from chapters.ch04_central_generic.ext_lens_formula.trials import LENSES, MODELS, RINGS
from chapters.shared.photographs.notes import note
from chapters.shared.photographs.reading import EVERY
from repro.page.method_looks import look_of
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

BINS = 8  # of the photographs' corners, by their distance from the middle


@figure(
    "ext_lens_formula_figure",
    needs=("ext_lens_known", "photograph_study"),
    evidence="synthetic",
)
def lens_formula(results):
    """Three known lenses and a real one: RMS distance in rings, every model."""
    drawn, axes = new_figure(2, 2, height_in=5.6)
    rows = []

    def add(panel, camera, model, label, radius, rms):
        panel.plot(radius, rms, label=label, **(look_of(label) | {"ms": 3}))
        rows.extend((camera, model, *at) for at in zip(radius, rms, strict=True))

    middle = (RINGS[1:] + RINGS[:-1]) / 2
    for panel, lens in zip(axes.flat, LENSES, strict=False):
        for model in MODELS:
            rms = ring_errors(results["ext_lens_known"], lens, model)
            if rms is not None:
                add(panel, lens, model, NAMES[model], middle, rms)
        panel.set_title(TITLES[lens])
    of_photographs = first_study(results["photograph_study"])
    panels = list(axes.flat)
    if of_photographs is None:
        note(panels.pop(), "no photographs kept out in this build")
    else:
        name, study = of_photographs
        for model in SHOWN:
            found = residuals_by_radius(study, model)
            if found is not None:
                add(panels[-1], name, model, EVERY[model], *_binned(*found))
        panels[-1].set_title("photographs")
        panels[-1].legend(fontsize=7)
    for panel in panels:
        panel.set(
            yscale="log",
            xlabel="Distance from the middle (px)",
            ylabel="RMS error, kept out (px)",
        )
    panels[0].set_ylim(top=3e3)
    panels[0].legend(fontsize=7, loc="upper left")
    return Drawing(
        drawn,
        columns(("camera", "model", "radius_px", "rms_px"), rows),
        "How far models are off on boards kept out, by the distance from the "
        "middle of the image. Three known lenses: 12 boards with 0.1 px of "
        "noise, and exact corners kept out; medians over trials. Last, where "
        "there are any: the first set of photographs of the build, whose "
        "corners scatter themselves.",
    )


def _binned(radius, off):
    """Mean radius and RMS distance of bins with equally many corners."""
    parts = np.array_split(np.argsort(radius), BINS)
    return (
        np.array([radius[part].mean() for part in parts]),
        np.array([np.sqrt(np.mean(off[part] ** 2)) for part in parts]),
    )
