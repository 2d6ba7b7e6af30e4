"""Fig. 3.18: the chessboard in the mirror ball, and its reassembled image."""

import numpy as np

from chapters.ch03_planar_grids.s3_4_active_grid_images.results import FACETS
from chapters.ch03_planar_grids.s3_4_active_grid_images.trials.facets import MM_PER_PX
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing

GREYS = (0.45, 0.75)  # of the true grid
ORANGE = "#d55e00"


@figure("fig_3_18", needs=("fig_3_18_facets",), evidence="rendered")
def fig_3_18(results):
    """Draw the image, and its remapping over the true grid."""
    ran = results[FACETS].select()
    picture, laid, seen, metric, off = (
        ran.arrays(name)[0]
        for name in ("picture", "laid", "seen", "metric", "corner_squares")
    )
    drawn, axes = new_figure(1, 2, height_in=3.9, width_ratios=(0.9, 1.3))
    axes[0].imshow(picture, cmap="gray", vmin=0, vmax=255, interpolation="antialiased")
    shown = np.where(seen, laid / 255.0, true_grid(laid.shape, metric))
    axes[1].imshow(shown, cmap="gray", vmin=0, vmax=1, interpolation="antialiased")
    known = np.isfinite(off)
    axes[1].plot(
        *(metric[known] / MM_PER_PX - 0.5).T,
        "o",
        ms=4,
        mfc="none",
        color=ORANGE,
        mew=0.8,
    )
    for panel, title in zip(axes, ("(a) in the ball", "(b) remapped"), strict=True):
        panel.set_axis_off()
        panel.set_title(title)
    rows = [(*place, error) for place, error in zip(metric, off, strict=True)]
    places = np.rint(metric / MM_PER_PX - 0.5).astype(int)
    return Drawing(
        drawn,
        columns(("x_mm", "y_mm", "off_squares"), rows),
        "(a) Image of a chessboard in a ball of flat mirrors. (b) The same image "
        "remapped by an active grid (black and white) over the true grid (grey). "
        "Circles: corners that can be localised.",
        Check(
            bool(known.any() and seen[tuple(places[known].T[::-1])].all()),
            "every circle is where the remapped image was decoded",
        ),
    )


def true_grid(shape, metric):
    """Return the chessboard in greys (h, w), white outside its squares."""
    square = np.linalg.norm(metric[1] - metric[0])
    side = int(np.sqrt(len(metric)))
    v, u = np.mgrid[: shape[0], : shape[1]]
    x, y = (
        (MM_PER_PX * (p + 0.5) - c) / square
        for p, c in zip((u, v), metric[0], strict=True)
    )
    column, row = np.floor(x).astype(int), np.floor(y).astype(int)
    black = (column + row) % 2 != 0
    inside = (np.minimum(column, row) >= -1) & (np.maximum(column, row) <= side - 1)
    return np.where(black & inside, *GREYS)
