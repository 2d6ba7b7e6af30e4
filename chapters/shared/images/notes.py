"""Words about an image set: its title, its origin, and what is not shown."""

import re
import textwrap

from repro.page import literal

EMPTY_IN = 1.3  # height of a figure without an image


def note(axes, text, width=34, size=9):
    """Write a text in the place of an image that cannot be drawn."""
    axes.set_axis_off()
    axes.text(
        0.5, 0.5, textwrap.fill(text, width), ha="center", va="center", fontsize=size,
        transform=axes.transAxes, parse_math=False,
    )  # fmt: skip


def title(study):
    """Return the name of the set and of its camera, up to the first comma."""
    camera = literal(re.split(r"[,;:(]", study.settings["camera"])[0])
    name = literal(study.settings["set"])
    return f"{name}: {camera}" if camera else name


def origin(study):
    """Return the origin of the images, as stated in set.yaml."""
    source, licence = (literal(study.settings[k]) for k in ("source", "licence"))
    if not source:
        return "The set does not state the origin of its images."
    licence = f" Licence: {licence}." if licence else ""
    return f"Origin of the images: {source}.{licence}"
