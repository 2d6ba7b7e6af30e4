"""A video on a page: it contains all frames and requires one label per frame."""

import base64
import io
import json
import re

import numpy as np
import pytest
from PIL import Image

from repro.page import film, style
from repro.page.film import film_page, pictured
from repro.run.outcomes import Film, Panel

GREYS = (0, 120, 250)


def made(labels=("a", "b <i>", "c")):
    frames = [np.full((6, 8, 3), grey, np.uint8) for grey in GREYS]
    return Film([Panel("One", "Gets lighter.", frames)], labels)


def test_video_page_has_frames_and_labels():
    page = film_page(made(), "Film & title")
    assert "<title>Film &amp; title</title>" in page
    found = re.search(r'id="words">(.*?)</script>', page, re.S)[1]
    words = json.loads(found)
    assert words["labels"] == ["a", "b <i>", "c"]
    assert "<i>" not in found
    for address, grey in zip(words["frames"][0], GREYS, strict=True):
        data = base64.b64decode(address.removeprefix("data:image/webp;base64,"))
        shown = np.asarray(Image.open(io.BytesIO(data)).convert("RGB"))
        assert shown.shape == (6, 8, 3)
        assert np.abs(shown.astype(int) - grey).max() <= 3
    # Paper and a browser without scripts have the first frame.
    assert f'<img src="{words["frames"][0][0]}"' in page
    assert 'alt="Gets lighter."' in page
    assert page == film_page(made(), "Film & title")


def test_slider_embeds_vector_figures():
    def drawn(x):
        figure, axes = style.new_figure(height_in=1.0)
        axes.plot([0, x], [0, 1])
        axes.set(xlabel="Place (mm)", ylabel="Share (%)")
        return figure

    slider = Film([Panel("", "A line.", [drawn(1), drawn(2)])], ("1 mm", "2 mm"), 0)
    page = film_page(slider, "Slider")
    words = json.loads(re.search(r'id="words">(.*?)</script>', page, re.S)[1])
    assert words["perSecond"] == 0
    for frame, x in zip(words["frames"][0], (1, 2), strict=True):
        svg = base64.b64decode(frame.removeprefix("data:image/svg+xml;base64,"))
        assert b"<svg" in svg
        assert (
            frame
            == film_page(Film([Panel("", "", [drawn(x)])], ("",), 0), "")
            .partition('img src="')[2]
            .partition('"')[0]
        )
    assert len(set(words["frames"][0])) == 2
    assert 'class="lines"' in page
    assert "<figcaption>" not in page
    assert not re.search(r'(?:src|href)="(?!data:)|url\(|import |fetch\(', page)


def test_video_rejects_unequal_counts_and_large_pages(monkeypatch):
    with pytest.raises(ValueError, match=r"\[2, 3\] frames and labels"):
        film_page(made(labels=("a", "b")), "")
    monkeypatch.setattr(film, "MAX_BYTES", 1000)
    with pytest.raises(ValueError, match="1000 at most"):
        film_page(made(), "")


def test_figure_becomes_frame():
    drawn, axes = style.new_figure(height_in=1.0)
    axes.set(xlabel="Place (mm)", ylabel="Place (mm)")
    image = pictured(drawn, 50)
    assert image.shape == (50, round(50 * style.WIDTH_IN), 3)
    assert image.min() < 100 < image.max() == 255
