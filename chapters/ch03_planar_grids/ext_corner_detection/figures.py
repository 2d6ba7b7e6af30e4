"""Figures of 6.3.1: split corners, changes by further stages, and the coded grid."""

import numpy as np
from matplotlib.ticker import FixedFormatter

from chapters.ch03_planar_grids.ext_corner_detection.results import (
    by_picture,
    comparisons,
    counts,
    successes,
)
from chapters.ch03_planar_grids.ext_corner_detection.trials.coded import OUTCOMES
from chapters.ch03_planar_grids.ext_corner_detection.trials.further import (
    OTHERS,
    PUBLISHED,
)
from repro.page.style import figure as new_figure
from repro.page.style import legend_below, series
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing

# How much of the picture the figure of split corners shows, around a corner.
HALF_PX = 34
SHOWN = (2, 5, 8)
COLOURS = ("#009e73", "#56b4e9", "#d5d9de", "#e69f00", "#d55e00")
HATCHES = ("", "..", "", "//", "xx")
MARGIN_PX = 40


@figure("ext_split_corners", needs=("ext_split_corners_runs",), evidence="synthetic")
def ext_split_corners(results):
    """Candidates at three corners of a blurred contour, by either detector."""
    result = results["ext_split_corners_runs"]
    (picture,) = result.arrays("picture")
    (corners,) = result.arrays("corners")
    drawn, panels = new_figure(2, len(SHOWN), height_in=5.4)
    rows, candidates = [], {}
    for row, name in enumerate((PUBLISHED, "symmetry")):
        (inliers,) = result.arrays(f"{name}.inliers")
        candidates[name] = len(inliers)
        for panel, number in zip(panels[row], SHOWN, strict=True):
            _draw_corner(panel, picture, corners[number], inliers)
            panel.set(title=f"{name}, corner {number + 1}", xlabel="u (px)")
            near = np.abs(inliers - corners[number]).max(axis=1) < HALF_PX
            points = [("truth", corners[number])]
            points += [("candidate", p) for p in inliers[near]]
            rows += [(name, number + 1, kind, u, v) for kind, (u, v) in points]
    drawn.supylabel("v (px)", fontsize=10)
    legend_below(drawn, panels[0, 0], ncols=2)
    return Drawing(
        drawn,
        columns(("detector", "corner", "kind", "u_px", "v_px"), rows),
        "Three corners of the first side under a blur of 5 px. The side has "
        f"{candidates[PUBLISHED]} candidates of the published detector (above) "
        f"and {candidates['symmetry']} of the symmetric one (below).",
    )


def _draw_corner(panel, picture, corner, inliers):
    panel.imshow(picture, cmap="gray", vmin=0, vmax=255)
    panel.plot(
        *inliers.T,
        "o",
        mfc="none",
        mec="#d55e00",
        mew=1.6,
        ms=7,
        ls="none",
        label="candidate",
    )
    panel.plot(*corner, "+", color="#0072b2", ms=11, mew=2, label="truth")
    u, v = corner
    panel.set(xlim=(u - HALF_PX, u + HALF_PX), ylim=(v + HALF_PX, v - HALF_PX))
    panel.grid(visible=False)


@figure("ext_further_changes", needs=("ext_further_ideas_runs",), evidence="synthetic")
def ext_further_changes(results):
    """Change of the share of successes, with its interval, by picture."""
    result = results["ext_further_ideas_runs"]
    compared = comparisons(result)
    pictures = result.levels("picture")
    drawn, axes = new_figure(height_in=0.62 * len(pictures) + 1.4)
    places, rows = np.arange(len(pictures), dtype=float), []
    for index, method in enumerate(OTHERS):
        found = [compared[picture, method] for picture in pictures]
        change = 100 * np.array([v["after"] - v["before"] for v in found])
        low, high = (100 * np.array([v[end] for v in found]) for end in ("low", "high"))
        look = dict(series(index), linestyle="none")
        axes.errorbar(
            change,
            places + 0.18 * (index - 1.5),
            xerr=np.maximum([change - low, high - change], 0),
            label=method,
            capsize=2,
            **look,
        )
        rows += [
            (picture, method, *numbers)
            for picture, *numbers in zip(pictures, change, low, high, strict=True)
        ]
    axes.axvline(0, color="#4a4a4a", linewidth=1)
    labels = [
        f"{p}\n(published: {100 * successes(result, p, PUBLISHED).mean():.0f} %)"
        for p in pictures
    ]
    axes.set_yticks(places)
    axes.yaxis.set_major_formatter(FixedFormatter(labels))
    axes.invert_yaxis()
    axes.set(xlabel="Change of successful pictures (percentage points)")
    drawn.legend(loc="outside lower center", ncols=4)
    return Drawing(
        drawn,
        columns(("picture", "method", "change", "low", "high"), rows),
        "Further stages against the published ones: change of the share of "
        "pictures with every corner right. Bars: 95 % intervals, resampled "
        "by picture, since all methods see the same ones.",
    )


@figure(
    "ext_coded_grid",
    needs=("ext_coded_grid_runs", "ext_coded_grid_picture"),
    evidence="rendered",
)
def ext_coded_grid(results):
    """A picture with its block's numbers, and outcomes by picture."""
    drawn, panels = new_figure(1, 2, height_in=4.6, width_ratios=(1.15, 1))
    right, rows = _draw_block(panels[0], results["ext_coded_grid_picture"])
    rows += _draw_outcomes(panels[1], results["ext_coded_grid_runs"])
    legend_below(drawn, panels[1], ncols=3)
    return Drawing(
        drawn,
        columns(("panel", "what", "a", "b", "u_px", "v_px"), rows),
        "(a) A coded grid through a fisheye of 134° (the first of some "
        "pictures whose block was found): a block of 6 × 6 corners, and row "
        "and column on the grid of four of them. Circles: clicks. (b) What "
        "became of the blocks of all pictures: contrast of the marks, field "
        "of view, noise SD.",
        Check(right == "right", f"the block of (a) is {right}"),
    )


def _draw_block(panel, result):
    """Draw the first block that was found: what became of it, and rows of data."""
    picture, clicked, corners, numbers = (
        result.arrays(name)[0] for name in ("picture", "clicks", "corners", "numbers")
    )
    panel.imshow(picture, cmap="gray", vmin=0, vmax=255)
    panel.grid(visible=False)
    panel.plot(*clicked.T, "o", mfc="none", mec="#56b4e9", mew=1.8, ms=9)
    points = corners.reshape(-1, 2)
    panel.plot(*points.T, ".", color="#d55e00", ms=6)
    for i, j in ((0, 0), (0, -1), (-1, -1), (-1, 0)):
        away = corners[i, j] - points.mean(axis=0)
        panel.annotate(
            f"{numbers[i, j][0]}, {numbers[i, j][1]}",
            corners[i, j] + 26 * away / np.linalg.norm(away),
            color="white",
            fontsize=9,
            ha="center",
            va="center",
            bbox={"boxstyle": "round,pad=0.2", "fc": "#1b1f24"},
        )
    low = points.min(axis=0) - 2 * MARGIN_PX
    high = points.max(axis=0) + 2 * MARGIN_PX
    panel.set(
        xlim=(low[0], high[0]),
        ylim=(high[1], low[1]),
        title="(a) a block and its place",
        xlabel="u (px)",
        ylabel="v (px)",
    )
    located = ("right", "a corner off", "wrong place")
    found = [o for o in result.texts("outcome") if o in located]
    places = zip(numbers.reshape(-1, 2), points, strict=True)
    return found[0], [("a", "corner", *number, *point) for number, point in places]


def _draw_outcomes(panel, result):
    """Draw the outcomes as bars; returns rows of data."""
    names, found = zip(*by_picture(result).items(), strict=True)
    shares = 100 * np.array([counts(of) for of in found]) / result.trials_per_condition
    left, places, rows = np.zeros(len(names)), np.arange(len(names)), []
    for number, outcome in enumerate(OUTCOMES):
        panel.barh(
            places,
            shares[:, number],
            left=left,
            color=COLOURS[number],
            hatch=HATCHES[number],
            edgecolor="#4a4a4a",
            linewidth=0.5,
            label=outcome,
        )
        left += shares[:, number]
        rows += [
            ("b", f"{name}: {outcome} (%)", share, *[np.nan] * 3)
            for name, share in zip(names, shares[:, number], strict=True)
        ]
    panel.set_yticks(places)
    panel.yaxis.set_major_formatter(FixedFormatter(names))
    panel.invert_yaxis()
    panel.set(xlim=(0, 100), title="(b) outcomes", xlabel="Blocks (%)")
    return rows
