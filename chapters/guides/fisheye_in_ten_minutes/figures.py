"""A street through a fisheye, corrected by the calibrated camera."""

import numpy as np

from chapters.guides.fisheye_in_ten_minutes.results import VIEWS
from repro.page.style import figure as new_figure
from repro.run.experiment import figure
from repro.run.outcomes import Drawing


@figure("ext_fisheye_views", needs=("ext_fisheye_look",), evidence="rendered")
def ext_fisheye_views(results):
    """Draw a street as taken, and as a pinhole view."""
    look = results[VIEWS]
    panels = {
        "As taken": look.arrays("street")[0],
        "Straight ahead": look.arrays("ahead")[0],
    }
    drawn, axes = new_figure(1, 2, height_in=2.6)
    for place, (title, picture) in zip(axes, panels.items(), strict=True):
        place.imshow(picture, cmap="gray", vmin=0, vmax=255)
        place.set_title(title)
        place.set_axis_off()
    lit_share = [float(np.mean(picture > 0)) for picture in panels.values()]
    return Drawing(
        drawn,
        {"panel": list(panels), "share of pixels not black": lit_share},
        "Image of a street through the rendered 183° lens, and the same image as a "
        "pinhole view, remapped with the calibrated camera. Straight edges are "
        "straight. Black pixels have no ray.",
    )
