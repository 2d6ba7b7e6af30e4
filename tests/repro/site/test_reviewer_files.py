"""Forms that reviewers read agree with each other and with what a build makes."""

import json
import re
import tomllib
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
    thesis, cited = about["referencePublication"], CITATION["preferred-citation"]
    assert about["version"] == raxel.__version__
    assert about["description"] == project["description"]
    assert about["license"].endswith(f"/{project['license']}")
    assert about["license"].endswith(f"/{CITATION['license']}")
    assert [about["name"], about["version"], about["keywords"]] == [
        CITATION[key] for key in ("title", "version", "keywords")
    ]
    assert [{"name": one["name"]} for one in about["author"]] == CITATION["authors"]
    assert [thesis["name"], thesis["datePublished"], thesis["publisher"]["name"]] == [
        cited["title"], str(cited["year"]), cited["institution"]["name"]
    ]  # fmt: skip


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
