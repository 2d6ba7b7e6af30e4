"""Fig. 2.7: a building front, corrected in two ways."""

from __future__ import annotations

import numpy as np

from chapters.shared.facade import T_world_camera
from chapters.shared.surroundings import drawn_surroundings
from chapters.shared.zoom_rigs import FACADE_ZOOM, camera_of
from raxel.lab import facade
from repro.page.style import figure as new_figure
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing

PANELS = (
    ("facade", "(a) as taken"),
    ("view.parametric", "(b) parametric"),
    ("view.parametric", "(c) part of (b)"),
    ("view.generic_as_printed", "(d) generic"),
    ("view.generic_as_printed", "(e) part of (d)"),
    ("view.upright", "(f) as (d), plane upright"),
)
PART = (slice(300, 500), slice(620, 820))
# Less steep than into a room: the front is what one looks at.
SIGHT = (0.5, 0.35, 0.8)


@figure("fig_2_7", needs=("table_2_2_rendered",), evidence="rendered")
def fig_2_7(results):
    """The front as taken, corrected in two ways, and kept upright."""
    rendered = results["table_2_2_rendered"]
    drawn, axes = new_figure(3, 2, height_in=7.6)
    shown = {"panel": [], "share_of_picture_shown": []}
    for panel, (name, title) in zip(axes.flat, PANELS, strict=True):
        picture = rendered.arrays(name, zoom=FACADE_ZOOM)[0]
        rows, columns = PART
        if title.startswith(("(b)", "(d)")):
            panel.add_patch(frame_of(rows, columns))
        if title.startswith(("(c)", "(e)")):
            picture = picture[PART]
        panel.imshow(picture, cmap="gray", vmin=0, vmax=255)
        panel.set_title(title)
        panel.set_axis_off()
        panel.set_anchor("W")
        shown["panel"].append(title)
        shown["share_of_picture_shown"].append(float(np.mean(picture > 0)))
    return Drawing(
        drawn,
        shown,
        "A building front through the lens of image set 2: as taken; "
        "corrected with each calibration of one rendered seed, with a part "
        "enlarged; and the generic correction on a plane parallel to the "
        "front's verticals. Black: no ray.",
        Check(
            shown["share_of_picture_shown"][3] > 0.05,
            "the generic correction shows a part of the front",
        ),
    )


@figure(
    "ext_fig_2_7_facade",
    needs=("ext_rigs",),
    evidence="analytic",
    scene=True,
)
def ext_fig_2_7_facade(results):
    """The building front of Fig. 2.7 with its camera."""
    return drawn_surroundings(
        facade(),
        camera_of(FACADE_ZOOM),
        T_world_camera(),
        "The building front of Fig. 2.7 and the camera before it, tilted "
        "upwards. Blue: the rays of the picture's border, cut off at one "
        "length; the lowest meet the ground before that. The camera is drawn larger "
        "than it is.",
        SIGHT,
    )


def frame_of(rows, columns):
    """Outline of the enlarged part."""
    from matplotlib.patches import Rectangle

    return Rectangle(
        (columns.start, rows.start),
        columns.stop - columns.start,
        rows.stop - rows.start,
        fill=False,
        color="#d55e00",
        lw=1.5,
    )
