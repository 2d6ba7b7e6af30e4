"""A video on a page: panels of frames that a reader plays, stops and steps through.

With 0 frames per second it is a slider without a play button. A frame is an image or a
figure. A figure is stored as vectors, whose light and dark colours are exchanged on a
dark page; a figure that contains images must be rasterised by `pictured`. The page
loads nothing and works from the disk. The video starts when it is opened, or, if the
browser requests reduced motion, when the button is pressed.
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
MAX_BYTES = 1_500_000


def film_page(film: Film, title: str) -> str:
    """Return the page of a video; ``title`` describes it in words.

    The same video gives the same page. Raises ValueError for panels of different length
    and for a page of more than MAX_BYTES.
    """
    counts = {len(film.labels), *(len(panel.pictures) for panel in film.panels)}
    if len(counts) != 1:
        raise ValueError(
            f"film: found {sorted(counts)} frames and labels; give equal numbers"
        )
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
    if size > MAX_BYTES:
        raise ValueError(
            f"film: {size} bytes, {MAX_BYTES} at most; give fewer or smaller frames"
        )
    return page


def pictured(drawn: Figure, dpi: int) -> np.ndarray:
    """Return a figure as an image, (height, width, 3) uint8."""
    canvas = FigureCanvasAgg(drawn)
    drawn.set_dpi(dpi)
    canvas.draw()
    return np.array(canvas.buffer_rgba())[..., :3]


def _address(frame: np.ndarray | Figure) -> str:
    """A frame as a data URL."""
    buffer, kind = BytesIO(), "webp"
    if isinstance(frame, Figure):
        kind, undated = "svg+xml", dict.fromkeys(("Creator", "Date"))
        frame.savefig(buffer, format="svg", metadata=undated)
    else:
        Image.fromarray(frame).save(buffer, "WEBP", quality=QUALITY, method=6)
    return f"data:image/{kind};base64,{base64.b64encode(buffer.getvalue()).decode()}"
