"""What a page shows has one label in the whole site, and a table may be empty."""

import json
from pathlib import Path

import pytest

from repro import reader


@pytest.fixture
def built(tmp_path, monkeypatch):
    """A checkout with one table made for two image sets, of which one is empty."""
    for folder in ("chapters", "data/published", "figures/quick"):
        (tmp_path / folder).mkdir(parents=True)
    for name, rows in (("one", "left.jpg,54\n"), ("two", "")):
        (tmp_path / "sets" / name).mkdir(parents=True)
        stem = tmp_path / "figures" / "quick" / f"ext_images@{name}"
        stem.with_suffix(".csv").write_text("Photograph,Corners\n" + rows)
        about = {"caption": "Photographs.", "results": {}, "evidence": "photograph"}
        stem.with_suffix(".json").write_text(json.dumps(about))
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("RAXEL_EFFORT", "quick")
    monkeypatch.setenv("RAXEL_PAGE", "photographs/one")
    return tmp_path


def shown(built: Path, name: str, monkeypatch) -> str:
    monkeypatch.setenv("RAXEL_SET", str(built / "sets" / name))
    return reader.show_table("ext_images").markdown


def test_the_same_table_of_two_sets_has_two_labels(built, monkeypatch):
    labels = [
        line
        for name in ("one", "two")
        for line in shown(built, name, monkeypatch).splitlines()
        if line.startswith(":name:")
    ]
    assert len(labels) == 2
    assert len(set(labels)) == 2


@pytest.mark.parametrize(("name", "cells"), [("one", 2), ("two", 0)])
def test_a_table_is_a_table_with_and_without_rows(built, monkeypatch, name, cells):
    text = shown(built, name, monkeypatch)
    table = "\n".join(line for line in text.splitlines() if line.startswith("|"))
    tokens = [token.type for token in _parsed(table)]
    assert tokens.count("table_open") == 1
    assert tokens.count("th_open") == 2
    assert tokens.count("td_open") == cells


def _parsed(text: str):
    from markdown_it import MarkdownIt

    return MarkdownIt("gfm-like", {"linkify": False}).parse(text)
