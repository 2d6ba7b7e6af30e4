"""Figure of section 4.1.4: final error of a free centre."""

import numpy as np

from repro.page.method_looks import look_of
from repro.page.style import INK
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

TITLES = {
    "line_fitting": "line fitting",
    "ray_point": "ray-point distances",
    "consistent": "consistent",
}


@figure(
    "ext_free_centre_starts", needs=("exp_c4_centre_ba_unstable",), evidence="synthetic"
)
def free_centre_starts(results):
    """Final against initial error of the centre."""
    result = results["exp_c4_centre_ba_unstable"]
    drawn, axes = new_figure(1, 3, height_in=3.4, sharex=True, sharey=True)
    rows, ends = [], []
    for panel, scheme in zip(axes, TITLES, strict=True):
        starts = result.arrays(f"{scheme}.starts_mm")
        found = result.arrays(f"{scheme}.ends_mm")
        look = look_of(TITLES[scheme]) | {"linestyle": "", "ms": 3, "alpha": 0.6}
        for scene, (x, y) in enumerate(zip(starts, found, strict=True)):
            panel.plot(x, y, **look)
            rows += [(scheme, scene, *run) for run in zip(x, y, strict=True)]
        ends += [*starts, *found]
        panel.set(xscale="log", yscale="log", title=TITLES[scheme])
        panel.set_xlabel("Initial centre error (mm)")
    axes[0].set_ylabel("Final centre error (mm)")
    limits = np.array([np.min(ends), np.max(ends)])
    for panel in axes:
        panel.plot(limits, limits, color=INK, lw=1, ls=":", marker="")
    return Drawing(
        drawn,
        columns(("scheme", "scene", "start_mm", "end_mm"), rows),
        "Final against initial error of the centre for three adjustments that "
        "free it. Each point is one start, and the starts of a scene use the "
        "same data. Above the dotted line the adjustment increases the error. "
        "The starts are linear solutions. A scheme that is independent of its "
        "start gives a horizontal row for each scene.",
    )
