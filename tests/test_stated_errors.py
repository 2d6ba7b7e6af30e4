"""The record of stated errors: what it must hold, and what its page says of it."""

import re
from pathlib import Path

import numpy as np
import pytest

from chapters.guides.stated_errors import figures, tables
from chapters.guides.stated_errors.results import RECORD_RUN, facts, groups
from chapters.shared.records import record
from repro.page.style import check_axes
from tests.made_results import plan_of, written

PARTS = {one["part"]: one["rows"] for one in record("stated")["sets"]}
TABLES = {
    "corners": tables.corners,
    "boards": tables.boards,
    "decoding": tables.decoding,
    "decoding_hard": tables.decoding_hard,
    "calibration": tables.calibration,
    "tables": tables.tables_of_rays,
    "pupil": tables.pupil,
    "readers": tables.readers,
}
WITHIN = "within1", "within2", "within3"


@pytest.fixture(scope="module")
def results():
    return {RECORD_RUN: written(plan_of(RECORD_RUN))}


def test_the_record_has_the_parts_that_are_shown():
    assert sorted(PARTS) == sorted(TABLES)


def test_counts_of_the_record_add_up():
    for row in PARTS["boards"]:
        assert row["right"] + row["wrong"] + row["refused"] == row["pictures"] > 0
    for row in PARTS["readers"]:
        assert row["read"] + row["refused"] + row["faults"] == row["mutants"] >= 2000
    for row in PARTS["pupil"]:
        if row["moves"] is not None:
            assert row["moves"] + row["undecided"] + row["rests"] == row["count"]
    for row in PARTS["tables"]:
        assert 0 <= row["unstable"] <= row["count"]
    for name in ("corners", "decoding", "decoding_hard", "calibration"):
        for row in PARTS[name]:
            if row["count"] is not None:
                shares = [row[name] for name in WITHIN]
                assert 0 <= shares[0] <= shares[1] <= shares[2] <= 100


@pytest.mark.parametrize("part", TABLES)
def test_a_table_shows_every_row(results, part):
    shown = TABLES[part](results)
    assert list(shown.columns["Case"]) == [row["case"] for row in PARTS[part]]


def test_a_message_is_shown_by_its_start():
    assert tables._start("sines (a.png, b.png) do not fit: mend x; or y") == (
        "sines do not fit"
    )
    assert tables._start(None) == ""


def test_the_figure_leaves_no_set_out(results):
    for part in ("corners", "decoding", "decoding_hard", "calibration"):
        masks = [
            own for _, name, own in groups(results[RECORD_RUN]).values() if name == part
        ]
        assert np.array_equal(np.sum(masks, axis=0), np.ones(len(PARTS[part])))
    drawn = figures.ext_stated_coverage(results)
    check_axes(drawn.figure, "stated")
    ratios = [
        row["ratio"]
        for part in ("corners", "decoding", "decoding_hard", "calibration")
        for row in PARTS[part]
        if row["ratio"] is not None
    ]
    assert sorted(drawn.data["error over stated"]) == sorted(ratios)


def test_the_page_quotes_what_the_record_says(results):
    page = Path("chapters/guides/stated_errors/page.py").read_text()
    found = facts(results[RECORD_RUN])
    assert set(re.findall(r"\{glue:text\}`([^`]+)`", page)) <= set(found)
    photographs = [
        row
        for row in PARTS["boards"]
        if "not given" not in row["case"] and "-" in row["case"]
    ]
    for name in ("pictures", "right", "wrong", "refused"):
        assert found[f"boards.given.{name}"] == sum(row[name] for row in photographs)
    sound = [
        row
        for row in PARTS["calibration"]
        if row["case"].startswith(("sound", "corners err together", "each photograph"))
    ]
    said = "shape", "corners", "halves", "focal", "erratic", "odd"
    assert found["sets.false"] == sum(row[name] for row in sound for name in said)
    assert found["focal.most"] == pytest.approx(
        max(row["rms"] for row in sound), rel=5e-3
    )
    near = [row for row in PARTS["calibration"] if "1 % apart" in row["case"]]
    assert found["near.told"] == sum(row["halves"] + row["focal"] for row in near)
    assert found["readers.faults"] == sum(row["faults"] for row in PARTS["readers"])
