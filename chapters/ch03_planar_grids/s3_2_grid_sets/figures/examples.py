"""Figs 3.12 and 3.13: images selected by the outcome of detection."""

import numpy as np

from chapters.ch03_planar_grids.s3_2_grid_sets.results.pictures import (
    EXPERIMENTS,
    TITLES,
    pictures_of,
    right,
)
from chapters.shared.grid_detectors import CELECT, OPENCV
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

# Class of an image -> (CELECT correct, OpenCV correct).
CLASSES = {
    "both": (True, True),
    "CELECT only": (True, False),
    "neither": (False, False),
}
RED, YELLOW, GREEN = "#e0281c", "#f2c400", "#2f9e3f"


def example(result, which):
    """Return the first image of a class, or None, and the size of the class."""
    ours, theirs = (right(result, m) for m in (CELECT, OPENCV))
    wanted_ours, wanted_theirs = CLASSES[which]
    fits = (ours == wanted_ours) & (theirs == wanted_theirs)
    first = pictures_of(result).conditions[int(np.argmax(fits))]
    return (first if fits.any() else None), int(fits.sum())


def draw_panel(panel, result, condition):
    """Draw an image with CELECT's corners: circles, joined where ordered."""
    (picture,) = result.arrays("picture", **condition)
    u, v, factor = result.arrays("place", **condition)[0]
    colours = {"cmap": "gray", "vmin": 0, "vmax": 255}
    panel.imshow(picture, **({} if picture.ndim == 3 else colours))
    height, width = picture.shape[:2]

    def placed(points):
        return (points - (u, v) + 0.5) / factor - 0.5

    for name in result.arrays("detected", **condition):
        panel.plot(*placed(name).T, "o", ms=4, mfc="none", mec=RED, mew=0.8)
    for lattice in result.arrays("lattice", **condition):
        for row in placed(lattice):
            panel.plot(*row.T, "-", color=YELLOW, lw=1.0)
        for column in placed(lattice).transpose(1, 0, 2):
            panel.plot(*column.T, "-", color=GREEN, lw=1.0)
    panel.set(xlim=(-0.5, width - 0.5), ylim=(height - 0.5, -0.5))


def examples(results, set_names):
    """Return the drawing of one figure: a column per set, a row per class."""
    drawn, panels = new_figure(3, 2, height_in=9.6)
    rows = []
    for column, set_name in enumerate(set_names):
        result = results[EXPERIMENTS[set_name]]
        for row, which in enumerate(CLASSES):
            panel = panels[row, column]
            letter = "abcdef"[2 * row + column]
            condition, count = example(result, which)
            panel.set_title(f"({letter}) {TITLES[set_name]}: {which} ({count})")
            panel.set(xticks=[], yticks=[])
            panel.grid(visible=False)
            panel.spines[:].set_visible(False)
            if condition is None:
                centred = {"transform": panel.transAxes, "ha": "center", "va": "center"}
                panel.text(0.5, 0.5, "no such image", **centred)
            else:
                draw_panel(panel, result, condition)
            first = condition or {"image": None, "seed": None}
            named = letter, TITLES[set_name], which, count
            rows.append((*named, first["image"], first["seed"]))
    caption = (
        "Images in which CELECT and OpenCV's findChessboardCorners both succeed, "
        "only CELECT does, or neither does: the first of each class and, in "
        "parentheses, their number, whole range of poses, all simulated runs. "
        "Circles: corners detected by CELECT. Lines: its ordered corners, rows "
        "yellow, columns green. Images are cropped to the board."
    )
    heads = ("panel", "set", "class", "images", "image", "seed")
    return Drawing(drawn, columns(heads, rows), caption)


@figure("fig_3_12", needs=("table_3_4_grids", "table_3_5_grids"), evidence="rendered")
def fig_3_12(results):
    """Draw examples of the Spherical and Hyperboloidal sets."""
    return examples(results, ("spherical", "hyperboloidal"))


@figure("fig_3_13", needs=("table_3_6_grids", "table_3_7_grids"), evidence="rendered")
def fig_3_13(results):
    """Draw examples of the Fisheye and Flexible Mirror sets."""
    return examples(results, ("fisheye", "flexible-mirror"))
