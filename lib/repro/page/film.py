"""A film on a page: frames side by side that a reader plays, stops and steps through.

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
            "height": panel.pictures[0].shape[0],
            "width": panel.pictures[0].shape[1],
            "frames": [_address(picture) for picture in panel.pictures],
        }
        for panel in film.panels
    ]
    words = {
        "frames": [panel["frames"] for panel in panels],
        "labels": list(film.labels),
        "perSecond": film.per_second,
    }
    page = render(
        "film",
        title=title,
        panels=panels,
        last=len(film.labels) - 1,
        first=film.labels[0],
        words=json.dumps(words).replace("<", "\\u003c"),
    )
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


def _address(picture: np.ndarray) -> str:
    """A picture as an address that holds it."""
    from PIL import Image

    buffer = BytesIO()
    Image.fromarray(picture).save(buffer, "WEBP", quality=QUALITY, method=6)
    return "data:image/webp;base64," + base64.b64encode(buffer.getvalue()).decode()
