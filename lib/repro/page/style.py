"""One look for every figure of the report, and files with the same bytes every time.

Figures are as wide as the text of a page. Text is drawn as outlines, so a figure looks
the same on a machine without the font. The CSV file contains the numbers. Series differ
in colour, marker and line style: they can be distinguished in grey and by colour-blind
readers. The background is opaque and light. On a dark page the site inverts a figure
that is `only_lines`, and shows images unchanged.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from cycler import cycler

from repro.judge.statistics import Estimate
from repro.page.method_looks import check_looks
from repro.run.as_columns import csv_text
from repro.run.outcomes import Drawing
from repro.run.results import write_atomic

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.transforms import Bbox

WIDTH_IN = 7.2
"""Width of the text column of a page, in inches of 96 CSS pixels."""

PNG_DPI = 200

MARGIN_IN = 0.1
"""White margin around the drawing, in inches."""

INK = "#1b1f24"
FAINT = "#d5d9de"

SERIES = (
    {"color": "#0072b2", "marker": "o", "linestyle": "-"},
    {"color": "#d55e00", "marker": "s", "linestyle": "--"},
    {"color": "#009e73", "marker": "^", "linestyle": "-."},
    {"color": "#c76ea3", "marker": "D", "linestyle": ":"},
    {"color": "#56b4e9", "marker": "v", "linestyle": (0, (7, 2))},
    {"color": "#e69f00", "marker": "P", "linestyle": (0, (3, 1, 1, 1, 1, 1))},
    {"color": "#4a4a4a", "marker": "X", "linestyle": (0, (1, 3))},
)
"""Colour (after Okabe and Ito), marker and line style of series 0, 1, 2, ..."""

RC = {
    "font.family": "DejaVu Sans",
    "font.size": 10,
    "axes.labelsize": 10,
    "axes.titlesize": 10.5,
    "axes.titlelocation": "left",
    "axes.titleweight": "bold",
    "xtick.labelsize": 9,
    "ytick.labelsize": 9,
    "legend.fontsize": 9,
    "mathtext.fontset": "dejavusans",
    "text.color": INK,
    "axes.labelcolor": INK,
    "axes.edgecolor": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "axes.linewidth": 0.8,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": FAINT,
    "grid.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.prop_cycle": cycler(
        **{key: [s[key] for s in SERIES] for key in ("color", "marker", "linestyle")}
    ),
    "lines.linewidth": 1.6,
    "lines.markersize": 5,
    "legend.frameon": True,
    "legend.framealpha": 1.0,
    "legend.edgecolor": FAINT,
    "legend.handlelength": 3.2,
    "image.cmap": "cividis",
    "image.interpolation": "nearest",
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    "figure.constrained_layout.use": True,
    "svg.fonttype": "path",
    "svg.hashsalt": "raxel",
    "path.simplify": True,
}

PLACED = RC | {"figure.constrained_layout.use": False}
"""Layout of a figure whose axes have fixed positions."""

_UNIT = re.compile(r"\([^()]+\)\s*$")
_MISPLACED = re.compile(r"\b(px|mm|µm|deg|ms)\b|[%°]")


class StyleError(ValueError):
    """A figure that violates the style; the message names figure and axis."""


def new_figure(
    rows: int = 1,
    columns: int = 1,
    *,
    height_in: float | None = None,
    **subplots: object,
) -> tuple[Figure, Axes | np.ndarray]:
    """Return a figure as wide as the page, with its axes, in the style of the report.

    Parameters
    ----------
    rows, columns : layout of the axes.
    height_in : height in inches; by default 3 per row.
    subplots : passed on to ``Figure.subplots`` (``sharex``, ``width_ratios``, ...).

    Returns
    -------
    (figure, axes), axes as ``Figure.subplots`` gives them.

    The style is set for the process, because labels added later use it too.
    """
    from matplotlib import rcParams
    from matplotlib.figure import Figure

    rcParams.update(RC)
    drawn = Figure(figsize=(WIDTH_IN, 3.0 * rows if height_in is None else height_in))
    return drawn, drawn.subplots(rows, columns, **subplots)


def series(index: int) -> dict:
    """Return colour, marker and line style of a series, as keyword arguments of
    ``plot``."""
    return dict(SERIES[index % len(SERIES)])


def plot_interval(
    axes: Axes,
    x: np.ndarray,
    middle: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    *,
    look: Mapping,
    label: str,
    bars: bool = False,
) -> None:
    """Draw one series with its interval: a band, or bars where x is not continuous.

    Parameters
    ----------
    x, middle, low, high : (N,) arrays in the units of the axes; ``nan`` leaves a gap.
    look : colour, marker and line style: of `series`, or of a method
        (`repro.page.method_looks.look_of`).
    label : legend entry; describes the interval once per figure.
    """
    if bars:
        lengths = np.array([middle - low, high - middle])
        axes.errorbar(x, middle, yerr=lengths, label=label, capsize=3, **look)
        return
    axes.plot(x, middle, label=label, **look)
    axes.fill_between(x, low, high, color=look["color"], alpha=0.18, linewidth=0)


def plot_estimates(
    axes: Axes,
    x: Sequence[float],
    found: Sequence[Estimate],
    series_of: Sequence = (),
    **drawn_as: object,
) -> list[tuple]:
    """Draw estimates along x as one series, see `plot_interval`.

    Returns its rows for the figure's data: ``series_of``, the name of the series, then
    x, value, ends of the interval.
    """
    rows = [(at, *estimate[:3]) for at, estimate in zip(x, found, strict=True)]
    plot_interval(axes, *np.array(rows, float).T, **drawn_as)
    return [(*series_of, *row) for row in rows]


def legend_below(drawn: Figure, axes: Axes, ncols: int) -> None:
    """Draw one legend for all axes of a figure, that of ``axes``, below them."""
    handles, labels = axes.get_legend_handles_labels()
    drawn.legend(handles, labels, loc="outside lower center", ncols=ncols)


def check_axes(drawn: Figure, name: str) -> None:
    """Raise `StyleError` unless every axis with numbers names its quantity and unit.

    The unit is in parentheses at the end of the label: "Noise (px)", "Share (%)". A
    pure number has none: "Stage". Axes without ticks, switched-off axes and axes of
    named categories need no label. Inner axes of shared rows and columns may leave it
    to the outer ones.
    """
    for number, axes in enumerate(drawn.axes, 1):
        for letter in _numeric_axes(axes):
            label = _label(drawn, axes, letter)
            bare = not _UNIT.search(label) and _MISPLACED.search(label)
            if not label or bare or "(1)" in label:
                raise StyleError(
                    f"{name}: {letter} axis of axes {number}: label {label!r} needs "
                    "a quantity, and its unit in parentheses at the end"
                )


def _numeric_axes(axes: Axes) -> Iterator[str]:
    from matplotlib.category import StrCategoryFormatter
    from matplotlib.ticker import FixedFormatter

    if not axes.axison:
        return
    for letter in ("x", "y", "z"):
        axis = getattr(axes, f"{letter}axis", None)
        if axis is None or not axis.get_visible() or not len(axis.get_ticklocs()):
            continue
        formatter = axis.get_major_formatter()
        words = isinstance(formatter, FixedFormatter) and any(
            any(c.isalpha() for c in text) for text in formatter.seq
        )
        if not words and not isinstance(formatter, StrCategoryFormatter):
            yield letter


def _label(drawn: Figure, axes: Axes, letter: str) -> str:
    together = [axes]
    if letter in "xy":
        together += getattr(axes, f"get_shared_{letter}_axes")().get_siblings(axes)
    labels = [getattr(other, f"get_{letter}label")() for other in together]
    whole = {"x": drawn.get_supxlabel(), "y": drawn.get_supylabel()}.get(letter, "")
    return next((text for text in (*labels, whole) if text), "")


def save_drawing(drawing: Drawing, stem: Path) -> None:
    """Write ``stem.svg``, ``stem.png`` and ``stem.csv``, each completely or not at all.

    Raises `StyleError` if an axis lacks its unit, and `LookError` if a method has
    another look than in other figures. The bytes depend on the drawing and the
    installed versions only: no date, no random ids.
    """
    from matplotlib import rc_context

    check_axes(drawing.figure, stem.name)
    check_looks(drawing.figure, stem.name)
    with rc_context(RC):
        kept = _laid_out(drawing.figure)
    with rc_context(PLACED):
        drawing.figure.set_layout_engine(None)
        described = {"Date": None, "Creator": None, "Title": stem.name}
        svg = _rendered(drawing.figure, kept, "svg", described)
        png = _rendered(drawing.figure, kept, "png", {"Software": None})
    table = csv_text(drawing.data)
    for ending, content in (("csv", table), ("png", png), ("svg", svg)):
        write_atomic(stem.with_name(f"{stem.name}.{ending}"), content)


def only_lines(drawn: Figure) -> bool:
    """Return whether a figure contains no image.

    Such a figure can be inverted for a dark page; an image would become a negative.
    """
    return not drawn.images and not any(axes.images for axes in drawn.axes)


def _laid_out(drawn: Figure) -> Bbox:
    """Compute the layout once, for both files; return the bounding box, in inches.

    Otherwise matplotlib would repeat the layout and the drawing for each file.
    """
    drawn.set_dpi(PNG_DPI)
    if drawn.axes and (engine := drawn.get_layout_engine()):
        engine.execute(drawn)
    return drawn.get_tightbbox().padded(MARGIN_IN)


def _rendered(drawn: Figure, kept: Bbox, kind: str, metadata: dict) -> bytes:
    buffer = BytesIO()
    drawn.savefig(buffer, format=kind, dpi=PNG_DPI, metadata=metadata, bbox_inches=kept)
    return buffer.getvalue()
