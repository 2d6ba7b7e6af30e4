"""Detectors side by side on an image set: what is right, and what cannot be told."""

import json
from pathlib import Path

import numpy as np
import pytest

from chapters.photographs.set import tables as set_tables
from chapters.photographs.set.trials import detectors
from raxel.sets import load_set
from repro.run import jobs
from repro.run.results import Result
from repro.run.sets_of_report import set_files
from tests.image_sets import COLUMNS, ROWS, description, write_description
from tests.image_sets import write_drawn_set as write_set

ROOT = Path(__file__).resolve().parents[1]
NAME = "photograph_detectors@drawn"
TILTS = ((0, 0), (25, 0))


def with_reference(folder, shift=0.0, **changes):
    """A drawn set whose reference corners are the true ones, moved by `shift` px."""
    boards = write_set(folder, tilts=TILTS, reference="corners.json", **changes)
    images = {
        f"view{k}.png": {"corners": (board.corners() + [shift, 0]).tolist()}
        for k, board in enumerate(boards)
    }
    content = {"columns": COLUMNS, "rows": ROWS, "images": images}
    (folder / "corners.json").write_text(json.dumps(content), "utf-8")
    return boards


def run(folder, out):
    order = jobs.Order(NAME, "full", None, str(folder), folder)
    out.mkdir(parents=True)
    part = out / "0-of-1.json"
    jobs.run(ROOT, order, 0, 1, part)
    path = out / "results" / f"{NAME}.json"
    jobs.gather(ROOT, order, "key", {}, [part], path)
    return set_tables.ext_detectors({"photograph_detectors": Result(path)})


def cells(table, column):
    return dict(zip(table.columns["Method"], table.columns[column], strict=True))


def test_right_boards_are_counted_with_their_errors(tmp_path):
    with_reference(tmp_path / "drawn")
    table = run(tmp_path / "drawn", tmp_path / "out")
    assert set_of(cells(table, "Images")) == {2}
    assert set_of(cells(table, "Right")) == {2}
    after = {name: float(cell) for name, cell in cells(table, "Max after (px)").items()}
    assert max(after.values()) < 0.3
    assert float(cells(table, "Max before (px)")["CELECT"]) < 4


def test_a_board_off_its_reference_is_returned_and_not_right(tmp_path):
    with_reference(tmp_path / "drawn", shift=9.0)
    table = run(tmp_path / "drawn", tmp_path / "out")
    name = "without clicks (ext.)"
    assert cells(table, "Returned")[name] == 2
    assert cells(table, "Right")[name] == 0
    assert "Mean before (px)" not in table.columns


def test_without_reference_nothing_is_called_right(tmp_path):
    write_set(tmp_path / "drawn", tilts=TILTS)
    table = run(tmp_path / "drawn", tmp_path / "out")
    assert list(table.columns) == ["Method", "Images", "Returned"]
    assert cells(table, "Images")["CELECT"] == 0
    assert cells(table, "Returned")["without clicks (ext.)"] == 2
    assert "no reference corners" in table.caption


def test_clicks_of_the_description_are_the_ones_that_celect_has(tmp_path):
    board = write_set(tmp_path / "drawn", tilts=TILTS[:1])[0]
    corners = board.corners().reshape(ROWS, COLUMNS, 2)
    clicks = corners[[0, 0, -1, -1], [0, -1, -1, 0]].round().tolist()
    views = [{"image": "view0.png", "outer_corners": clicks}]
    write_description(tmp_path / "drawn", description(1, views=views))
    view = load_set(tmp_path / "drawn").views[0]
    given = detectors.clicks_of(view, (COLUMNS, ROWS), None, np.random.default_rng(0))
    np.testing.assert_array_equal(given, clicks)
    table = run(tmp_path / "drawn", tmp_path / "out")
    assert cells(table, "Returned")["CELECT"] == 1


def test_a_set_without_known_size_says_that_there_is_nothing_to_compare(tmp_path):
    write_set(tmp_path / "drawn", tilts=TILTS[:1])
    target = {"kind": "chessboard", "columns": None, "rows": None, "pitch_mm": 20.0}
    write_description(tmp_path / "drawn", description(1, target=target))
    table = run(tmp_path / "drawn", tmp_path / "out")
    assert detectors.UNSUITED in table.caption


@pytest.mark.parametrize("named", [True, False])
def test_reference_corners_are_an_input_of_what_is_found(tmp_path, named):
    if named:
        with_reference(tmp_path / "drawn")
    else:
        write_set(tmp_path / "drawn", tilts=TILTS)
        (tmp_path / "drawn" / "corners.json").write_text("{}", "utf-8")
    assert ("corners.json" in set_files(tmp_path / "drawn")) is named


def set_of(column):
    return {*column.values()}
