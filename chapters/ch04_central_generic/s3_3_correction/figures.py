"""Figs 4.7 to 4.9: a room corrected, and residuals of a chessboard."""

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
MOST_GREY = 30.0  # where the colours of a difference end
PANELS = (
    ("(a) omnidirectional, standard", OMNI, "printed"),
    ("(b) omnidirectional, CGSP", OMNI, "cgsp"),
    ("(c) fisheye, standard", FISH, "printed"),
    ("(d) fisheye, CGSP", FISH, "cgsp"),
)
METHODS = {"printed": "standard, as printed", "cgsp": "CGSP"}
ROWS = (("frame", "as taken"), ("printed", "standard"), ("cgsp", "CGSP"))
FRAMES = 2
LETTERS = ("ab", "cd", "ef", "gh")  # row by row


def _pictures(results, camera, height_in):
    """Frames as taken, standard, CGSP, and CGSP less standard: four rows of two."""
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
            shown = panel.imshow(off, cmap="RdBu", vmin=-MOST_GREY, vmax=MOST_GREY)
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
    """CGSP less standard (H, W), grey levels; NaN where either has no ray (black)."""
    both = (printed > 0) & (cgsp > 0)
    return np.where(both, cgsp.astype(float) - printed, np.nan)


@figure("fig_4_7", needs=("fig_4_7_pictures",), evidence="rendered")
def fig_4_7(results):
    """The mirror's picture of a room, unwrapped by both calibrations."""
    drawn, data = _pictures(results, OMNI, height_in=7.6)
    return Drawing(
        drawn,
        data,
        "A room in the mirror of the omnidirectional camera, and its "
        "calibrated part unwrapped on an upright cylinder about the camera's "
        "centre, with the standard method as printed and adjusted, and with "
        "CGSP, both at the bench's noise. Black: pixels without a ray. Last row: the "
        "grey levels of CGSP's picture less those of the standard one's, where both "
        "have a ray.",
    )


@figure("fig_4_8", needs=("fig_4_7_pictures",), evidence="rendered")
def fig_4_8(results):
    """The fisheye's picture of a room, made that of a pinhole."""
    drawn, data = _pictures(results, FISH, height_in=9.0)
    return Drawing(
        drawn,
        data,
        "A room through the fisheye, and its middle 100° as a pinhole would "
        "show them, with the standard method as printed and adjusted, and "
        "with CGSP, both at the bench's noise. Black: pixels without a ray. Last "
        "row: the grey levels of "
        "CGSP's picture less those of the standard one's.",
    )


@figure("fig_4_9", needs=("fig_4_9_boards",), evidence="rendered")
def fig_4_9(results):
    """Residual vectors of one board by camera and method."""
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
        "Residuals of one chessboard after its view was corrected at the bench's "
        "noise and carried "
        f"onto the metric grid, {MAGNIFIED} times as long as they are (in the "
        "thesis, 15 times); the arrow at the lower left is the key. Each panel "
        "shows the board that most calibrated rays see, of the first seed.",
    )
