"""A film on a page: frames side by side that a reader plays, stops and steps through.

With no frames per second it is a slider over them, without a button to play it. A frame
is an image or a figure. A figure is kept as lines, whose light and dark change places
on a dark page: one that contains images is a frame as `pictured`.
The page loads nothing and works from the disk. Nothing moves before a reader opened it,
and for one who asked the browser for less motion nothing before the button is pressed.
"""

from __future__ import annotations

import base64
import json
from io import BytesIO

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from repro.page.templates import render
from repro.run.outcomes import Film

QUALITY = 58
LARGEST_BYTES = 1_500_000


def film_page(film: Film, title: str) -> str:
    """The page of a film; ``title`` says in words what it shows.

    The same film gives the same page. Raises ValueError for panels of different length
    and for a page of more than LARGEST_BYTES.
    """
    counts = {len(film.labels), *(len(panel.pictures) for panel in film.panels)}
    if len(counts) != 1:
        raise ValueError(f"film: found {sorted(counts)} frames and labels, not as many")
    panels = [
        {
            "title": panel.title,
            "says": panel.says,
            "lines": isinstance(panel.pictures[0], Figure),
            "frames": [_address(picture) for picture in panel.pictures],
        }
        for panel in film.panels
    ]
    words = {
        "frames": [panel["frames"] for panel in panels],
        "labels": list(film.labels),
        "perSecond": film.per_second,
    }
    shown = json.dumps(words).replace("<", "\\u003c")
    page = render("film", title=title, panels=panels, labels=film.labels, words=shown)
    size = len(page.encode())
    if size > LARGEST_BYTES:
        raise ValueError(
            f"film of {size} bytes, {LARGEST_BYTES} at most; give it fewer or smaller "
            "frames"
        )
    return page


def pictured(drawn: Figure, dpi: int) -> np.ndarray:
    """What a figure shows, (height, width, 3) uint8."""
    canvas = FigureCanvasAgg(drawn)
    drawn.set_dpi(dpi)
    canvas.draw()
    return np.array(canvas.buffer_rgba())[..., :3]


def _address(frame: np.ndarray | Figure) -> str:
    """A frame as an address that holds it."""
    buffer, kind = BytesIO(), "webp"
    if isinstance(frame, Figure):
        kind, undated = "svg+xml", dict.fromkeys(("Creator", "Date"))
        frame.savefig(buffer, format="svg", metadata=undated)
    else:
        Image.fromarray(frame).save(buffer, "WEBP", quality=QUALITY, method=6)
    return f"data:image/{kind};base64,{base64.b64encode(buffer.getvalue()).decode()}"
