"""The benchmark of detectors counts what is right, wrong and refused."""

import json

import pytest

from raxel.cli import main
from raxel.evaluation import detector_bench
from raxel.evaluation.detector_bench import GIVEN, NOT_GIVEN, bench_detectors
from raxel.features.detector import refused
from raxel.sets import load_set
from tests.image_sets import COLUMNS, ROWS, TILTS_DEG, boards, write_drawn_set

CORNERS = [board.corners() for board in boards()]


@pytest.fixture
def rendered(tmp_path):
    """A set of two boards with reference corners."""
    reference = {
        "columns": COLUMNS,
        "rows": ROWS,
        "images": {
            f"view{i}.png": {"corners": CORNERS[i].tolist(), "spread_max_px": 0.1}
            for i in range(2)
        },
    }
    folder = tmp_path / "set"
    write_drawn_set(folder, TILTS_DEG[:2], reference="corners.json")
    (folder / "corners.json").write_text(json.dumps(reference))
    return folder


def by_run(scores):
    return {(score.detector, score.size): score for score in scores}


def test_all_detectors_find_drawn_boards_and_the_ratio_is_to_the_peer(rendered):
    scores = by_run(bench_detectors(load_set(rendered)))
    assert scores["opencv", GIVEN].ratio == 1
    for run in (("raxel", GIVEN), ("raxel", NOT_GIVEN), ("opencv", GIVEN)):
        assert (scores[run].right, scores[run].wrong, scores[run].refused) == (2, 0, 0)
        assert scores[run].median_ms > 0


def test_a_board_off_its_reference_is_wrong_and_none_is_refused(rendered, monkeypatch):
    found = detector_bench.DETECTORS["raxel"]

    def beside(image, columns, rows):
        detection = found(image, columns, rows)
        return detection._replace(corners=detection.corners + [3.0, 0.0])

    def blind(image, columns, rows):
        return refused(columns, rows, "none")

    detectors = {"raxel": beside, "opencv": found, "opencv-sb": blind}
    monkeypatch.setattr(detector_bench, "DETECTORS", detectors)
    scores = by_run(bench_detectors(load_set(rendered)))
    assert scores["raxel", NOT_GIVEN].wrong == 2
    assert scores["opencv", GIVEN].right == 2
    assert scores["opencv-sb", GIVEN].refused == 2


def test_a_board_without_reference_is_not_judged(tmp_path):
    write_drawn_set(tmp_path / "set", TILTS_DEG[:1])
    scores = by_run(bench_detectors(load_set(tmp_path / "set")))
    assert scores["raxel", GIVEN].unjudged == 1
    assert scores["raxel", GIVEN].right == 0


def test_command_prints_and_writes_the_same_counts(rendered, tmp_path, capsys):
    target = tmp_path / "bench.json"
    assert main(["bench", str(rendered), "--json", str(target)]) == 0
    rows = json.loads(target.read_text())["drawn"]
    assert {row["detector"] for row in rows} == {"raxel", "opencv", "opencv-sb"}
    assert "not given" in capsys.readouterr().out
