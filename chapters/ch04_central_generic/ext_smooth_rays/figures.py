"""What tables and fields leave, and a field over the image."""

import numpy as np

from chapters.ch04_central_generic.ext_smooth_rays.results import NAMES, NOISES, median
from chapters.ch04_central_generic.ext_smooth_rays.trials import METHODS, SIZE_PX
from repro.page.method_looks import look_of
from repro.page.style import figure as new_figure
from repro.page.style import legend_below, plot_estimates
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

MEASURES = {
    "left_px": ("after a homography", "Residual, corrected view (px)"),
    "off_px": ("after a rotation", "Distance in the image (px)"),
}


@figure("ext_smooth_rays_figure", needs=("ext_smooth_rays_runs",), evidence="synthetic")
def smooth_rays_figure(results):
    """Both measures against noise, for every method."""
    result = results["ext_smooth_rays_runs"]
    drawn, panels = new_figure(1, 2, height_in=3.6)
    rows = []
    for axes, (measure, (title, label)) in zip(panels, MEASURES.items(), strict=True):
        for method in METHODS:
            name = f"{method}.{measure}"
            found = [
                median(result, name, lens="bent", noise=noise, grids=3)
                for noise in NOISES
            ]
            look = {"look": look_of(NAMES[method]), "label": NAMES[method]}
            rows += plot_estimates(axes, NOISES, found, (measure, method), **look)
        axes.set(xscale="log", yscale="log", title=title, ylabel=label)
        axes.set_xlabel("Noise (px)")
        axes.set_xticks(NOISES, [f"{noise:g}" for noise in NOISES])
        axes.minorticks_off()
    legend_below(drawn, panels[0], ncols=4)
    return Drawing(
        drawn,
        columns(("measure", "method", "noise_px", "median", "low", "high"), rows),
        "What is left of the rays' errors against noise: the table of single "
        "rays, the radial law nearest to them, the law with a smooth field "
        "fitted to the table, and the field adjusted together with the poses "
        "of the grids. Bent lens, three grids; root mean squares over 999 "
        "rays, medians over trials with 95 % bands. Left, in the corrected "
        "view, after the homography that suits best; right, in the image, "
        "after one rotation of all rays.",
    )


@figure(
    "ext_smooth_rays_map_figure", needs=("ext_smooth_rays_map",), evidence="synthetic"
)
def smooth_rays_map(results):
    """Correction, stated deviation and true error of one calibration."""
    result = results["ext_smooth_rays_map"]
    pixels, field, sd, off, covered, corners = (
        result.arrays(name)[0]
        for name in ("pixels", "field", "sd", "off", "covered", "corners")
    )
    covered = covered.astype(bool)
    drawn, (left, right) = new_figure(1, 2, height_in=4.2, sharey=True)
    some = np.all(pixels % 32 == 8, axis=1)
    left.plot(*corners.T, ".", color="0.75", markersize=1.5, zorder=1)
    arrows = left.quiver(
        *pixels[some].T, *field[some].T, angles="xy", color="C0",
        width=0.005, scale_units="xy", scale=1 / 30,
    )  # fmt: skip
    left.quiverkey(arrows, 0.8, 1.04, 1.0, "1 px", labelpos="E")
    left.plot(*pixels[~covered].T, "x", color="0.5", markersize=2.5, zorder=1)
    left.set_title("correction of the law", loc="left")
    shown = right.scatter(
        *pixels.T, c=sd, s=9, marker="s", cmap="viridis", vmin=0, vmax=0.6
    )
    drawn.colorbar(
        shown, ax=right, label="Stated standard deviation (px)", extend="max"
    )
    true = right.quiver(
        *pixels[some & covered].T, *off[some & covered].T, angles="xy",
        color="w", width=0.005, scale_units="xy", scale=1 / 60,
    )  # fmt: skip
    right.quiverkey(true, 0.8, 1.04, 0.5, "0.5 px", labelpos="E", color="0.2")
    right.set_title("stated and true error", loc="left")
    for axes in (left, right):
        axes.set(
            xlim=(0, SIZE_PX), ylim=(SIZE_PX, 0), xlabel="u (px)",
            aspect="equal",
        )  # fmt: skip
    left.set_ylabel("v (px)")
    data = {
        "u_px": pixels[:, 0],
        "v_px": pixels[:, 1],
        "field_u_px": field[:, 0],
        "field_v_px": field[:, 1],
        "sd_px": sd,
        "error_u_px": off[:, 0],
        "error_v_px": off[:, 1],
        "covered": covered.astype(int),
    }
    return Drawing(
        drawn,
        data,
        "One calibration from 24 chessboards that leave the right side of "
        "the image out. Left: the field that corrects the lens formula, "
        "with the corners (dots) and the region where no corner was found "
        "(crosses). Right: the standard deviation that the camera states "
        "for its rays, in px of the image, and their true errors (arrows).",
    )
