"""Drawing one run of CELECT: the trace over the board, and one window close up."""

import numpy as np

from chapters.ch03_planar_grids.ext_why_it_fails.trials.stages import (
    CLICK,
    DONE,
    FALSE,
    MERGED,
    MISSED,
    NO_EDGE,
    ORDER,
    STAGES,
    THROWN_OUT,
    TOO_LONG,
    UNSEEN,
    WRONG_EDGE,
)
from chapters.ch03_planar_grids.ext_why_it_fails.trials.windows import COARSE, REACH
from chapters.shared.window_lines import line_ends

GOOD, BAD = "#0072b2", "#d55e00"
EDGE, CHOSEN, OTHER = "#e69f00", "#d55e00", "#56b4e9"
CORNER, MERGED_CORNER = "#009e73", "#c76ea3"
FOLLOWED = {"color": CHOSEN, "lw": 2.4, "ls": "-"}
FOUND = {"color": OTHER, "lw": 1.5, "ls": "--"}
COLOURS = {
    DONE: "#d5d9de",
    NO_EDGE: "#0072b2",
    WRONG_EDGE: "#d55e00",
    TOO_LONG: "#7fd1b9",
    CLICK: "#56b4e9",
    MISSED: "#e69f00",
    THROWN_OUT: "#8c5a2b",
    MERGED: "#c76ea3",
    FALSE: "#009e73",
    ORDER: "#4a4a4a",
    UNSEEN: "#1b1f24",
}


def draw_overview(panel, kept, title):
    """The picture with the anchors of all contours, the lost one in orange."""
    picture = kept["overview"]
    height, width = (COARSE * n for n in picture.shape)
    _grey(panel, picture, 0.55, (-0.5, width - 0.5, height - 0.5, -0.5))
    lost, contours = kept["lost_contour"].item(), kept["contour_of"]
    for index in sorted(np.unique(contours), key=lambda i: i == lost):
        anchors = kept["anchors"][contours == index]
        colour, width_pt = (BAD, 2) if index == lost else (GOOD, 1.1)
        panel.plot(*anchors.T, "-o", ms=1.8, color=colour, lw=width_pt)
    panel.plot(*kept["outer"][0], "*", color="#1b1f24", ms=9)
    _circle(panel, kept, color="#1b1f24", lw=1.4, marker="")
    panel.set(xlim=(-0.5, width - 0.5), ylim=(height - 0.5, -0.5), title=title)
    _bare(panel)


def draw_window(panel, kept):
    """One window: edge pixels, lines, the chosen one, candidates and corners."""
    cut, (left, top) = kept["cut"], kept["cut_at"]
    height, width = cut.shape
    extent = (left - 0.5, left + width - 0.5, top + height - 0.5, top - 0.5)
    _grey(panel, cut, 0.6, extent)
    _circle(panel, kept, color="#1b1f24", lw=1.4, marker="")
    panel.plot(*kept["edges"].T, "s", color=EDGE, ms=1.6)
    (u, v), radius = kept["centre"], kept["radius"].item()
    for index, line in enumerate(kept["lines"]):
        if abs(line[0]) < radius:
            ends = line_ends(kept["centre"], radius, line)
            is_chosen = index == kept["chosen"].item()
            panel.plot(*ends.T, marker="", **(FOLLOWED if is_chosen else FOUND))
    panel.plot(*kept["trace"].T, "-o", color=GOOD, ms=4, lw=1)
    panel.plot(*kept["candidates"].T, "x", color=CORNER, ms=7, mew=1.8)
    if len(kept["merged"]):
        ring = {"mfc": "none", "mec": MERGED_CORNER, "ms": 12, "mew": 1.8}
        panel.plot(*kept["merged"].T, "o", **ring)
    panel.plot(*kept["centre"], "o", color="#1b1f24", ms=5)
    reach = REACH * radius
    panel.set(xlim=(u - reach, u + reach), ylim=(v + reach, v - reach))
    _bare(panel)


def window_legend():
    """(handles, labels) of a close-up."""
    from matplotlib.lines import Line2D

    looks = {
        "window": {"color": "#1b1f24", "lw": 1.4, "marker": ""},
        "edge pixels": {"color": EDGE, "marker": "s", "ls": "", "ms": 4},
        "lines found": FOUND,
        "line followed": FOLLOWED,
        "anchors": {"color": GOOD, "marker": "o", "lw": 1, "ms": 4},
        "candidate corners": {"color": CORNER, "marker": "x", "ls": "", "mew": 1.8},
        "corners after merging": {
            "mfc": "none",
            "mec": MERGED_CORNER,
            "marker": "o",
            "ls": "",
            "ms": 9,
            "mew": 1.8,
        },
        "lost contour": {"color": BAD, "marker": "o", "lw": 2, "ms": 3},
        "first corner": {"color": "#1b1f24", "marker": "*", "ls": "", "ms": 9},
    }
    return [Line2D([], [], **look) for look in looks.values()], list(looks)


def draw_stages(panel, shares, label):
    """Stacked bars: level -> stage -> share of the trials (%)."""
    names = list(shares)
    ticks = [
        name.replace("blur ", "blur\n").replace("noise ", "noise\n") for name in names
    ]
    bottom = np.zeros(len(names))
    for stage in (DONE, *STAGES, UNSEEN):
        heights = np.array([shares[n].get(stage, 0.0) for n in names])
        if heights.any():
            look = {"color": COLOURS[stage], "label": stage, "width": 0.8}
            panel.bar(ticks, heights, bottom=bottom, **look)
        bottom += heights
    panel.set(ylim=(0, 100), ylabel="Trials (%)", xlabel=label)
    panel.grid(visible=False, axis="x")
    panel.legend(loc="lower left", bbox_to_anchor=(0, 1.0), ncols=4, borderaxespad=0.3)


def _circle(panel, kept, **look):
    if not kept["cut"].size:
        return
    angle = np.linspace(0, 2 * np.pi, 121)
    ring = kept["radius"].item() * np.column_stack((np.cos(angle), np.sin(angle)))
    panel.plot(*(kept["centre"] + ring).T, **look)


def _bare(panel):
    panel.set(xticks=[], yticks=[], aspect="equal")
    panel.grid(visible=False)


def _grey(panel, picture, alpha, extent):
    look = {"cmap": "gray", "vmin": 0, "vmax": 255}
    panel.imshow(picture, alpha=alpha, extent=extent, **look)
