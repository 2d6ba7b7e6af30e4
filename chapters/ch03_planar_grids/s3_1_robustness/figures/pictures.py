"""Fig. 3.10: the synthetic board."""

import numpy as np

from chapters.shared.synthetic_board import SIZE_PX, SyntheticBoard
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing


@figure("fig_3_10", needs=("fig_3_10_pictures",), evidence="rendered")
def fig_3_10(results):
    """The board before and after distortion, with its corners."""
    result = results["fig_3_10_pictures"]
    drawn, panels = new_figure(1, 2, height_in=3.9)
    rows = []
    for panel, shape, title in zip(
        panels, ("flat", "bent"), ("(a) Undistorted", "(b) FOV 134°"), strict=True
    ):
        (picture,) = result.arrays("picture", shape=shape)
        (corners,) = result.arrays("corners", shape=shape)
        panel.imshow(picture, cmap="gray", vmin=0, vmax=255)
        panel.plot(*corners.T, "o", color="#d55e00", ms=2.5)
        panel.grid(visible=False)
        panel.set(title=title, xlabel="u (px)", ylabel="v (px)")
        rows += [(shape, index, *corner) for index, corner in enumerate(corners)]
    board = SyntheticBoard()
    flat, bent = (result.arrays("corners", shape=s)[0] for s in ("flat", "bent"))
    middle = (SIZE_PX - 1) / 2
    before, after = (np.linalg.norm(c - middle, axis=1) for c in (flat, bent))
    law = 2 * board.focal_px * np.sin(np.arctan(before / board.focal_px) / 2)
    worst = float(np.abs(after - law).max())
    return Drawing(
        drawn,
        columns(("panel", "corner", "u_px", "v_px"), rows),
        "Synthetic chessboard (a) without distortion and (b) in an equisolid "
        "fisheye image with a diagonal field of view of 134°. Dots: the corners "
        "to be detected.",
        check=Check(
            worst < 1e-6,
            f"radii of all corners follow r = 2 f sin(atan(R/f)/2) to {worst:.0e} px",
        ),
    )
