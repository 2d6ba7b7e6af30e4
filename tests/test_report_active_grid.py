"""What the picture of a decoded pose says of its locations."""

from types import SimpleNamespace

import numpy as np

from raxel.report.active_grid import _deviations
from raxel.report.canvas import Canvas


def told(monkeypatch, sigma):
    """The words of the legend."""
    monkeypatch.setattr(Canvas, "with_legend", lambda _, entries: entries)
    decoded = SimpleNamespace(sigma=sigma, unit="mm")
    return [words for _, words in _deviations(decoded, np.zeros(sigma.shape[:2]))]


def test_the_standard_deviation_is_the_root_mean_square_of_both_axes(monkeypatch):
    sigma = np.full((20, 30, 2), [0.1, 0.7])
    assert told(monkeypatch, sigma)[0] == "standard deviation 0.5 mm"
    # Of a monitor of which one axis was shown alone, it is that axis's own.
    sigma[..., 1] = np.nan
    assert told(monkeypatch, sigma)[0] == "standard deviation 0.1 mm"
