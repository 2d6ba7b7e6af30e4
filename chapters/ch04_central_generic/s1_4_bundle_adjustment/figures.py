"""The figure of section 4.1.4: where a freed centre ends."""

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
    """Error of the centre at the end against that at the start."""
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
        panel.set_xlabel("Error at the start (mm)")
    axes[0].set_ylabel("Error at the end (mm)")
    limits = np.array([np.min(ends), np.max(ends)])
    for panel in axes:
        panel.plot(limits, limits, color=INK, lw=1, ls=":", marker="")
    return Drawing(
        drawn,
        columns(("scheme", "scene", "start_mm", "end_mm"), rows),
        "Where an adjustment that frees the centre ends, against where it "
        "starts: one dot per start, the starts of a scene on the same data. "
        "Above the dotted line the centre is worse than before. The starts "
        "lie within the error of the linear stage. A scheme that forgets its "
        "start draws a level row for each scene.",
    )
