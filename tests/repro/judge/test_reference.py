"""The accepted build: what moved since, in the scatter of the trials."""

import csv
from io import StringIO

import pytest

from repro.judge.reference import compare, entries, written
from tests.scoreboard_rows import row

ROWS = [
    row("fig_2_3", kind="artefact", regenerated="1 of 1 claims", interval=None),
    row("c2_one", regenerated=2.0, interval=[1.0, 3.0]),
    row("c2_text", regenerated="none, of 3", interval=None),
    row("c2_bound", regenerated=0.1, interval=["-inf", "inf"]),
    row("n_count", kind="number", regenerated=4, interval=None, verdict="differs"),
    row("n_none", kind="number", regenerated=None, interval=None, verdict="setting"),
]
BEFORE = entries(ROWS)


def changed(identifier, **values):
    """The entries of a build in which one row differs."""
    return entries([r | values if r["id"] == identifier else r for r in ROWS])


def test_reference_file_keeps_all_entries():
    text = written(BEFORE)
    read = {line["id"]: line for line in csv.DictReader(StringIO(text))}
    assert read == BEFORE
    assert compare(read, BEFORE) == ([], [])
    assert "1 of 1" not in text


@pytest.mark.parametrize(
    ("identifier", "value", "sds"),
    [
        # A 95 % interval of width 2 is that of a normal value with SD 2 / 3.92.
        ("c2_one", 2.0 + 1 / 3.92, 0.5),
        ("c2_one", 1.0, -1.96),
        ("n_count", 5, None),
        ("n_none", 5, None),
        ("c2_text", "none, of 4", None),
        ("c2_bound", 0.2, None),
    ],
)
def test_moved_value_is_in_standard_deviations(identifier, value, sds):
    (moved,), verdicts = compare(BEFORE, changed(identifier, regenerated=value))
    assert moved.id == identifier
    assert moved.sds == (sds if sds is None else pytest.approx(sds))
    assert verdicts == []


def test_rounding_is_no_change():
    after = changed("c2_one", regenerated=2.0 * (1 + 1e-12))
    assert compare(BEFORE, after) == ([], [])
    assert len(compare(BEFORE, changed("c2_one", regenerated=2.000001))[0]) == 1


def test_changed_verdicts_and_rows_are_listed():
    after = changed("c2_one", verdict="undecided")
    after["c2_new"] = after.pop("c2_text")
    assert compare(BEFORE, after)[1] == [
        "c2_text: not in this build",
        "c2_new: not in the reference",
        "c2_one: reproduced -> undecided",
    ]
