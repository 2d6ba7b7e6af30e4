"""The report of `raxel calibrate`: correct figures, a safe page."""

from html.parser import HTMLParser

import cv2
import numpy as np
import pytest

from raxel.calibration.views.correspondence import BoardView
from raxel.cli import main
from raxel.evaluation.split_half import Division
from raxel.io.files import read_json
from raxel.report import check_report, new_report, write
from raxel.report.figures import (
    RESIDUAL,
    board_figure,
    coverage_figure,
    disagreement_figure,
    draw_arrows,
    error_figure,
    image_figure,
    pooled_figure,
    typical_length,
)
from raxel.sets import load_set
from tests.made_sets import (
    BOARD,
    COLUMNS,
    HEIGHT,
    PINHOLE,
    ROWS,
    WIDTH,
    boards_of,
    write_made_set,
)

NAMES = ["<svg onload=alert(1)>.png", '"quoted" & more.png', "c.png", "d.png"]


class Seen(HTMLParser):
    """Tags and texts of a page."""

    def __init__(self):
        super().__init__()
        self.tags, self.sources, self.texts = [], [], []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.sources += [value for name, value in attrs if name in ("src", "href")]

    def handle_data(self, data):
        self.texts.append(data)


def order(tmp_path, boards, report):
    folder, corners = write_made_set(tmp_path / "set", boards, NAMES)
    arguments = ["calibrate", str(folder), "--corners", str(corners), "--model"]
    arguments += ["zhang", "--out", str(tmp_path / "camera.npz")]
    return [*arguments, "--report", str(report)]


def view_of(pixels, name="board"):
    return BoardView(pixels, BOARD.points(), COLUMNS, ROWS, name)


def test_page_has_every_name_as_text_and_every_figure(tmp_path):
    report = tmp_path / "report"
    assert main(order(tmp_path, [*boards_of(PINHOLE, count=3), None], report)) == 0
    seen = Seen()
    seen.feed((report / "index.html").read_text("utf-8"))
    assert not {"svg", "script"} & set(seen.tags)
    for name in NAMES:
        assert name in seen.texts
    assert "too dark" in seen.texts
    assert any(text.startswith("warning: d.png: excluded") for text in seen.texts)
    figures = {path.name for path in report.iterdir()} - {"index.html"}
    assert set(seen.sources) == figures
    assert len(figures) == 3 + 3
    assert all(cv2.imread(str(report / name)) is not None for name in figures)


def test_page_shows_the_split_half_test(tmp_path, monkeypatch):
    drawn = []

    def drawing(*given):
        drawn.append(given[-1].name)
        return disagreement_figure(*given)

    monkeypatch.setattr(write, "disagreement_figure", drawing)
    report, boards = tmp_path / "report", boards_of(PINHOLE, count=6)
    folder, corners = write_made_set(tmp_path / "set", boards)
    arguments = ["calibrate", str(folder), "--corners", str(corners), "--model"]
    arguments += ["zhang", "--out", str(tmp_path / "camera.npz")]
    result = tmp_path / "result.json"
    arguments += ["--json", str(result), "--report", str(report)]
    assert main(arguments) == 0
    divisions = read_json(result)["stability"]["divisions"]
    assert drawn == [divisions[0]["divided_by"]]
    seen = Seen()
    seen.feed((report / "index.html").read_text("utf-8"))
    assert "stability.png" in seen.sources
    assert {"near and far", "order of the images"} <= set(seen.texts)
    halves = [text for text in seen.texts if "half of the worst division: " in text]
    assert len(halves) == 2
    assert all(sum(f"{k}.png" in text for text in halves) == 1 for k in range(6))
    check_report(report, load_set(folder))  # the next one may take its place


def test_disagreement_arrows_within_the_allowed_stay_short():
    pixels = np.array([[100.0, 60.0], [200.0, 60.0], [100.0, 200.0]])
    field = np.array([[0.5, 0.0], [0.5, 0.0], [np.nan, np.nan]])
    division = Division("near and far", ((), ()), 0.5, 0.1, 0.1, 0.5, field)
    for allowed, length in ((0.5, 0.05), (5.0, 0.005)):
        drawn = disagreement_figure(
            WIDTH, HEIGHT, pixels, division._replace(allowed_px=allowed)
        )
        starts, vectors = arrows_in(drawn.axes[0])
        np.testing.assert_array_equal(starts, pixels[:2])
        np.testing.assert_allclose(vectors, 2 * [[length * WIDTH, 0]])


def test_report_replaces_only_a_report(tmp_path, capsys):
    report = tmp_path / "report"
    arguments = order(tmp_path, [*boards_of(PINHOLE, count=3), None], report)
    report.mkdir()
    (report / "mine.txt").write_text("mine")
    assert main(arguments) == 2
    assert "found other files than a report's" in capsys.readouterr().err
    assert not (tmp_path / "camera.npz").exists()
    (report / "mine.txt").unlink()
    assert main(arguments) == 0
    (report / "coverage.png").write_bytes(b"old")
    assert main(arguments) == 0
    assert (report / "coverage.png").read_bytes() != b"old"
    (report / "camera.npz").write_bytes(b"mine")
    assert main(arguments) == 2
    (report / "camera.npz").unlink()
    assert main([*arguments, "--json", str(report / "result.json")]) == 2
    assert "whose place the report takes" in capsys.readouterr().err
    inside = [*arguments[:-1], str(tmp_path / "set" / "report")]
    assert main(inside) == 2
    assert "sets are only read" in capsys.readouterr().err


def test_failed_report_keeps_the_old_one(tmp_path):
    report = tmp_path / "report"
    report.mkdir()
    (report / "index.html").write_text("old")

    def fails():
        with new_report(report) as folder:
            (folder / "index.html").write_text("half")
            raise OSError("disk full")

    with pytest.raises(OSError, match="full"):
        fails()
    assert (report / "index.html").read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["report"]


def arrows_in(axes):
    """Starts and vectors (N, 2) of the arrows, px of the image."""
    (arrows,) = axes.collections
    vectors = np.column_stack([arrows.U, arrows.V]) / arrows.scale
    return arrows.get_offsets(), vectors


def test_corners_are_numbered_row_by_row_and_missing_ones_predicted():
    (pixels,) = boards_of(PINHOLE, count=1)
    grey = np.full((HEIGHT, WIDTH), 90, np.uint8)
    holes = pixels.copy()
    holes[[0, 31]] = np.nan
    drawn = board_figure(grey, view_of(holes), pixels, np.zeros_like(pixels), 1.0)
    texts = {text.get_text(): text.xy for text in drawn.axes[0].texts}
    ends = [k for r in range(ROWS) for k in (r * COLUMNS, (r + 1) * COLUMNS - 1)]
    assert set(texts) == {str(k) for k in ends[1:]} | {"0 missing", "31 missing"}
    for text, place in texts.items():
        np.testing.assert_array_equal(place, pixels[int(text.split()[0])])
    unknown = np.full_like(pixels, np.nan)
    drawn = board_figure(grey, view_of(holes), unknown, unknown, 1.0)
    assert len(drawn.axes[0].texts) == 2 * ROWS - 1


def test_arrows_start_at_the_corner_along_the_residual():
    at = np.array([[100.0, 120.0], [200.0, 60.0]])
    off = np.array([[0.5, 0.0], [0.0, 0.25]])
    long = typical_length(np.tile([0.5, 0.0], (20, 1)))
    assert long == pytest.approx(0.5)
    drawn = pooled_figure(WIDTH, HEIGHT, [(at, off)], long)
    starts, vectors = arrows_in(drawn.axes[0])
    np.testing.assert_array_equal(starts, at)
    np.testing.assert_allclose(vectors, off * 0.05 * WIDTH / 0.5)


def test_only_arrows_above_three_long_residuals_are_truncated():
    _, (axes,) = image_figure(WIDTH, HEIGHT)
    off = np.array([[2.9, 0.0], [0.0, -3.1], [0.0, 50.0]])
    draw_arrows(axes, np.full((3, 2), 20.0), off, 1.0, RESIDUAL)
    _, vectors = arrows_in(axes)
    lengths = np.linalg.norm(vectors, axis=1) / (0.05 * WIDTH)
    np.testing.assert_allclose(lengths, [2.9, 3.0, 3.0])
    colours = axes.collections[0].get_facecolor()
    assert (colours[1] == colours[2]).all()
    assert (colours[0] != colours[1]).any()


def test_coverage_counts_boards_and_marks_the_end_of_rays():
    square = view_of(BOARD.points() + [20, 20])
    second = view_of(BOARD.points() + [60, 20])
    mask = np.zeros((HEIGHT, WIDTH), bool)
    mask[20:141, 20:200] = True
    axes = coverage_figure([square, second], WIDTH, HEIGHT, mask).axes[0]
    counts = axes.images[0].get_array()
    assert [counts[70, u] for u in (33, 110, 213, 280)] == [1, 2, 1, 0]
    limits = np.vstack([path.vertices for path in axes.collections[0].get_paths()])
    np.testing.assert_allclose(limits.min(axis=0), [19.5, 19.5])
    np.testing.assert_allclose(limits.max(axis=0), [199.5, 140.5])


def test_next_image_is_framed_where_rays_are_least_certain():
    axes = error_figure(PINHOLE, "lower left").axes[0]
    (frame,) = axes.patches
    corner = np.array([frame.get_x(), frame.get_y()])
    np.testing.assert_allclose(corner, [-0.5, 2 * HEIGHT / 3 - 0.5])
    assert (frame.get_width(), frame.get_height()) == (WIDTH / 3, HEIGHT / 3)
