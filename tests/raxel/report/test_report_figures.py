"""Figures and tables of a report: positions, colours and columns."""

import re
from types import SimpleNamespace

import numpy as np

from raxel.calibration.views.correspondence import BoardShape
from raxel.report import mirror
from raxel.report.figures import MISSING, grid_figure, image_figure
from raxel.report.page import html
from raxel.report.write import _arrows as arrows_of
from raxel.report.write import _predicted, _vote
from tests.made_sets import BOARD, PINHOLE, K


def test_grid_colours_follow_x_and_y():
    y, x = np.mgrid[0:60:1.0, 0:80:1.0]
    # Other axes than the image: x increases downwards, y to the left.
    location = np.stack([y, -x], axis=-1)
    location[0, 0] = np.nan
    at = np.full((1, 2), np.nan)
    view = SimpleNamespace(location=location, pixels=at, area=lambda: 60 * 80 - 1)
    drawn = grid_figure(np.zeros((60, 80), np.uint8), view, at, at, 1.0)
    red, green, _, tint = np.moveaxis(drawn.axes[0].images[1].get_array(), 2, 0)
    np.testing.assert_allclose(red[1:, 7], y[1:, 0] / 59)
    np.testing.assert_allclose(green[7], 1 - x[0] / 79)
    assert (tint > 0).sum() == 60 * 80 - 1


def test_grid_residuals_are_every_second_row_and_column():
    pixels = np.stack(np.meshgrid(np.arange(6.0), np.arange(4.0)), axis=-1)
    pixels = pixels.reshape(-1, 2)
    view = SimpleNamespace(pixels=pixels, every_pixel=True, rows=4, columns=6)
    at, off = arrows_of(view, SimpleNamespace(residuals_px=10 * pixels))
    np.testing.assert_array_equal(at, [[1, 1], [3, 1], [5, 1], [1, 3], [3, 3], [5, 3]])
    np.testing.assert_array_equal(off, 10 * at)


def test_only_knot_intervals_without_corners_are_red(monkeypatch):
    support = SimpleNamespace(cells=np.array([[3], [0]]))
    monkeypatch.setattr(mirror, "support_of", lambda *given: support)
    monkeypatch.setattr(mirror, "_pixels", lambda camera, uv: uv)
    grid = SimpleNamespace(breaks=(np.array([0.0, 1, 2]), np.array([0.0, 1])))
    _, (axes,) = image_figure(4, 4)
    mirror._draw_knots(axes, SimpleNamespace(grid=grid), None)
    texts = {text.get_text(): text for text in axes.texts}
    assert {name: text.get_position() for name, text in texts.items()} == {
        "3": (0.5, 0.5),
        "0": (1.5, 0.5),
    }
    assert [texts[name].get_color() == MISSING for name in "30"] == [False, True]


def test_profile_end_moves_towards_the_camera_by_its_height():
    """Relative to the first shape at the same position."""
    along = np.array([[0.0, 5, 10], [0.0, 4, 8]])
    height = np.array([[0.0, 0.5, 1.0], [0.0, 1.0, 3.0]])
    np.testing.assert_allclose(mirror.deflections(along, height), [0.0, 3.0 - 0.8])


def test_stage_row_has_numbers_in_the_order_of_heads():
    """Specified, estimated, residual, corners, outliers, ray errors."""
    stage = {
        "predicted_ray_error_deg": {"median": 0.1, "largest": 0.7},
        "residual_mm": {"mean": 0.5}, "deflection_mm": 2.5, "corners": 90,
        "wrong_corners": 4, "before": "a", "after": "b", "flags": ["<odd>"],
        "support": {"along_u": [1], "along_v": [2]},
    }  # fmt: skip
    result = {"model": "spfc2", "warnings": [], "stages": [stage, stage]}
    page = html(
        "mirror", name="m", result=result, pairs=[], moved=[0.0, 1.75], views=[[], []]
    )
    (row,) = (line for line in page.splitlines() if line.startswith("<tr><td>1"))
    assert re.findall(r'"number">([^<]*)<', row) == [
        "2.5", "1.75", "0.500", "90", "4", "0.100", "0.700",
    ]  # fmt: skip
    assert page.count("flagged: &lt;odd&gt;") == 1


def test_voted_size_is_columns_by_rows():
    size = {
        "votes": [{"columns": 9, "rows": 6, "files": ["a", "b", "c"]}],
        "photographs": 5,
    }
    assert _vote(size) == "9 x 6 corners in 3 of 5 images"


def test_predicted_corners_of_a_bent_board_follow_its_shape():
    points, middle = BOARD.points(), np.array([80.0, 60.0])
    shape = BoardShape(middle, middle, np.array([2.0, 0.0, 0.0, 0.0]))
    pinhole = type(PINHOLE)(K, [], PINHOLE.width, PINHOLE.height)
    T = np.eye(4)
    T[:3, 3] = [-80.0, -60.0, 400.0]
    found = _predicted(
        SimpleNamespace(camera=pinhole, shape=shape),
        SimpleNamespace(points=points),
        SimpleNamespace(T_camera_grid=T),
    )
    # The ends of x lie 2 mm behind the middle, which moves them by 0.3 px; that they
    # are drawn towards it, since no board stretches, by 0.02 px more.
    behind = 400 + 2 * ((points[:, 0] - 80) / 80) ** 2
    expected = K[:2, 2] + K[0, 0] * (points - middle) / behind[:, None]
    np.testing.assert_allclose(found, expected, atol=0.05)
