"""Words about a set of photographs: its title, its origin, and what is not shown."""

import re
import textwrap

from repro.page import literal

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


def title(study):
    """The set's name, and what the camera is, up to the first comma."""
    camera = literal(re.split(r"[,;:(]", study.settings["camera"])[0])
    name = literal(study.settings["set"])
    return f"{name}: {camera}" if camera else name


def origin(study):
    """Where the photographs come from, as set.yaml tells it."""
    source, licence = (literal(study.settings[k]) for k in ("source", "licence"))
    if not source:
        return "The set does not say where its photographs come from."
    licence = f" Licence: {licence}." if licence else ""
    return f"The photographs come from: {source}.{licence}"
