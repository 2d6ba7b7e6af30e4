"""The primary surface from each pixel's point, and from the squares of a chessboard."""

import numpy as np

from chapters.ch05_flexible_mirror.s2_method.results import UNEVEN_UM, surfaces
from chapters.ch05_flexible_mirror.s2_method.trials.static_grids import PITCH_MM
from repro.page.style import INK, legend_below, series
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

SHOWN = {
    "uneven, as published": (UNEVEN_UM, "linear"),
    "uneven, refined": (UNEVEN_UM, "refined"),
    "even, as published": (0.0, "linear"),
    "even, refined": (0.0, "refined"),
}


@figure("ext_static_grids", needs=("exp_c5_static_grid_bias",), evidence="synthetic")
def ext_static_grids(results):
    """Errors of the surface from squares over those from each pixel."""
    drawn, axes = new_figure(height_in=4.2)
    rows = []
    for k, (name, (um, stage)) in enumerate(SHOWN.items()):
        pixel, grid = (
            1000 * surfaces(results, um, points, stage) for points in ("pixel", "grid")
        )
        look = series(k) | {"linestyle": ""}
        axes.plot(pixel, grid, label=name, markersize=4, **look)
        rows += [(name, *row) for row in zip(pixel, grid, strict=True)]
    most = max(max(row[1:]) for row in rows)
    least = min(min(row[1:]) for row in rows)
    ends = [0.8 * least, 1.2 * most]
    axes.plot(ends, ends, color=INK, linestyle=":", marker="", label="alike")
    axes.set(xscale="log", yscale="log", xlim=ends, ylim=ends)
    axes.set_aspect("equal")
    axes.set_xlabel("Surface error, point of each pixel (µm)")
    axes.set_ylabel("Surface error, squares (µm)")
    legend_below(drawn, axes, ncols=3)
    trials = results["exp_c5_static_grid_bias"].select(aberration_um=UNEVEN_UM)
    off = float(np.median(trials.column("grid.off_mm")))
    return Drawing(
        drawn,
        columns(("surface", "pixel_um", "grid_um"), rows),
        "Mean error of the mirror's first surface without any noise, a mark for each "
        "mirror: from points that are known at every pixel, and from those "
        f"interpolated in squares of {PITCH_MM:g} mm. Above the dotted line the "
        f"squares are worse. In a mirror uneven by {UNEVEN_UM:g} µm (RMS) interpolated "
        f"points are {off:.2f} mm off (median).",
    )
