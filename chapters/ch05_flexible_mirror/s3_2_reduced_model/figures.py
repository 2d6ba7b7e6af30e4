"""Fig. 5.6, Fig. 5.7, and errors of the curves of all runs."""

import numpy as np
from matplotlib.ticker import FixedFormatter

from chapters.ch05_flexible_mirror.s3_2_reduced_model.results import FRAMES, RUNS
from chapters.ch05_flexible_mirror.s3_2_reduced_model.trials.run import PUBLISHED_WAY
from chapters.shared.mirror_bench import CONTRASTED, SAID
from repro.page.method_looks import look_of
from repro.page.style import INK, legend_below, series
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

# Curve -> its name, the scan that it is compared with, and how it is drawn.
CURVES = {
    "before": ("primary calibration", "true_before", series(2)),
    "linear": ("linear estimate after", "true_after", series(0)),
    "final": ("final estimate after", "true_after", series(1)),
}
SHARES = (5, 50, 95)


@figure("fig_5_6", needs=("fig_5_6_pictures",), evidence="rendered")
def fig_5_6(results):
    """The chessboard in a smooth mirror, and in an uneven one."""
    result = results["fig_5_6_pictures"]
    trial = result.select()
    drawn, panels = new_figure(1, 2, height_in=3.2)
    names = {"even": "smooth mirror", "uneven": "mirror of the second level"}
    for panel, (name, title) in zip(panels, names.items(), strict=True):
        panel.imshow(trial.arrays(name)[0], cmap="gray", vmin=0, vmax=255)
        panel.set(title=title, xticks=[], yticks=[])
    depths = ("280", "1000", "5000")
    moved = [float(result.column(f"moved.{depth}")[0]) for depth in depths]
    settings = result.settings
    return Drawing(
        drawn,
        columns(
            ("depth_mm", "mean_displacement_mm"),
            list(zip(map(float, depths), moved, strict=True)),
        ),
        f"A chessboard with squares of {settings['board'][2]:g} mm, "
        f"{settings['depth_mm'] / 1000:g} m from the unbent mirror of geometry A. "
        f"Left: smooth mirror. Right: unevenness of {settings['aberration_um']:g} µm "
        "(RMS), as at the second level, and as much strain at its free edges. It "
        f"displaces the points that pixels see by {moved[-1]:.0f} mm on average; at "
        f"280 mm it would be {moved[0]:.2f} mm.",
    )


@figure("fig_5_7", needs=("fig_5_7_curves",), evidence="rendered")
def fig_5_7(results):
    """Scan and curves of one run, before and after, and their differences."""
    result = results["fig_5_7_curves"]
    trial, settings = result.select(), result.settings
    shapes = {
        name: trial.arrays(name)[0] for name in (*CURVES, "true_before", "true_after")
    }
    drawn, (left, right) = new_figure(1, 2, height_in=3.8)
    rows = []
    for name, label in (("true_before", "true mirror"), ("true_after", None)):
        look = look_of("true mirror") | {"marker": ""}
        left.plot(*shapes[name], label=label, **look)
        rows += [(name, *row, 0.0) for row in shapes[name].T]
    for name, (label, scan, look) in CURVES.items():
        x, height = shapes[name]
        on = x <= shapes[scan][0, -1]
        x, height = x[on], height[on]
        off = height - np.interp(x, *shapes[scan])
        every = look | {"markevery": 10}
        left.plot(x, height, label=label, **every)
        if name != "linear":
            right.plot(x, off, label=label, **every)
        rows += [(name, *row) for row in zip(x, height, off, strict=True)]
    right.axhline(0, color=INK, lw=1.0)
    left.set(xlabel="Position along mirror (mm)", ylabel="Height of the mirror (mm)")
    right.set(xlabel="Position along mirror (mm)", ylabel="Error of the height (mm)")
    legend_below(drawn, left, ncols=2)
    return Drawing(
        drawn,
        columns(("curve", "along_mm", "height_mm", "error_mm"), rows),
        "Left: the mirror before and after a push of "
        f"{settings['deflection_mm']:g} mm near its free edge, true and estimated with "
        f"the reduced model from a board at {settings['depth_mm']:g} mm; heights above "
        "the flat sheet, in the camera's frame. Right: errors of the primary "
        "calibration and of the final estimate. One run, second level.",
    )


@figure("ext_reduced_errors", needs=("fig_5_7_runs",), evidence="rendered")
def ext_reduced_errors(results):
    """Mean distances from the scan of all runs, in each frame, at two levels."""
    result = results[RUNS]
    drawn, panels = new_figure(1, 2, height_in=3.6, sharey=True)
    frames = FRAMES["scan_frame"]
    rows = []
    for panel, bench in zip(panels, CONTRASTED, strict=True):
        for k, (stage, (label, _, look)) in enumerate(CURVES.items()):
            at = np.arange(len(frames)) + 0.2 * (k - 1)
            found = np.array(
                [
                    np.nanpercentile(
                        result.column(f"{bench}.{PUBLISHED_WAY}.{stage}.{frame}"),
                        SHARES,
                    )
                    for frame in frames.values()
                ]
            )
            low, middle, high = found.T
            panel.errorbar(
                at,
                middle,
                [middle - low, high - middle],
                label=label,
                capsize=3,
                **look | {"linestyle": ""},
            )
            rows += [
                (SAID[bench], stage, frame, *row)
                for frame, row in zip(frames, found, strict=True)
            ]
        names = [frame.replace(" ", "\n", 1) for frame in frames]
        panel.set(title=SAID[bench], yscale="log")
        panel.set_xticks(range(len(frames)))
        panel.xaxis.set_major_formatter(FixedFormatter(names))
    panels[0].set_ylabel("Mean distance from the true mirror (mm)")
    legend_below(drawn, panels[0], ncols=3)
    return Drawing(
        drawn,
        columns(("level", "curve", "frame", "low_mm", "median_mm", "high_mm"), rows),
        "Mean distance of the curves from the true mirror: in the camera's frame, "
        "after one alignment to the curve before bending, and after an alignment of "
        f"each. Geometry A, {result.trials_per_condition} runs: medians, and bars from "
        "5 to 95 %.",
    )
