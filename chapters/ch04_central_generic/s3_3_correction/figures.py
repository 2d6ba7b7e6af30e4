"""Figs 4.7 to 4.9: a corrected room, and residuals of a chessboard."""

import numpy as np

from chapters.ch04_central_generic.s3_3_correction.results import BOARDS
from chapters.ch04_central_generic.s3_3_correction.trials.boards import MAGNIFIED
from chapters.shared.bench_noise import BENCH
from chapters.shared.central_sets import FISH, OMNI
from repro.page.method_looks import look_of
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

KEY_MM = 0.2  # of the arrow that shows the scale
MAX_GREY = 30.0  # limit of the colours of a difference
PANELS = (
    ("(a) omnidirectional, standard", OMNI, "printed"),
    ("(b) omnidirectional, CGSP", OMNI, "cgsp"),
    ("(c) fisheye, standard", FISH, "printed"),
    ("(d) fisheye, CGSP", FISH, "cgsp"),
)
METHODS = {"printed": "standard, as printed", "cgsp": "CGSP"}
ROWS = (("frame", "original"), ("printed", "standard"), ("cgsp", "CGSP"))
FRAMES = 2
LETTERS = ("ab", "cd", "ef", "gh")  # row by row


def _images(results, camera, height_in):
    """Draw original frames, standard, CGSP and their difference: four rows of two."""
    result = results["fig_4_7_pictures"]
    drawn, axes = new_figure(len(ROWS) + 1, FRAMES, height_in=height_in)
    rows = []
    for number, (name, words) in enumerate(ROWS):
        for frame, panel in enumerate(axes[number]):
            letter = LETTERS[number][frame]
            panel.set_title(f"({letter}) {words}, frame {frame + 1}")
            panel.set_axis_off()
            found = result.arrays(f"{name}_{frame}", camera=camera)
            if found:
                panel.imshow(found[0], cmap="gray", vmin=0, vmax=255)
                rows.append((letter, float(found[0].mean()), None))
    for frame, panel in enumerate(axes[-1]):
        letter = LETTERS[-1][frame]
        panel.set_axis_off()
        printed, cgsp = (
            result.arrays(f"{name}_{frame}", camera=camera)
            for name in ("printed", "cgsp")
        )
        if printed and cgsp:
            off = difference(printed[0], cgsp[0])
            shown = panel.imshow(off, cmap="RdBu", vmin=-MAX_GREY, vmax=MAX_GREY)
            rms = float(np.sqrt(np.nanmean(off**2)))
            panel.set_title(f"({letter}) CGSP − standard, RMS {rms:.1f}")
            rows.append((letter, None, rms))
    if axes[-1, 0].images:
        bar = drawn.colorbar(
            shown, ax=axes[-1], location="bottom", shrink=0.5, aspect=40, extend="both"
        )
        bar.set_label("Difference (grey levels)")
    return drawn, columns(("panel", "mean_grey", "rms_difference_grey"), rows)


def difference(printed, cgsp):
    """Return CGSP minus standard (H, W), grey levels; NaN where either has no ray."""
    both = (printed > 0) & (cgsp > 0)
    return np.where(both, cgsp.astype(float) - printed, np.nan)


@figure("fig_4_7", needs=("fig_4_7_pictures",), evidence="rendered")
def fig_4_7(results):
    """Draw the mirror camera's image of a room, unwrapped by both calibrations."""
    drawn, data = _images(results, OMNI, height_in=7.6)
    return Drawing(
        drawn,
        data,
        "Images of a room by the omnidirectional camera: original, and the calibrated "
        "part unwrapped on a vertical cylinder about the camera centre, by the "
        "standard method as printed and adjusted, and by CGSP, at the thesis-matched "
        "level. Black: pixels without a ray. Last row: grey levels of CGSP minus "
        "standard, where both have a ray.",
    )


@figure("fig_4_8", needs=("fig_4_7_pictures",), evidence="rendered")
def fig_4_8(results):
    """Draw the fisheye's image of a room, corrected to a pinhole view."""
    drawn, data = _images(results, FISH, height_in=9.0)
    return Drawing(
        drawn,
        data,
        "Images of a room by the fisheye: original, and the central 100° corrected to "
        "a pinhole view, by the standard method as printed and adjusted, and by CGSP, "
        "at the thesis-matched level. Black: pixels without a ray. Last row: grey "
        "levels of CGSP minus standard.",
    )


@figure("fig_4_9", needs=("fig_4_9_boards",), evidence="rendered")
def fig_4_9(results):
    """Draw residual vectors of one board by camera and method."""
    result = results[BOARDS]
    drawn, axes = new_figure(2, 2, height_in=5.4, sharex=True, sharey=True)
    rows = []
    for panel, (title, camera, method) in zip(axes.flat, PANELS, strict=True):
        found = result.select(camera=camera).arrays(f"{BENCH}.{method}.field")
        panel.set(title=title, aspect="equal")
        if not found:
            continue
        x, y, dx, dy = found[0][:, :4].T
        colour = look_of(METHODS[method])["color"]
        panel.plot(x, y, ".", color=colour, markersize=3)
        ends = np.column_stack([x + MAGNIFIED * dx, y + MAGNIFIED * dy])
        panel.update_datalim(ends)
        arrows = panel.quiver(
            x, y, MAGNIFIED * dx, MAGNIFIED * dy, angles="xy",
            scale_units="xy", scale=1, color=colour, width=0.004,
        )  # fmt: skip
        panel.quiverkey(
            arrows, 0.13, 0.07, MAGNIFIED * KEY_MM, f"{KEY_MM:g} mm", labelpos="E"
        )  # fmt: skip
        rows += [(camera, method, *row[:4]) for row in found[0]]
    for panel in axes[-1]:
        panel.set_xlabel("x (mm)")
    for panel in axes[:, 0]:
        panel.set_ylabel("y (mm)")
    return Drawing(
        drawn,
        columns(("camera", "method", "x_mm", "y_mm", "dx_mm", "dy_mm"), rows),
        "Residual vectors of one chessboard after distortion correction and a "
        f"homography to the metric grid, enlarged {MAGNIFIED} times (in the thesis, 15 "
        "times), at the thesis-matched level. The arrow at the lower left is the "
        "scale. Each panel shows the board of the first run with most calibrated "
        "rays.",
    )
