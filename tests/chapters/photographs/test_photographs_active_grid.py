"""The page of an active grid describes any set of images."""

from pathlib import Path

import numpy as np
import pytest

from chapters.photographs.active_grid import exercises, report
from chapters.shared.images import notes
from raxel.sets import PatternPlan
from repro.page.style import check_axes
from repro.run import jobs
from repro.run.results import Result
from tests.active_grids import drawn
from tests.raxel.cli.test_cli_active_grid import recorded

ROOT = Path(__file__).resolve().parents[3]
NAME = "active_grid_study@drawn"
SENTENCES = (
    report.about,
    report.shown,
    notes.origin,
    report.found,
    report.left_out,
    report.precision,
    report.doubted,
    report.camera,
    report.exercise,
)


def produced(tmp_path, scene):
    """(sentences by name, tables) of the page of these images."""
    folder = recorded(tmp_path / "drawn", scene)
    order = jobs.Order(NAME, "quick", None, str(folder), tmp_path)
    jobs.run(ROOT, order, 0, 1, tmp_path / "part.json")
    path = tmp_path / f"{NAME}.json"
    jobs.gather(ROOT, order, "key", {}, [tmp_path / "part.json"], path)
    given = {report.STUDY: Result(path)}
    drawing = report.ext_grid_places(given)
    check_axes(drawing.figure, drawing.caption)
    drawing.figure.draw_without_rendering()
    filled = [report.ext_grid_views(given), report.ext_grid_camera(given)]
    for table in filled:
        assert len({len(column) for column in table.columns.values()}) == 1
    study = report.GridStudy(given[report.STUDY])
    sentences = {sentence.__name__: sentence(study) for sentence in SENTENCES}
    for text in sentences.values():
        assert text.endswith(".")
        assert "nan" not in text.split()
    return sentences, filled


def test_page_describes_phase_shift_images_with_code(tmp_path):
    sentences, (views, _) = produced(tmp_path, drawn(noise=2.0, blur=0.8))
    share = views.columns["Decoded (%)"][0]
    assert f"{share:.1f} % of all pixels" in sentences["found"]
    total = sum(
        views.columns[name][0] for name in views.columns if name.endswith("(%)")
    )
    assert total == pytest.approx(100)
    assert "mm along x and" in sentences["precision"]
    assert sentences["doubted"].startswith("The images are consistent")
    assert sentences["camera"].startswith("There is no calibration: 1 views")
    assert views.columns["Noise at grey value 100 (grey values)"][0] == pytest.approx(
        2, rel=0.1
    )


def test_page_describes_code_of_one_axis(tmp_path):
    scene = drawn(plan=PatternPlan((6, 0), True), noise=2.0)
    sentences, (views, _) = produced(tmp_path, scene)
    assert "along y" not in sentences["precision"]
    assert sentences["precision"].endswith("that of a cell's width.")
    assert not any("σ y" in name for name in views.columns)


def test_page_reports_images_in_the_wrong_order(tmp_path):
    scene = drawn(noise=2.0, blur=0.8)
    scene.images[[12, 13]] = scene.images[[13, 12]]
    sentences, (views, _) = produced(tmp_path, scene)
    assert sentences["found"].startswith("None of 1 view is decoded: ")
    assert "phase steps along x are not in order" in sentences["found"]
    assert "not in order" in views.columns["Remark"][0]
    assert sentences["precision"] == "No standard deviation is predicted."


def test_exercise_answers_are_correct():
    rng = np.random.default_rng(0)
    noise, steps = 3.0, 4
    angle = 0.7 + 2 * np.pi * np.arange(steps) / steps
    taken = exercises.MODULATION * np.sin(angle) + rng.normal(0, noise, (40000, steps))
    turn = 2 * np.pi * np.arange(steps) / steps
    phase = np.arctan2(taken @ np.cos(turn), taken @ np.sin(turn))
    spread = exercises.PERIOD_MM / (2 * np.pi) * phase.std()
    assert exercises.spread_task(noise)["expected"]() == pytest.approx(spread, rel=0.02)
    assert [exercises.cell(b) for b in ((0, 0, 1), (1, 1, 0), (1, 0, 0))] == [1, 4, 7]
