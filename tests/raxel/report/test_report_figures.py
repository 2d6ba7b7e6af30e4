"""Figures and tables of a report: positions, colours and columns."""

from types import SimpleNamespace

import numpy as np
import pytest

from raxel.calibration.views.correspondence import BoardShape
from raxel.report import images as active_grid
from raxel.report import mirror
from raxel.report import mirror as mirror_pictures
from raxel.report.canvas import INK, MISSING, QUIET, STRIP, Canvas
from raxel.report.images import COLOURS, corner_figure, grid_figure
from raxel.report.mirror import profile_figure
from raxel.report.page import ReportImage, _divisions, _row, _vote
from raxel.report.write import _arrows as arrows_of
from raxel.report.write import _predicted
from tests.made_sets import BOARD, PINHOLE, K

NAN = float("nan")


@pytest.mark.parametrize(("paleness", "grey"), [(0.0, 100), (0.2, 131), (1.0, 255)])
def test_pale_images_are_nearer_to_white(paleness, grey):
    canvas = Canvas(20, 10, np.full((10, 20), 100, np.uint8), paleness)
    assert (canvas.image == grey).all()


def cells(row):
    return [cell.partition("</td>")[0] for cell in row.split('<td class="number">')[1:]]


def test_image_row_has_numbers_in_the_order_of_heads():
    """Corners, those not scored, RMS, median and mean angle."""
    score = SimpleNamespace(
        n_corners=50, n_without_ray=7, rms_px=0.4, median_px=0.3, mean_deg=0.2
    )
    row = _row(ReportImage("one", score, "seen", "residuals", ""))
    assert cells(row) == ["50", "7", "0.400", "0.300", "0.2000"]


def test_division_row_has_numbers_in_the_order_of_heads():
    found = {
        "divided_by": "near and far", "disagreement_px": 0.9, "scatter_px": 0.2,
        "allowed_px": 0.5, "p_value": 1e-7,
    }  # fmt: skip
    _, head, row, _ = _divisions([found]).splitlines()
    names = [part.partition("</th>")[0] for part in head.split("<th>")[1:]]
    assert names[1:] == ["Difference (px)", "From scatter (px)", "Allowed (px)", "p"]
    assert cells(row) == ["0.90", "0.20", "0.50", "1e-07"]


def test_corners_are_numbered_row_by_row(monkeypatch):
    texts = {}
    monkeypatch.setattr(
        Canvas, "text", lambda self, point, text, *_: texts.update({text: tuple(point)})
    )
    lattice = np.stack(np.meshgrid([20.0, 120, 220], [30.0, 130]), axis=-1)
    view = SimpleNamespace(rows=2, columns=3, pixels=lattice.reshape(-1, 2))
    corner_figure(np.zeros((160, 240), np.uint8), view, view.pixels)
    assert texts == {str(k): tuple(point) for k, point in enumerate(view.pixels)}


def test_grid_colours_follow_x_and_y():
    y, x = np.mgrid[0:60:1.0, 0:80:1.0]
    # Other axes than the image: x increases downwards, y to the left.
    location = np.stack([y, -x], axis=-1)
    view = SimpleNamespace(
        location=location,
        pixels=np.full((1, 2), NAN),
        area=lambda: location[..., 0].size,
    )
    drawn = grid_figure(np.zeros((60, 80), np.uint8), view)[:240, :320].astype(float)
    _, green, red = np.moveaxis(drawn, 2, 0)
    assert red[220:236].mean() > red[4:20].mean() + 100
    assert green[:, 4:20].mean() > green[:, 300:316].mean() + 100


def test_deviation_colours_are_those_of_the_legend(monkeypatch):
    monkeypatch.setattr(Canvas, "with_legend", lambda self, _: self.image)
    sigma = np.full((20, 30, 2), 0.1)
    sigma[:, 15:] = 0.4
    decoded = SimpleNamespace(sigma=sigma, unit="mm")
    drawn = active_grid._deviations(decoded, np.zeros((20, 30), np.uint8))
    assert tuple(drawn[40, 20]) == active_grid.CERTAIN
    assert tuple(drawn[40, 100]) == active_grid.UNCERTAIN


def test_contour_lines_of_x_have_the_colour_of_x():
    _, x = np.mgrid[0:40, 0:60]
    decoded = SimpleNamespace(
        status=np.zeros((40, 60), int), unit="mm",
        location=np.stack([x / 60 * 32, np.full(x.shape, 7.0)], axis=-1),
    )  # fmt: skip
    drawn = active_grid._places(decoded, np.full((40, 60), 90, np.uint8), (32, 20))
    counts = [
        np.count_nonzero((drawn[:160] == colour).all(axis=2))
        for colour in active_grid.LINE_COLOURS
    ]
    # The fifteen borders between sixteen parts, from top to bottom but for the frame.
    assert counts[0] == pytest.approx(15 * 160, rel=0.05)
    assert counts[1] == 0


def test_grid_residuals_are_every_second_row_and_column():
    pixels = np.stack(np.meshgrid(np.arange(6.0), np.arange(4.0)), axis=-1)
    pixels = pixels.reshape(-1, 2)
    view = SimpleNamespace(pixels=pixels, every_pixel=True, rows=4, columns=6)
    at, off = arrows_of(view, SimpleNamespace(residuals_px=10 * pixels))
    np.testing.assert_array_equal(at, [[1, 1], [3, 1], [5, 1], [1, 3], [3, 3], [5, 3]])
    np.testing.assert_array_equal(off, 10 * at)


def test_higher_profile_is_drawn_above():
    along = np.tile(np.linspace(0, 50, 81), (2, 1))
    drawn = profile_figure(along, np.stack([np.zeros(81), np.full(81, 5.0)]))[:400]
    rows = [np.nonzero((drawn == c).all(axis=2))[0].mean() for c in COLOURS[:2]]
    assert rows[1] < rows[0] - 200


def test_profile_end_moves_towards_the_camera_by_its_height(tmp_path, monkeypatch):
    """Relative to the first shape at the same position."""
    along = np.array([[0.0, 5, 10], [0.0, 4, 8]])
    height = np.array([[0.0, 0.5, 1.0], [0.0, 1.0, 3.0]])
    given, blank = [], np.zeros((4, 4, 3), np.uint8)
    view = SimpleNamespace(name="a", pixels=np.zeros((1, 2)))
    found = SimpleNamespace(
        views=[SimpleNamespace(stage=0, view=view)], cameras=[None],
        bundle=SimpleNamespace(residuals=[np.ones((1, 2))]),
    )  # fmt: skip
    stages = SimpleNamespace(views=[SimpleNamespace(label="a", main_image="a")])
    for name, value in {
        "read_image": blank[..., 0], "_counted": view.pixels,
        "residual_figure": blank, "shape_figure": blank, "profile_figure": blank,
        "profiles": (along, height),
    }.items():  # fmt: skip
        monkeypatch.setattr(mirror, name, lambda *_, value=value: value)
    monkeypatch.setattr(mirror, "_page", lambda *all_: given.append(all_[-1]) or "")
    of_set = SimpleNamespace(stages=stages, size=(4, 4))
    mirror.write_mirror_report(tmp_path, of_set, found, {})
    np.testing.assert_allclose(given, [[0.0, 3.0 - 0.8]])


def test_stage_row_has_numbers_in_the_order_of_heads():
    """Specified, estimated, residual, corners, outliers, ray errors."""
    stage = {
        "predicted_ray_error_deg": {"median": 0.1, "largest": 0.7},
        "residual_mm": {"mean": 0.5}, "deflection_mm": 2.5, "corners": 90,
        "wrong_corners": 4,
    }  # fmt: skip
    row = mirror._table([stage, stage], [0.0, 1.75]).splitlines()[-2]
    assert cells(row) == ["2.5", "1.75", "0.500", "90", "4", "0.100", "0.700"]
    assert mirror.HEADS[4:] == (
        "Corners", "Outliers", "Ray error, median (deg)", "Ray error, largest (deg)",
    )  # fmt: skip


def test_only_knot_intervals_without_corners_are_red(monkeypatch):
    texts = []
    canvas = SimpleNamespace(
        line=lambda *given: None, text=lambda *given: texts.append(given[1:3])
    )
    support = SimpleNamespace(cells=np.array([[3], [0]]))
    monkeypatch.setattr(mirror_pictures, "support_of", lambda *given: support)
    monkeypatch.setattr(mirror_pictures, "_pixels", lambda camera, uv: uv)
    grid = SimpleNamespace(breaks=(np.array([0.0, 1, 2]), np.array([0.0, 1])))
    mirror_pictures._draw_knots(canvas, SimpleNamespace(grid=grid), None)
    assert texts == [("3", INK), ("0", MISSING)]


@pytest.mark.parametrize("width", [240, 1920])
def test_crosses_have_the_same_size_in_all_figures(width):
    canvas = Canvas(width, width // 2)
    canvas.cross(np.array([width / 2, width / 4]), QUIET, 5)
    there = np.any(canvas.image < 255, axis=2)
    rows, columns = np.flatnonzero(there.any(axis=1)), np.flatnonzero(there.any(axis=0))
    assert 10 <= np.ptp(rows) <= 13
    assert 10 <= np.ptp(columns) <= 13


def test_long_legends_continue_on_another_strip(monkeypatch):
    """No entry is truncated at the edge of the figure."""
    canvas, words = Canvas(240, 120), "w" * 50
    whole = canvas.with_legend([(INK, words)])
    wide = np.flatnonzero((whole[-STRIP:] < 255).any(axis=(0, 2))).max()
    assert wide < canvas.image.shape[1] < 2 * wide
    height = canvas.image.shape[0]
    assert len(canvas.with_legend(2 * [(INK, words)])) == height + 2 * STRIP
    assert len(canvas.with_legend(2 * [(INK, "w")])) == height + STRIP


def test_decoded_shares_are_of_all_pixels():
    counts = np.array([600, 300, 100, 0])
    assert [active_grid._share(counts, k) for k in (1, 2)] == ["30.0 %", "10.0 %"]
    assert active_grid._share(np.array([99999, 1]), 1) == "1 px"


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
