"""Legends of the figure of a decoded grid, and the sheet of patterns."""

from types import SimpleNamespace

import numpy as np

from raxel.report.canvas import Canvas
from raxel.report.images import GAP, LABEL, THUMBNAIL, _deviations, pattern_sheet
from raxel.sets import pattern_image, patterns_of, plan_of_cells


def legend_text(monkeypatch, sigma):
    """The words of the legend."""
    monkeypatch.setattr(Canvas, "with_legend", lambda _, entries: entries)
    decoded = SimpleNamespace(sigma=sigma, unit="mm")
    return [words for _, words in _deviations(decoded, np.zeros(sigma.shape[:2]))]


def test_standard_deviation_is_rms_of_both_axes(monkeypatch):
    sigma = np.full((20, 30, 2), [0.1, 0.7])
    assert legend_text(monkeypatch, sigma)[0] == "standard deviation 0.5 mm"
    # Of a monitor of which one axis was shown alone, it is that axis's own.
    sigma[..., 1] = np.nan
    assert legend_text(monkeypatch, sigma)[0] == "standard deviation 0.1 mm"


def test_thumbnails_are_in_the_order_of_patterns():
    size = 2 * THUMBNAIL, THUMBNAIL
    patterns = patterns_of(plan_of_cells(size, 8, 4))
    sheet = pattern_sheet(patterns, size)
    along = [p for p in patterns if (p.kind, p.axis) == ("phase", "x")]
    rows = list(dict.fromkeys((p.kind, p.axis) for p in patterns))
    high = THUMBNAIL // 2
    top = GAP + rows.index(("phase", "x")) * (high + LABEL + GAP)
    for k, pattern in enumerate(along):
        left = GAP + k * (THUMBNAIL + GAP)
        shown = sheet[top : top + high, left : left + THUMBNAIL, 0].astype(float)
        full = pattern_image(pattern, size).astype(float)
        small = full.reshape(high, 2, THUMBNAIL, 2).mean(axis=(1, 3))
        np.testing.assert_allclose(shown, small, atol=1)
