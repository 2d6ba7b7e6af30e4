"""Figures of section 2.5.2, drawn from its simulated runs."""

import numpy as np

from chapters.ch02_general_camera_model.s5_2_real_data.results import (
    COARSE_SCALE,
    FIELD_SCALE,
    STEP_SCALE,
)
from chapters.ch02_general_camera_model.s5_2_real_data.trials.shots import (
    STAGE_IMAGES,
    STEP_MM,
)
from chapters.shared.methods import METHODS, NAMES
from chapters.shared.zoom_rigs import STAGE_ZOOM, ZOOMS
from repro.page.method_looks import look_of
from repro.page.style import INK
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing


@figure("fig_2_4", needs=("table_2_2_rendered",), evidence="rendered")
def fig_2_4(results):
    """Draw one image of each of the three sets, as the detector received it."""
    rendered = results["table_2_2_rendered"]
    drawn, axes = new_figure(1, 3, height_in=2.3)
    rows = []
    for panel, zoom in zip(axes, ZOOMS, strict=True):
        picture = rendered.arrays("sample", zoom=zoom)[0]
        panel.imshow(picture, cmap="gray", vmin=0, vmax=255)
        panel.set_title(f"Image set {zoom}")
        panel.set_axis_off()
        found = rendered.column("found.calibration", zoom=zoom)
        rows.append((zoom, *picture.shape[::-1], int(found[0])))
    levels = [
        np.median(rendered.column("distortion_level", zoom=zoom)) for zoom in ZOOMS
    ]
    return Drawing(
        drawn,
        columns(("set", "width_px", "height_px", "boards_found"), rows),
        "Rendered images of the three sets, from the longest to the shortest "
        "focal length: the first image of each set in which the board was "
        "detected.",
        Check(
            bool(np.all(np.diff(levels) > 0)),
            "the distortion over the boards rises from set to set: "
            + ", ".join(f"{level:.2f}" for level in levels),
        ),
    )


@figure("fig_2_5", needs=("table_2_2_rendered",), evidence="rendered")
def fig_2_5(results):
    """Draw the residual vectors of one image of set 3, with a scale."""
    rendered = results["table_2_2_rendered"]
    drawn, axes = new_figure(1, 2, height_in=4.0, sharex=True, sharey=True)
    rows = []
    panels = (
        ("a", "parametric", COARSE_SCALE, 5.0),
        ("b", "generic_as_printed", FIELD_SCALE, 1.0),
    )
    for panel, (letter, method, scale, bar) in zip(axes, panels, strict=True):
        field = rendered.arrays(f"field.{method}", zoom=STAGE_ZOOM)[0]
        u, v, du, dv = field[:, :4].T
        arrows = panel.quiver(
            u, v, du, dv, angles="xy", scale_units="xy",
            scale=1 / scale, width=0.004,
            color=look_of(NAMES[method])["color"],
        )  # fmt: skip
        panel.quiverkey(arrows, 0.8, 0.05, bar, f"{bar:g} px ", labelpos="W")
        panel.plot(u, v, "o", ms=1.2, color="0.4", zorder=0)
        rms = np.sqrt(np.nanmean(du**2 + dv**2))
        panel.set(
            title=f"({letter}) {NAMES[method]}\nRMS {rms:.2f} px, drawn x {scale}",
            aspect="equal",
            xlabel="u in the image (px)",
        )
        rows += [(method, *row) for row in field[:, :4]]
    axes[0].set(
        xlim=(u.min() - 60, u.max() + 60),
        ylim=(v.max() + 90, v.min() - 60),
        ylabel="v in the image (px)",
    )
    return Drawing(
        drawn,
        columns(("method", "u_px", "v_px", "du_px", "dv_px"), rows),
        "Residual vectors at the corners of the image of set 3 in Fig. 2.4, "
        "in px of the corrected view. The arrows at the lower right show the "
        f"scale. The thesis draws both {FIELD_SCALE} times as long. Here (a) "
        f"is drawn {COARSE_SCALE} times as long, because its vectors would "
        "leave the frame.",
    )


@figure(
    "fig_2_6", needs=("table_2_2_rendered", "table_2_2_redrawn"), evidence="rendered"
)
def fig_2_6(results):
    """Draw the recovered steps end to end, deviations twenty times as large."""
    drawn, axes = new_figure(1, 2, height_in=3.6, width_ratios=(3, 2))
    rows = []
    rendered = results["table_2_2_rendered"]
    axes[0].plot(
        STEP_MM * np.arange(STAGE_IMAGES), np.zeros(STAGE_IMAGES),
        "-", color="0.6", lw=5, zorder=0, label="true steps",
    )  # fmt: skip
    for method in METHODS:
        steps = rendered.arrays(f"{method}.stage.grid.steps", zoom=STAGE_ZOOM)
        if not steps:
            continue
        path = path_of(steps[0])
        axes[0].plot(*path.T, **look_of(NAMES[method]), label=NAMES[method])
        rows += [(method, x, y) for x, y in path]
    axes[0].set(
        xlabel=f"Along the mean step, deviation x {STEP_SCALE} (mm)",
        ylabel=f"Across, deviation x {STEP_SCALE} (mm)",
        title="One rendered run",
    )
    trials = [
        results["table_2_2_redrawn"].column(
            f"{method}.stage.grid.deviation_mm", zoom=STAGE_ZOOM
        )
        for method in METHODS
    ]
    failed = sum(int(np.isnan(t).sum()) for t in trials)
    axes[1].boxplot(
        [t[np.isfinite(t)] for t in trials],
        tick_labels=["standard\nperspective", "generic,\nas printed",
                     "generic, well\nconditioned"],
        showfliers=False, medianprops={"color": INK},
    )  # fmt: skip
    axes[1].tick_params(axis="x", labelsize=7.5)
    axes[1].set(
        yscale="log",
        ylabel="RMS deviation of a step (mm)",
        xlabel="Method",
        title="All redrawn runs",
    )
    drawn.legend(loc="outside lower center", ncols=2)
    return Drawing(
        drawn,
        columns(("method", "x_mm", "y_mm"), rows),
        f"Translations of {STEP_MM:g} mm recovered from homographies of "
        "five images, in the grid's frame. Left: the four steps of one "
        "rendered run end to end, with deviations from the mean step "
        f"{STEP_SCALE} times as large. Right: RMS deviation over the redrawn "
        "runs (box: quartiles, whiskers: 1.5 times their distance); "
        f"{failed} of {sum(map(len, trials))} have none and are not drawn.",
    )


def path_of(steps):
    """Return the end-to-end path (n + 1, 2) in the plane of largest deviation."""
    mean = steps.mean(axis=0)
    shown = mean + STEP_SCALE * (steps - mean)
    along = mean / np.linalg.norm(mean)
    deviation = (steps - mean) - ((steps - mean) @ along)[:, None] * along
    across = np.linalg.svd(deviation)[2][0]
    flat = np.column_stack([shown @ along, shown @ across])
    return np.vstack([[0.0, 0.0], np.cumsum(flat, axis=0)])
