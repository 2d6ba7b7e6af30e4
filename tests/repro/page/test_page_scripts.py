"""What the scripts of the scoreboard and of all figures and tables do, run by Node.

`tests/page_scripts.js` stands in for the browser. Nothing else here needs Node: where
it is missing, the scripts go untested, and the tests say that they were left out. That
pages have what the scripts require is tested without it.
"""

import json
import re
import shutil
import subprocess
from html.parser import HTMLParser

import pytest

from repro.judge import scoreboard
from repro.page.furniture import Behind
from repro.site import artefacts
from repro.site import scoreboard as board_page
from tests.scoreboard_rows import ROOT, row

NODE = shutil.which("node")
STATIC = ROOT / "report" / "source" / "_static"
ENDLESS = {"input", "img", "br", "wbr"}
runs_scripts = pytest.mark.skipif(NODE is None, reason="Node is not installed")


class Tree(HTMLParser):
    """The elements of a page as [tag, attributes, children]."""

    def __init__(self, text):
        super().__init__()
        self.open = [["html", {}, []]]
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        node = [tag, {name: value or "" for name, value in attrs}, []]
        self.open[-1][2].append(node)
        if tag not in ENDLESS:
            self.open.append(node)

    def handle_endtag(self, tag):
        assert tag == self.open[-1][0], self.open[-1][:2]
        self.open.pop()

    def handle_data(self, data):
        self.open[-1][2].append(data)


def seen(script, page, *steps, hash=""):
    """What is seen of a page with its script at first, and after each step."""
    asked = {
        "tree": Tree(page).open[0],
        "script": (STATIC / script).read_text("utf-8"),
        "hash": hash,
        "steps": steps,
    }
    ran = subprocess.run(
        [NODE, ROOT / "tests" / "page_scripts.js"],
        input=json.dumps(asked),
        capture_output=True,
        text=True,
        check=False,
    )
    assert ran.returncode == 0, ran.stderr
    return json.loads(ran.stdout)


@pytest.fixture(scope="module")
def board():
    """Four rows with values, one of them in words, and one that nothing produces."""
    number = {"kind": "number", "firmness": None, "agree": None}
    rows = [
        row("n_ten", **number, published=10.0, regenerated=12.0),
        row("n_nine", **number, published=9.0, regenerated=100.0, verdict="differs"),
        row("c_words", published="It grows.", regenerated=0.5),
        row("n_none", **number, published=None, regenerated=2.0),
        row("c_later", verdict="not yet", regenerated=None),
    ]
    return board_page.page(scoreboard.checked(rows))


@runs_scripts
def test_table_head_sorts_numbers_and_empty_last(board):
    first, up, down = seen("scoreboard.js", board, {"click": "p"}, {"click": "p"})
    assert (first["sorted"], first["forms"]) == ({}, [False])
    # A row stays in its own table: what nothing produces is folded below.
    # The words of a claim stand in its head, so that its cell is empty.
    assert up["rows"] == ["n_nine", "n_ten", "n_none", "c_words", "c_later"]
    assert down["rows"] == ["n_ten", "n_nine", "n_none", "c_words", "c_later"]
    assert (up["sorted"]["p"], down["sorted"]["p"]) == ("ascending", "descending")
    assert up["sorted"]["g"] == "none"
    assert (up["hash"], down["hash"]) == ("#sort=p", "#sort=p&order=down")


@runs_scripts
def test_verdicts_sort_in_filter_order(board):
    _, by_verdict, by_value = seen(
        "scoreboard.js", board, {"click": "v"}, {"click": "g"}
    )
    listed = re.search(r'<select id="rx-verdict".*?</select>', board)[0]
    words = [w for w in re.findall(r'value="([^"]*)"', listed) if w]
    assert words.index("reproduced") < words.index("differs")
    assert by_verdict["rows"][3] == "n_nine"
    assert by_value["rows"][:4] == ["c_words", "n_none", "n_ten", "n_nine"]


@runs_scripts
def test_address_filters_and_sorts(board):
    (found,) = seen("scoreboard.js", board, hash="#kind=number&sort=g&order=down")
    assert found["rows"] == ["n_nine", "n_ten", "n_none"]
    assert found["shown"].startswith("3 of 5 rows: ")
    (odd,) = seen("scoreboard.js", board, hash="#kind=nothing")
    assert len(odd["rows"]) == 5


@runs_scripts
def test_filter_opens_matching_fold(board):
    first, later, none, named = seen(
        "scoreboard.js", board, {"fill": {"verdict": "not yet"}},
        {"fill": {"verdict": "", "q": "no such words"}}, {"hash": "#c_later"},
    )  # fmt: skip
    assert first["folds"] == [False]
    assert (later["rows"], later["folds"]) == (["c_later"], [True])
    assert later["hash"] == "#verdict=not+yet"
    assert none["shown"] == "0 of 5 rows. No row fits these filters."
    # A plain name shows all rows, and opens the fold of its own.
    assert (len(named["rows"]), named["folds"]) == (5, [True])


def all_artefacts():
    """The page of all figures and tables: one of the thesis, one extension."""
    made = [
        artefacts.Artefact(
            name=name, label="", caption="", page="p", row=None, finding="", files=[],
            behind=Behind("make", [], "s", "", "", ""), picture="",
            lines=True, head=[], cells=[],
        )
        for name in ("fig_2_3", "ext_more")
    ]  # fmt: skip
    return artefacts.page(
        made, [("Chapter 2", [Page("p", "A page")])], {"fig_2_3": {"chapter": 2}}
    )


class Page:
    """A page of the report by name and title."""

    def __init__(self, name, title):
        self.name, self.title = name, title


@runs_scripts
def test_switch_toggles_all_extensions():
    first, opened, folded = seen(
        "artefacts.js", all_artefacts(), {"checked": True}, {"checked": False}
    )
    assert first["forms"] == [False]
    assert [s["folds"] for s in (first, opened, folded)] == [[False], [True], [False]]


@runs_scripts
def test_address_of_extension_opens_fold():
    page = all_artefacts()
    (named,) = seen("artefacts.js", page, hash="#ext_more")
    assert named["folds"] == [True]
    first, later = seen("artefacts.js", page, {"hash": "#ext_more"}, hash="#fig_2_3")
    assert (first["folds"], later["folds"]) == ([False], [True])


def test_page_has_elements_of_switch():
    page = all_artefacts()
    script = (STATIC / "artefacts.js").read_text("utf-8")
    for identifier in re.findall(r'getElementById\("([^"]+)"\)', script):
        assert f'id="{identifier}"' in page
    for name in re.findall(r"form\.elements\.(\w+)", script):
        assert f'name="{name}"' in page
    for folds in re.findall(r'"details\.([\w-]+)"', script):
        assert f'<details class="{folds}">' in page
