"""Forms that reviewers read agree with each other and with what a build makes."""

import json
import re
import tomllib
from datetime import date
from pathlib import Path

import yaml

import raxel
from repro.judge.ledger import read_yaml
from repro.run.discover import producers

ROOT = Path(__file__).resolve().parents[3]
CITATION = read_yaml(ROOT / "CITATION.cff")
CODECHECK = (ROOT / "codecheck.yml").read_text("utf-8")
OF_CHECKER = {"codechecker", "report", "summary", "certificate"}


def test_codemeta_agrees_with_citation_and_package():
    about = json.loads((ROOT / "codemeta.json").read_text("utf-8"))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert about["@context"] == "https://w3id.org/codemeta/3.0"
    assert about["name"] == CITATION["title"]
    assert about["version"] == CITATION["version"] == raxel.__version__
    licence = about["license"].removeprefix("https://spdx.org/licenses/")
    assert licence == CITATION["license"] == project["license"]
    assert [{"name": one["name"]} for one in about["author"]] == CITATION["authors"]
    assert about["keywords"] == CITATION["keywords"]
    assert about["description"] == project["description"]
    thesis, cited = about["referencePublication"], CITATION["preferred-citation"]
    assert thesis["name"] == cited["title"]
    assert thesis["datePublished"] == str(cited["year"])
    assert thesis["publisher"]["name"] == cited["institution"]["name"]
    (author,) = cited["authors"]
    assert thesis["author"]["familyName"] == author["family-names"]


def test_codecheck_lists_outputs_of_full_build():
    """Rules of specification 2.0 that hold before a check."""
    content = yaml.safe_load(CODECHECK)
    assert CODECHECK.startswith("%YAML 1.1\n---\n")
    assert content["version"] == "https://codecheck.org.uk/spec/config/2.0/"
    assert not OF_CHECKER & set(content)
    assert not re.search("FIXME|TODO|XXX", CODECHECK)
    paper = content["paper"]
    assert paper["title"] == CITATION["title"]
    assert [{"name": one["name"]} for one in paper["authors"]] == CITATION["authors"]
    assert CITATION["preferred-citation"]["title"] in paper["reference"]
    kinds = {"figure": ".svg", "table": ".csv"}
    made = {f"{p.id}{kinds[p.kind]}" for p in producers(ROOT) if p.kind in kinds}
    for one in content["manifest"]:
        path = Path(one["file"])
        assert path.parent == Path("figures/full")
        assert path.name in made | {"scoreboard.json"}
        assert one["comment"]


def test_reproduction_log_has_dated_rows():
    _, _, log = (ROOT / "REPRODUCED.md").read_text("utf-8").partition("<!-- runs -->")
    head, _, *rows = [line.strip("| ").split(" | ") for line in log.split("\n") if line]
    assert head == ["date", "commit", "machine", "command", "time", "result"]
    dates = [date.fromisoformat(row[0]) for row in rows]
    assert dates == sorted(dates, reverse=True)
    for row in rows:
        assert len(row) == len(head)
        assert re.fullmatch("[0-9a-f]{7,12}", row[1])
        assert re.fullmatch("`make [^`]+`", row[3])
