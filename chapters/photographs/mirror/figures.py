"""Shapes of a mirror set: profiles, and each over its photograph with residuals."""

import numpy as np

from chapters.photographs.mirror.results import STUDY, MirrorStudy
from chapters.shared.photographs.notes import EMPTY_IN, note
from repro.page.style import WIDTH_IN, series
from repro.page.style import figure as new_figure
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

NEEDS = ("mirror_study",)
KINDS = ("mirror",)
LEVELS, FLAT_MM = 8, 0.01
# The longest arrow, as a share of the picture's width.
ARROW = 0.06
LINES = {"colors": series(1)["color"], "linestyles": "solid", "linewidths": 1.0}


def _refused(study):
    drawn, axes = new_figure(height_in=EMPTY_IN)
    note(axes, study.refusal, 90)
    return Drawing(drawn, {"stage": []}, "No shape: the calibration is refused.")


@figure("ext_mirror_profiles", needs=NEEDS, evidence="photograph", per_set=KINDS)
def ext_mirror_profiles(results):
    """The middle line of the mirror at all stages."""
    study = MirrorStudy(results[STUDY])
    if study.refusal:
        return _refused(study)
    along, height = study.array("along"), study.array("height")
    drawn, axes = new_figure(height_in=3.6)
    for stage in range(study.stages):
        look = series(stage) | {"marker": ""}
        axes.plot(along[stage], height[stage], label=f"stage {stage}", **look)
    axes.set(xlabel="From the clamp's line (mm)", ylabel="Height (mm)")
    axes.legend()
    rows = np.repeat(np.arange(study.stages), along.shape[1])
    return Drawing(
        drawn,
        {"stage": rows, "along_mm": along.ravel(), "height_mm": height.ravel()},
        "The mirror's middle line at all stages, from the clamp's line to the end of "
        "the knots: heights over the plane of the first shape, towards the camera.",
    )


@figure("ext_mirror_stages", needs=NEEDS, evidence="photograph", per_set=KINDS)
def ext_mirror_stages(results):
    """Each stage over its photograph: heights at the left, residuals at the right."""
    study = MirrorStudy(results[STUDY])
    if study.refusal:
        return _refused(study)
    shape = study.settings["height_px"] / study.settings["width_px"]
    height = study.stages * (WIDTH_IN / 2 * 0.95 * shape + 0.3)
    drawn, rows = new_figure(study.stages, 2, height_in=height, squeeze=False)
    off = [study.array("residuals", k) for k in range(study.stages)]
    long = max(float(np.nanquantile(np.hypot(*np.concatenate(off).T), 0.95)), 1e-6)
    for stage, (left, right) in enumerate(rows):
        picture = study.array("picture", stage)
        coarser = study.settings["width_px"] / picture.shape[1]
        for panel in (left, right):
            panel.imshow(picture, cmap="gray", vmin=-60, vmax=255)
            panel.set_axis_off()
        levels = study.array("heights", stage)
        if np.nanmax(levels) - np.nanmin(levels) > FLAT_MM:
            lines = left.contour(levels, LEVELS, **LINES)
            left.clabel(lines, fmt="%g", fontsize=7)
        places = (study.array("pixels", stage) + 0.5) / coarser - 0.5
        arrows = off[stage] / long * ARROW * picture.shape[1]
        seen = np.isfinite(arrows[:, 0]) & np.isfinite(places[:, 0])
        right.quiver(
            *places[seen].T, *arrows[seen].T, color=series(0)["color"], angles="xy",
            scale_units="xy", scale=1, width=0.003,
        )  # fmt: skip
        left.set_title(f"stage {stage}: height (mm)")
        right.set_title("residuals")
    stages = np.concatenate([np.full(len(own), k) for k, own in enumerate(off)])
    whole = np.concatenate(off)
    return Drawing(
        drawn,
        {"stage": stages, "u_px": whole[:, 0], "v_px": whole[:, 1]},
        "Each stage over its photograph. Left: lines of equal height, mm, over the "
        "plane of the first shape. Right: corners found less where the camera sees "
        f"them, on one scale; {long:.2g} px are drawn {100 * ARROW:g} % of the "
        "picture's width long.",
    )
