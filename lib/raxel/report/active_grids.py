"""Figures of active grids: the sheet of patterns, and the decoded positions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from raxel.features.active_grid import REASONS
from raxel.features.active_grid.coding import (
    ALONE,
    BORDER,
    BREAK,
    DARK,
    DECODED,
    FILLED,
    OUTSIDE,
    SATURATED,
    UNREADABLE,
)
from raxel.report.figures import (
    DPI,
    QUIET,
    WIDTH_IN,
    image_figure,
    show_array,
    show_image,
)
from raxel.sets.patterns import Pattern, pattern_image

N_SHOWN = 960  # positions along the width of a figure
N_LINES = 16  # intervals of the contour lines on the lit area, along each axis
LINE_COLOURS = "#e62828", "#00963c"
STATUS_COLOURS = {
    FILLED: "#f0c828", DARK: "#3c3c46", SATURATED: "#dc3c3c", UNREADABLE: "#c83cc8",
    ALONE: "#ff7800", OUTSIDE: "#3caab4", BORDER: "#aaaaaa", BREAK: "#5ac85a",
}  # fmt: skip


def pattern_sheet(patterns: Sequence[Pattern], monitor_px: tuple[int, int]) -> Figure:
    """Return labelled thumbnails, one row for each kind and axis (Fig. 3.8)."""
    rows: dict[Any, list[tuple[np.ndarray, str]]] = {}
    for pattern in patterns:
        shown = pattern_image(pattern, monitor_px), _label(pattern)
        rows.setdefault((pattern.kind, pattern.axis), []).append(shown)
    plain = np.zeros_like(shown[0])
    rows["levels"] = [(plain + np.uint8(255), "white"), (plain, "black")]
    n_columns = max(map(len, rows.values()))
    width = WIDTH_IN * n_columns / 4
    high = width / n_columns * monitor_px[1] / monitor_px[0] + 0.3
    layout: Any = "none"
    figure = Figure((width, len(rows) * high), dpi=DPI, layout=layout)
    cells = figure.subplots(len(rows), n_columns, squeeze=False)
    for axes, row in zip(cells, rows.values(), strict=True):
        for each in axes:
            each.set_axis_off()
        for each, (image, text) in zip(axes, row, strict=False):
            each.set(xlim=(0, monitor_px[0]), ylim=(monitor_px[1], 0))
            show_image(each, image)
            each.set_title(text, fontsize=8, loc="center")
    figure.subplots_adjust(0.01, 0.01, 0.99, 0.97, wspace=0.05, hspace=0.15)
    return figure


def _label(pattern):
    if pattern.kind == "phase":
        return f"{pattern.axis}: sine, step {pattern.step} of {pattern.of}"
    inverse = ", inverse" if pattern.inverse else ""
    return f"{pattern.axis}: bit {pattern.bit} of {pattern.of}{inverse}"


def decoded_figure(decoded: Any, image: np.ndarray, extent: Sequence[float]) -> Figure:
    """Return decoded positions over an image (H, W) uint8, above their uncertainty.

    Parameters
    ----------
    decoded : Decoded
        Positions (H, W, 2), their standard deviation and status.
    image : ndarray, shape (H, W), uint8
        The white image.
    extent : sequence of 2 float
        Size of the lit area in the unit of the positions.

    Returns
    -------
    Figure
        Top: contour lines of x and of y on the monitor, and pixels without a position,
        by reason. Bottom: RMS over the axes of the standard deviation.
    """
    height, width = image.shape
    step = np.s_[:: max(1, width // N_SHOWN), :: max(1, width // N_SHOWN)]
    figure, (top, bottom) = image_figure(width, height, rows=2)
    show_image(top, image, 0.75)
    counts = np.array([np.count_nonzero(decoded.status == k) for k in REASONS])
    keys = [Patch(facecolor="white", label=f"decoded: {share(counts, DECODED)}")]
    for status, colour in STATUS_COLOURS.items():
        if counts[status]:
            there = np.where(decoded.status[step] == status, 1.0, np.nan)
            show_array(
                top, there, width, height, cmap=ListedColormap([colour]), alpha=0.6
            )
            text = f"{REASONS[status]}: {share(counts, status)}"
            keys.append(Patch(facecolor=colour, label=text))
    v, u = (np.arange(n)[s] for n, s in zip(image.shape, step, strict=True))
    for axis, colour in enumerate(LINE_COLOURS):
        position = decoded.location[..., axis][step]
        if np.isfinite(position).any():
            interval = extent[axis] / N_LINES
            levels = interval * np.arange(1, N_LINES)
            top.contour(u, v, position, levels, colors=colour, linewidths=0.8)
            text = f"{'xy'[axis]}, every {interval:.3g} {decoded.unit}"
            keys.append(Patch(facecolor=colour, label=text))
    top.legend(handles=keys, fontsize=7, ncols=2, loc="lower left")
    _show_deviations(figure, bottom, decoded, step, width, height)
    return figure


def _show_deviations(figure, axes, decoded, step, width, height):
    sigma = decoded.sigma[..., np.isfinite(decoded.sigma).any(axis=(0, 1))][step]
    if not sigma.shape[2]:
        return
    sigma = np.sqrt(np.mean(sigma**2, axis=2))
    low, high = np.nanquantile(sigma, (0.02, 0.98))
    axes.set_facecolor(QUIET)
    shown = show_array(axes, sigma, width, height, vmin=low, vmax=max(high, 1.01 * low))
    bar = {"label": f"standard deviation ({decoded.unit})", "extend": "both"}
    figure.colorbar(shown, ax=axes, pad=0.01, shrink=0.6, **bar)


def share(counts: np.ndarray, status: int) -> str:
    """Return the share of pixels with a status as text; their number if it is tiny."""
    percent = 100 * counts[status] / counts.sum()
    return f"{percent:.1f} %" if percent >= 0.05 else f"{counts[status]} px"
