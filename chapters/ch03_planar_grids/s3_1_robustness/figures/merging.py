"""Why a rotated board fails: candidates on side 1 and the distance t8."""

import numpy as np

from chapters.ch03_planar_grids.s3_1_robustness.results import PRIMARY, Under
from chapters.ch03_planar_grids.s3_1_robustness.trials import SHOWN_YAW_DEG, SMOOTHINGS
from repro.page.style import figure as new_figure
from repro.page.style import series
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

CROP_PX = 28
SHOWN_CORNERS = 3


@figure("ext_celect_merging", needs=("ext_celect_merging",), evidence="rendered")
def ext_celect_merging(results):
    """Last corners of side 1, and the gap between their candidates over yaw."""
    result = results["ext_celect_merging"]
    drawn, (image, panel) = new_figure(1, 2, height_in=3.7, width_ratios=(1, 1.25))
    _draw_corners(image, result)
    rows = _draw_gaps(panel, result)
    return Drawing(
        drawn,
        columns(("smoothing", "yaw_deg", "step_px", "gap_px", "t8_px"), rows),
        "Candidates of CELECT on side 1 of a rotated board. Left: the far end of "
        f"the side at a yaw of {SHOWN_YAW_DEG}°, with true corners and Harris's "
        "candidates. Right: smallest step between neighbouring corners, smallest "
        "gap between candidates of neighbouring corners, and the merging distance "
        "$t_8$, over yaw. Blur 1 px, no noise, exact clicks.",
    )


def _draw_corners(panel, result):
    shown = {"yaw_deg": SHOWN_YAW_DEG}
    (image,) = result.arrays("picture", **shown)
    (truth,) = result.arrays("truth", **shown)
    last = truth[-SHOWN_CORNERS:]
    panel.imshow(image, cmap="gray", vmin=-120, vmax=375)
    panel.plot(*last.T, "x", color="black", ms=9, mew=2, label="true corner")
    for index, smoothing in enumerate(SMOOTHINGS):
        prefix = Under(result, smoothing).prefix
        (found,) = result.arrays(f"{prefix}candidates", **shown)
        look = series(1 + index) | {"linestyle": "none"}
        panel.plot(*found.T, ms=6, label=smoothing, **look)
    middle = (last.min(axis=0) + last.max(axis=0)) / 2
    reach = np.ptp(last, axis=0).max() / 2 + CROP_PX
    panel.set(
        xlim=(middle[0] - reach, middle[0] + reach),
        ylim=(middle[1] + reach, middle[1] - reach),
        title=f"Side 1, yaw {SHOWN_YAW_DEG}°",
        xlabel="u (px)",
        ylabel="v (px)",
    )
    panel.grid(visible=False)
    panel.legend(loc="lower left", fontsize=8, handlelength=1.2)


def _draw_gaps(panel, result):
    rows = []
    yaws = [c["yaw_deg"] for c in result.conditions]

    def along(name):
        return [result.column(name, yaw_deg=yaw)[0] for yaw in yaws]

    steps = along("step_px")
    panel.plot(yaws, steps, label="step between corners", **series(0))
    for index, smoothing in enumerate(SMOOTHINGS):
        prefix = Under(result, smoothing).prefix
        gap, merge = along(f"{prefix}gap_px"), along(f"{prefix}t8_px")
        label = f"gap, {smoothing}"
        panel.plot(yaws, gap, label=label, **series(1 + index))
        if smoothing == PRIMARY:
            panel.plot(yaws, merge, label="$t_8$", **series(6))
        rows += [
            (smoothing, *cells) for cells in zip(yaws, steps, gap, merge, strict=True)
        ]
    panel.set(ylim=(0, 50), xlabel="Yaw (deg)", ylabel="Distance (px)")
    panel.legend(loc="lower left", fontsize=8)
    return rows
