"""Rows of cells become columns of the data behind a figure."""

import pytest

from repro.run.columns import columns


def test_every_row_adds_a_cell_to_every_column():
    found = columns(("name", "x_mm"), [("a", 1.0), ("b", 2.0)])
    assert found == {"name": ["a", "b"], "x_mm": [1.0, 2.0]}
    assert columns(("name", "x_mm"), []) == {"name": [], "x_mm": []}


@pytest.mark.parametrize("row", [("a",), ("a", 1.0, 2.0)])
def test_a_row_of_another_length_is_refused(row):
    with pytest.raises(ValueError, match="zip"):
        columns(("name", "x_mm"), [row])
