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
from raxel.report.canvas import Canvas
from raxel.report.images import (
    CUT,
    RESIDUAL,
    ArrowScale,
    _arrows,
    corner_figure,
    coverage_figure,
    disagreement_figure,
    pooled_figure,
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
    assert len(figures) == 2 * 3 + 3
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


def test_disagreement_arrows_have_the_right_length():
    pixels = np.array([[100.0, 60.0], [200.0, 60.0], [100.0, 200.0]])
    field = np.array([[0.5, 0.0], [0.5, 0.0], [np.nan, np.nan]])
    division = Division("near and far", ((), ()), 0.5, 0.1, 0.1, 0.5, field)
    drawn = disagreement_figure(WIDTH, HEIGHT, pixels, division)
    scattered = disagreement_figure(
        WIDTH, HEIGHT, pixels, division._replace(allowed_px=5.0)
    )
    blank = disagreement_figure(
        WIDTH, HEIGHT, pixels, division._replace(field=np.zeros((3, 2)))
    )
    # 5 % of the width, along u; a tenth of that where scatter would be ten times more.
    scale = drawn.shape[1] / WIDTH
    tip = pixels[0] + [0.9 * 0.05 * WIDTH, 0]
    assert changed(drawn, blank, tip, scale)
    assert not changed(scattered, blank, tip, scale)


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


def changed(drawing, before, point, canvas_scale, reach=6):
    """How many pixels differ around a point of the image."""
    u, v = np.rint((np.asarray(point) + 0.5) * canvas_scale - 0.5).astype(int)
    part = np.s_[max(v - reach, 0) : v + reach + 1, max(u - reach, 0) : u + reach + 1]
    return np.count_nonzero(np.any(drawing[part] != before[part], axis=-1))


def test_corners_are_drawn_and_missing_ones_predicted():
    (pixels,) = boards_of(PINHOLE, count=1)
    grey = np.full((HEIGHT, WIDTH), 90, np.uint8)
    nothing = view_of(np.full_like(pixels, np.nan))
    blank = corner_figure(grey, nothing, nothing.pixels)
    holes = pixels.copy()
    holes[[0, 31]] = np.nan
    drawing = corner_figure(grey, view_of(holes), pixels)
    scale = blank.shape[1] / WIDTH
    assert all(changed(drawing, blank, point, scale) for point in pixels)
    # Red, where no corner was found.
    u, v = np.rint((pixels[31] + 0.5) * scale - 0.5).astype(int)
    b, g, r = drawing[v, u].astype(int)
    assert r > 150
    assert max(b, g) < 100
    unknown = corner_figure(grey, view_of(holes), nothing.pixels)
    assert not changed(unknown, blank, pixels[31], scale)


def test_arrows_start_at_the_corner_along_the_residual():
    at = np.array([[100.0, 120.0], [200.0, 60.0]])
    off = np.array([[0.5, 0.0], [0.0, 0.25]])
    scale = ArrowScale.of(off, WIDTH)
    assert scale.magnified * 0.5 == pytest.approx(0.05 * WIDTH, rel=0.03)
    drawing = pooled_figure(WIDTH, HEIGHT, [(at, off)], scale)
    blank = pooled_figure(WIDTH, HEIGHT, [], scale)
    canvas = drawing.shape[1] / WIDTH
    for point, residual in zip(at, off, strict=True):
        along = point + 0.5 * scale.magnified * residual
        assert changed(drawing, blank, along, canvas, reach=1)
        against = point - 0.5 * scale.magnified * residual
        assert not changed(drawing, blank, against, canvas, reach=1)
    # A residual much longer than the others is truncated, and red.
    vector, cut = scale.arrow(np.array([0.0, 50.0]))
    assert cut
    assert np.linalg.norm(vector) == pytest.approx(3 * 0.05 * WIDTH, rel=0.03)


@pytest.mark.parametrize(("length", "colour"), [(1.9, RESIDUAL), (2.1, CUT)])
def test_only_truncated_arrows_are_red(length, colour):
    canvas = Canvas(100, 60)
    residual = np.array([[length, 0.0]])
    _arrows(canvas, np.array([[20.0, 30.0]]), residual, ArrowScale(20, 2.0), RESIDUAL)
    drawn = set(map(tuple, canvas.image.reshape(-1, 3)))
    assert drawn & {CUT, RESIDUAL} == {colour}


@pytest.mark.parametrize("width", [240, 1920])
def test_legend_arrow_has_the_length_of_its_value(width):
    scale = ArrowScale.of(np.tile([0.5, 0.0], (20, 1)), width)
    canvas = Canvas(width, 30)
    (key, words), _ = scale.legend(canvas)
    assert words.startswith("0.5 px, magnified")
    ends = canvas.place([[0.0, 0.0], scale.arrow(np.array([0.5, 0.0]))[0]])
    assert key == pytest.approx(ends[1, 0] - ends[0, 0])


def test_coverage_counts_boards_and_marks_the_end_of_rays():
    square = view_of(BOARD.points() + [20, 20])
    second = view_of(BOARD.points() + [60, 20])
    mask = np.zeros((HEIGHT, WIDTH), bool)
    mask[20:141, 20:200] = True
    drawing = coverage_figure([square, second], WIDTH, HEIGHT, mask)
    scale = drawing.shape[1] / WIDTH

    def colour(u, v):
        return tuple(drawing[int((v + 0.5) * scale), int((u + 0.5) * scale)])

    assert colour(33, 70) == colour(213, 70) == (235, 206, 170)
    assert colour(110, 70) == (222, 165, 100)
    assert colour(280, 200) == (255, 255, 255)
    assert colour(199.7, 70) == (0, 120, 255)


@pytest.mark.parametrize("size", [(300, 200), (3000, 2000)])
def test_image_fills_the_figure(size):
    """Both end half a pixel outside the outermost pixel centres."""
    canvas = Canvas(*size)
    whole = np.array(canvas.image.shape[1::-1])
    ends = canvas.place([[-0.5, -0.5], np.array(size) - 0.5])
    np.testing.assert_allclose(ends, [[-0.5, -0.5], whole - 0.5], atol=0.5)
    np.testing.assert_array_equal(ends[0], -0.5)
