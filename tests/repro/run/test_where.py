"""`make where`: from an id to the files and lines behind it."""

import re
import subprocess
from functools import cache

import pytest

from repro.run import where
from repro.run.discover import producers
from tests.small_checkouts import ROOT

MADE = producers(ROOT)


@cache
def atlas():
    return where.Whereabouts(ROOT)


def source_line(root, line):
    path, _, number = line.place.rpartition(":")
    return (root / path).read_text("utf-8").splitlines()[int(number) - 1]


@pytest.mark.parametrize(
    ("identifier", "words", "algorithm"),
    [
        ("table_3_4", "page experiment algorithm table numbers claim", "celect"),
        (
            "c2_noise_linear_generic",
            "page experiment algorithm claim",
            "calibrate_zhang",
        ),
        ("t2_2_persp_rms_set1", "page experiment algorithm numbers", None),
        ("table_3_4_grids", "page experiment algorithm", "celect"),
        ("fig_2_2_error", "page experiment algorithm", "rays_from_known_motion"),
    ],
)
def test_id_leads_to_algorithm(identifier, words, algorithm):
    lines = [n for n in atlas().lines(identifier) if n.word != "set"]
    assert list(dict.fromkeys(n.word for n in lines)) == words.split()
    assert algorithm in [None, *(n.name for n in lines if n.word == "algorithm")][:4]
    for line in lines[1:]:
        assert source_line(ROOT, line).lstrip().startswith(("def ", "class "))


def test_experiments_lead_to_algorithms():
    for one in MADE:
        if one.kind == "experiment":
            assert {"experiment", "algorithm"} <= {
                line.word for line in atlas().lines(one.id)
            }, one.id
    page, short = "ch03_planar_grids/s3_2_grid_sets", "s3_2_grid_sets"
    assert atlas().lines(page) == atlas().lines(short)


def test_unknown_id_is_one_line_with_suggestion(monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    assert where.main(["table_3_44"]) == 1
    output = capsys.readouterr()
    assert output.out == ""
    assert "did you mean " in output.err
    assert "table_3_4" in output.err
    assert output.err.count("\n") == 1
    assert where.main([]) == 1


def test_listing_in_contributing_matches_output():
    text = (ROOT / "CONTRIBUTING.md").read_text("utf-8")
    listing = text.split("$ make where ")[1]
    identifier, *rows = listing.partition("...")[0].split("\n")
    printed = [
        [line.word, line.place.rpartition(":")[0], *line.name.split()]
        for line in atlas().lines(identifier)
    ]
    # Lines move; what is said of them does not.
    listed = [re.sub(r":\d+ ", " ", row).split() for row in rows if row]
    assert listed == printed[: len(listed)]


def test_make_where_does_not_build_ids():
    done = subprocess.run(
        ["make", "--dry-run", "where", "table_3_4", "s3_2_results"],
        cwd=ROOT, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert "repro.run.where 'table_3_4' 's3_2_results'" in done.stdout
    assert not done.stderr
