"""Figs 4.7 to 4.9: a room corrected, and residuals of a chessboard."""

import numpy as np

from chapters.ch04_central_generic.s3_3_correction.results import BOARDS
from chapters.ch04_central_generic.s3_3_correction.trials.sweeps import MAGNIFIED
from chapters.shared.central_sets import FISH, OMNI
from repro.page.style import figure as new_figure
from repro.page.style import series
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

PANELS = (
    ("(a) omnidirectional, standard", OMNI, "printed"),
    ("(b) omnidirectional, CGSP", OMNI, "cgsp"),
    ("(c) fisheye, standard", FISH, "printed"),
    ("(d) fisheye, CGSP", FISH, "cgsp"),
)
ROWS = (("frame", "as taken"), ("printed", "standard"), ("cgsp", "CGSP"))


def _pictures(results, camera):
    """Frames as taken, standard, CGSP: three rows of two."""
    result = results["fig_4_7_pictures"]
    drawn, axes = new_figure(3, 2, height_in=6.4)
    rows = []
    for number, panel in enumerate(axes.flat):
        row, frame = divmod(number, 2)
        name, words = ROWS[row]
        found = result.arrays(f"{name}_{frame}", camera=camera)
        letter = "abcdef"[number]
        panel.set_title(f"({letter}) {words}, frame {frame + 1}")
        panel.set_axis_off()
        if found:
            panel.imshow(found[0], cmap="gray", vmin=0, vmax=255)
            rows.append((letter, float(found[0].mean())))
    return drawn, columns(("panel", "mean_grey"), rows)


@figure("fig_4_7", needs=("fig_4_7_pictures",), evidence="rendered")
def fig_4_7(results):
    """The mirror's picture of a room, unwrapped by both calibrations."""
    drawn, data = _pictures(results, OMNI)
    return Drawing(
        drawn,
        data,
        "A room in the mirror of the omnidirectional camera, and its "
        "calibrated part unwrapped on an upright cylinder about the camera's "
        "centre, with the standard method as printed and adjusted, and with "
        "CGSP. Black: pixels without a ray.",
    )


@figure("fig_4_8", needs=("fig_4_7_pictures",), evidence="rendered")
def fig_4_8(results):
    """The fisheye's picture of a room, made that of a pinhole."""
    drawn, data = _pictures(results, FISH)
    return Drawing(
        drawn,
        data,
        "A room through the fisheye, and its middle 100° as a pinhole would "
        "show them, with the standard method as printed and adjusted, and "
        "with CGSP. Black: pixels without a ray.",
    )


@figure("fig_4_9", needs=("fig_4_9_boards",), evidence="rendered")
def fig_4_9(results):
    """Residual vectors of one board by camera and method."""
    result = results[BOARDS]
    drawn, axes = new_figure(2, 2, height_in=6.0)
    rows = []
    for panel, (title, camera, method) in zip(axes.flat, PANELS, strict=True):
        found = result.select(camera=camera).arrays(f"{method}.field")
        panel.set(title=title, xlabel="x (mm)", ylabel="y (mm)")
        panel.set_aspect("equal", adjustable="datalim")
        if not found:
            continue
        x, y, dx, dy = found[0][:, :4].T
        panel.plot(x, y, ".", color=series(7)["color"], markersize=3)
        ends = np.column_stack([x + MAGNIFIED * dx, y + MAGNIFIED * dy])
        panel.update_datalim(ends)
        panel.quiver(
            x, y, MAGNIFIED * dx, MAGNIFIED * dy, angles="xy",
            scale_units="xy", scale=1, color=series(0)["color"], width=0.004,
        )  # fmt: skip
        rows += [(camera, method, *row[:4]) for row in found[0]]
    return Drawing(
        drawn,
        columns(("camera", "method", "x_mm", "y_mm", "dx_mm", "dy_mm"), rows),
        "Residuals of one chessboard after its view was corrected and carried "
        f"onto the metric grid, {MAGNIFIED} times as long as they are (in the "
        "thesis, 15 times). Each panel shows the board that most calibrated "
        "rays see, of the first seed.",
    )
