"""A few words where a figure has nothing to show."""

from __future__ import annotations

import textwrap

EMPTY_IN = 1.3  # height of a figure that has only words to show


def note(axes, text, width=34):
    """Words in the place of a picture that cannot be drawn."""
    axes.set_axis_off()
    axes.text(
        0.5,
        0.5,
        textwrap.fill(text, width),
        ha="center",
        va="center",
        fontsize=9,
        transform=axes.transAxes,
        parse_math=False,
    )
