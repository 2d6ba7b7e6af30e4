"""Parts of a page: cells, figures, exercises, and their execution.

Chapters import from here the functions of display cells and the style of figures.
"""

from repro.page.exercise import check
from repro.page.method_looks import look_of
from repro.page.reader import (
    Missing,
    Shown,
    checkout,
    compared,
    names_on_page,
    open_results,
    pipe_table,
    results_behind,
    scoreboard,
    seconds,
    show,
    show_code,
    show_part,
    show_table,
    value,
    values,
)
from repro.page.style import (
    FAINT,
    INK,
    WIDTH_IN,
    legend_below,
    new_figure,
    plot_estimates,
    plot_interval,
    series,
)
from repro.page.wording import literal, rounded

__all__ = [
    "FAINT",
    "INK",
    "WIDTH_IN",
    "Missing",
    "Shown",
    "check",
    "checkout",
    "compared",
    "legend_below",
    "literal",
    "look_of",
    "names_on_page",
    "new_figure",
    "open_results",
    "pipe_table",
    "plot_estimates",
    "plot_interval",
    "results_behind",
    "rounded",
    "scoreboard",
    "seconds",
    "series",
    "show",
    "show_code",
    "show_part",
    "show_table",
    "value",
    "values",
]
