"""Rows of cells become columns of the data behind a figure."""

import pytest

from repro.page.cells import as_read, is_numeric
from repro.run.as_columns import columns, csv_text, in_columns, in_numbers, measured
from repro.run.outcomes import Measured


def test_rows_become_columns():
    found = columns(("name", "x_mm"), [("a", 1.0), ("b", 2.0)])
    assert found == {"name": ["a", "b"], "x_mm": [1.0, 2.0]}
    assert columns(("name", "x_mm"), []) == {"name": [], "x_mm": []}


def test_named_rows_become_columns():
    rows = ({"name": name, "x_mm": x} for name, x in (("a", 1.0), ("b", 2.0)))
    assert in_columns(rows) == {"name": ["a", "b"], "x_mm": [1.0, 2.0]}
    with pytest.raises(KeyError):
        in_columns([{"name": "a", "x_mm": 1.0}, {"name": "b"}])


@pytest.mark.parametrize("row", [("a",), ("a", 1.0, 2.0)])
def test_row_of_other_length_is_rejected(row):
    with pytest.raises(ValueError, match="zip"):
        columns(("name", "x_mm"), [row])


def test_measured_is_three_columns_and_one_cell():
    table = {
        "Method": ["a", "b", "c"],
        "RMS (px)": [Measured(0.74213, 0.7012, 0.7834), None, 3.5],
        "Failed": [0, 50, 2],
    }
    assert measured(table) == ["RMS (px)"]
    assert csv_text(in_numbers(table)).splitlines() == [
        'Method,RMS (px),"RMS (px), low","RMS (px), high",Failed',
        "a,0.74213,0.7012,0.7834,0",
        "b,,,,50",
        "c,3.5,,,2",
    ]
    flat = {
        name: ["" if cell is None else str(cell) for cell in cells]
        for name, cells in in_numbers(table).items()
    }
    read = as_read(flat, ["RMS (px)"], [], digits=4)
    assert read == {
        "Method": ["a", "b", "c"],
        "RMS (px)": ["0.742 (0.701 to 0.783)", "–", "3.5"],
        "Failed": ["0", "50", "2"],
    }
    assert [is_numeric(cells) for cells in read.values()] == [False, True, True]


def test_texts_like_intervals_remain_texts():
    assert not is_numeric(["board (1 to 3)"])
    assert not is_numeric(["–", "–"])
    assert is_numeric(["1.2 (1.0 to 1.4)", "–", "3"])
