"""Tables and figures of the further stages of CELECT (6.3.1)."""

from __future__ import annotations

import numpy as np
from matplotlib.ticker import FixedFormatter

from chapters.ch03_planar_grids.ext_corner_detection.trials.further import (
    METHODS,
    OTHERS,
    PUBLISHED,
    comparisons,
    successes,
)
from repro.page.style import figure as new_figure
from repro.page.style import series
from repro.run.experiment import figure, table
from repro.run.outcomes import Check, Drawing, Table

SIGNIFICANT = 0.05
# How much of the picture the figure of split corners shows, around a corner.
HALF_PX = 34
SHOWN = (2, 5, 8)


@table(
    "ext_further_ideas",
    needs=("ext_further_ideas_runs",),
    evidence="synthetic",
)
def ext_further_ideas(results):
    """Share of pictures in which every corner is right, method by method."""
    result = results["ext_further_ideas_runs"]
    compared = comparisons(result)
    pictures = [c["picture"] for c in result.conditions]
    columns = {
        "picture": pictures,
        "published (%)": [
            f"{100 * successes(result, p, PUBLISHED).mean():.0f}"
            for p in pictures
        ],
    }
    for method in OTHERS:
        columns[f"{method} (%)"] = [
            _cell(compared[picture, method]) for picture in pictures
        ]
    consistent = all(
        np.isclose(
            v["after"] - v["before"],
            (v["gained"] - v["lost"]) / result.trials_per_condition,
        )
        for v in compared.values()
    )
    return Table(
        columns,
        "Pictures in which every corner is found within 8 px, "
        f"{result.trials_per_condition} of each kind. In brackets: pictures "
        "gained and lost against the published stages. *: p < 0.05 by "
        "McNemar's exact test, corrected over the table (Holm).",
        Check(
            consistent,
            "shares differ by just the pictures gained and lost",
        ),
    )


def _cell(values):
    star = " *" if values["p"] < SIGNIFICANT else ""
    return (
        f"{100 * values['after']:.0f} "
        f"(+{values['gained']} −{values['lost']}){star}"
    )


@table(
    "ext_further_errors",
    needs=("ext_further_ideas_runs",),
    evidence="synthetic",
)
def ext_further_errors(results):
    """Errors before localisation and candidates, where both succeed."""
    result = results["ext_further_ideas_runs"]
    rows = []
    for condition in result.conditions:
        picture = condition["picture"]
        for method in METHODS:
            rows.append(
                (picture, method, *_errors(result, picture, method))
            )
    heads = (
        "picture",
        "method",
        "mean error (px)",
        "published, same trials (px)",
        "largest error (px)",
        "candidates per corner",
    )
    candidates = np.array([row[5] for row in rows], float)
    least = float(np.nanmin(candidates)) if len(candidates) else np.nan
    cells = [
        [_text(value) for value in column]
        for column in zip(*rows, strict=True)
    ]
    return Table(
        dict(zip(heads, cells, strict=True)),
        "Corners before localisation. Errors: median over trials of the "
        "mean, and largest of all corners, in the trials in which both the "
        "method and the published stages succeed. Candidates: detected "
        "along a contour, for every corner on it, in all trials (median).",
        Check(least > 0, f"at least {least:.2g} candidates per corner"),
    )


def _errors(result, picture, method):
    """(mean, the published mean, largest, candidates per corner)."""
    both = successes(result, picture, method)
    both = both & successes(result, picture, PUBLISHED)
    candidates = result.column(f"{method}.candidates", picture=picture)
    seen = candidates[np.isfinite(candidates)]
    per_corner = float(np.median(seen)) if len(seen) else np.nan
    if not both.any():
        return np.nan, np.nan, np.nan, per_corner
    mean, before, largest = (
        result.column(name, picture=picture)[both]
        for name in (
            f"{method}.mean_px",
            f"{PUBLISHED}.mean_px",
            f"{method}.max_px",
        )
    )
    middle = float(np.median(mean)), float(np.median(before))
    return *middle, float(largest.max()), per_corner


def _text(value):
    if isinstance(value, str):
        return value
    return "" if np.isnan(value) else f"{value:.2f}"


@figure(
    "ext_further_changes",
    needs=("ext_further_ideas_runs",),
    evidence="synthetic",
)
def ext_further_changes(results):
    """Change of the share of successes, with its interval, by picture."""
    result = results["ext_further_ideas_runs"]
    compared = comparisons(result)
    pictures = [c["picture"] for c in result.conditions]
    drawn, axes = new_figure(height_in=0.62 * len(pictures) + 1.4)
    data = {k: [] for k in ("picture", "method", "change", "low", "high")}
    rows = np.arange(len(pictures), dtype=float)
    for index, method in enumerate(OTHERS):
        found = [compared[picture, method] for picture in pictures]
        change = 100 * np.array([v["after"] - v["before"] for v in found])
        low, high = (
            100 * np.array([v[end] for v in found])
            for end in ("low", "high")
        )
        look = dict(series(index), linestyle="none")
        axes.errorbar(
            change,
            rows + 0.18 * (index - 1.5),
            xerr=np.maximum([change - low, high - change], 0),
            label=method,
            capsize=2,
            **look,
        )
        for cells in zip(pictures, change, low, high, strict=True):
            picture, *numbers = cells
            for column, cell in zip(
                data, (picture, method, *numbers), strict=True
            ):
                data[column].append(cell)
    axes.axvline(0, color="#4a4a4a", linewidth=1)
    labels = [
        f"{p}\n(published: {100 * successes(result, p, PUBLISHED).mean():.0f} %)"
        for p in pictures
    ]
    axes.set_yticks(rows)
    axes.yaxis.set_major_formatter(FixedFormatter(labels))
    axes.invert_yaxis()
    axes.set_xlabel("Change of successful pictures (percentage points)")
    drawn.legend(loc="outside lower center", ncols=4)
    return Drawing(
        drawn,
        data,
        "Further stages against the published ones: change of the share of "
        "pictures with every corner right. Bars: 95 % intervals, resampled "
        "by picture, since all methods see the same ones.",
    )


@figure(
    "ext_split_corners",
    needs=("ext_split_corners_runs",),
    evidence="synthetic",
)
def ext_split_corners(results):
    """Candidates at three corners of a blurred contour, by either detector."""
    result = results["ext_split_corners_runs"]
    (picture,) = result.arrays("picture")
    (corners,) = result.arrays("corners")
    drawn, panels = new_figure(2, len(SHOWN), height_in=5.4)
    data = {k: [] for k in ("detector", "corner", "kind", "u_px", "v_px")}
    counts = {}
    for row, name in enumerate((PUBLISHED, "symmetry")):
        (inliers,) = result.arrays(f"{name}.inliers")
        counts[name] = len(inliers)
        for panel, number in zip(panels[row], SHOWN, strict=True):
            _draw_corner(panel, picture, corners[number], inliers)
            panel.set_title(f"{name}, corner {number + 1}")
            panel.set_xlabel("u (px)")
            near = np.abs(inliers - corners[number]).max(axis=1) < HALF_PX
            points = [("truth", corners[number])]
            points += [("candidate", p) for p in inliers[near]]
            for kind, (u, v) in points:
                cells = (name, number + 1, kind, u, v)
                for column, cell in zip(data, cells, strict=True):
                    data[column].append(cell)
    drawn.supylabel("v (px)", fontsize=10)
    handles, labels = panels[0, 0].get_legend_handles_labels()
    drawn.legend(handles, labels, loc="outside lower center", ncols=2)
    return Drawing(
        drawn,
        data,
        "Three corners of the first side under a blur of 5 px. The side has "
        f"{counts[PUBLISHED]} candidates of the published detector (above) "
        f"and {counts['symmetry']} of the symmetric one (below).",
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
    panel.set_xlim(u - HALF_PX, u + HALF_PX)
    panel.set_ylim(v + HALF_PX, v - HALF_PX)
    panel.grid(visible=False)
