"""Figures of active grids: the sheet of patterns, and decoded positions."""

from types import SimpleNamespace

import numpy as np
import pytest

from raxel.report.active_grids import (
    LINE_COLOURS,
    N_LINES,
    decoded_figure,
    pattern_sheet,
    share,
)
from raxel.sets import pattern_image, patterns_of, plan_of_cells


def decoded(sigma):
    """A decoded view: x along u, y constant, the first column dark."""
    v, u = np.mgrid[: sigma.shape[0], : sigma.shape[1]]
    location = np.stack([u * 32.0 / sigma.shape[1], 0 * v + 7.0], axis=-1)
    status = np.where(u == 0, 2, 0)
    return SimpleNamespace(location=location, sigma=sigma, status=status, unit="mm")


@pytest.mark.parametrize(("second", "rms"), [(0.7, 0.5), (np.nan, 0.1)])
def test_standard_deviation_is_rms_of_the_known_axes(second, rms):
    sigma = np.full((20, 30, 2), [0.1, second])
    figure = decoded_figure(decoded(sigma), np.zeros((20, 30), np.uint8), (32, 20))
    (shown,) = figure.axes[1].images
    np.testing.assert_allclose(shown.get_array(), rms)


def test_contour_lines_are_at_parts_of_the_lit_area():
    sigma = np.full((40, 64, 2), 0.1)
    figure = decoded_figure(decoded(sigma), np.zeros((40, 64), np.uint8), (32, 20))
    top = figure.axes[0]
    along_x, along_y = top.collections
    assert along_x.get_edgecolor()[0] == pytest.approx(
        [int(LINE_COLOURS[0][k : k + 2], 16) / 255 for k in (1, 3, 5)] + [1.0]
    )
    places = [path.vertices[:, 0].mean() for path in along_x.get_paths()]
    np.testing.assert_allclose(places, 64 / N_LINES * np.arange(1, N_LINES))
    assert not any(len(path.vertices) for path in along_y.get_paths())
    texts = [text.get_text() for text in top.get_legend().get_texts()]
    assert texts[0] == "decoded: 98.4 %"
    assert texts[1].endswith(": 1.6 %")
    assert len(top.images) == 2  # the image, and the pixels of one status


def test_thumbnails_are_in_the_order_of_patterns():
    size = 320, 160
    patterns = patterns_of(plan_of_cells(size, 8, 4))
    cells = iter(pattern_sheet(patterns, size).axes)
    shown = [cell for cell in cells if cell.images]
    for cell, pattern in zip(shown, patterns, strict=False):
        np.testing.assert_allclose(
            cell.images[0].get_array(), pattern_image(pattern, size)
        )
        assert cell.get_title().startswith(pattern.axis)
    assert [cell.get_title() for cell in shown[len(patterns) :]] == ["white", "black"]


def test_decoded_shares_are_of_all_pixels():
    counts = np.array([600, 300, 100, 0])
    assert [share(counts, k) for k in (1, 2)] == ["30.0 %", "10.0 %"]
    assert share(np.array([99999, 1]), 1) == "1 px"
