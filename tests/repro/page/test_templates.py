"""Names and texts that look like HTML stay text, wherever a template sets them."""

import json
import re
import shutil
from html.parser import HTMLParser

import pytest

from repro.judge import scoreboard
from repro.page import reader, rows
from repro.page.exercise import check
from repro.page.furniture import Furnisher
from repro.site import scoreboard as board_page
from repro.site.source_pages import source_page
from tests.small_checkouts import small_checkout

EVIL = "<svg onload=\"x('1')\">&amp;\"'"


class Tags(HTMLParser):
    """Tags and attributes of a text, and what a reader sees."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.values, self.text = [], [], ""
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.values += [value for _, value in attrs]
        assert not [key for key, _ in attrs if key.startswith("on")], attrs

    def handle_data(self, data):
        self.text += data


def harmless(text, *, output=True):
    """Parse it; nothing of the evil text became a tag, and all of it can be read."""
    found = Tags(text)
    assert "svg" not in found.tags
    if output:
        assert EVIL in found.text or EVIL in found.values
    return found


def evil_row(kind, **changed):
    variant = {
        "reading": {EVIL: EVIL},
        "verdict": "differs",
        "regenerated": EVIL,
        "interval": None,
        "reason": EVIL,
    }
    return {
        "id": f"c2_{kind}",
        "kind": kind,
        "chapter": EVIL,
        "words": EVIL,
        "conditions": EVIL,
        "verdict": "reproduced",
        "firmness": "some readings",
        "agree": [1, 3],
        "few_seeds": False,
        "evidence": EVIL,
        "effort": "full",
        "published": EVIL,
        "regenerated": EVIL,
        "interval": None,
        "ratio": None,
        "unit": EVIL,
        "reason": EVIL,
        "test": EVIL,
        "changed": EVIL,
        "variants": [variant, {**variant, "reading": {"a": EVIL}, "reason": ""}],
        "page": "ch02_x/x.html",
        "source": f"source/{EVIL}",
        "data": [f"results/a{EVIL}.json"],
    } | changed


EVIL_ROWS = [evil_row(kind) for kind in ("claim", "number", "artefact")]


def test_rows_escape_values():
    compared = rows.comparison(EVIL_ROWS, "full", "../", {})
    harmless(compared)
    pending = evil_row("section", verdict="not yet", regenerated=None, variants=[])
    page = board_page.page([*EVIL_ROWS, pending])
    harmless(page)
    for text in (compared, page):
        inside = text[text.index('<div id="rx-board"' if text is page else "<div") :]
        assert "\n\n" not in inside, "an empty line ends the HTML inside Markdown"
        assert text.count(EVIL) == 0
    assert scoreboard.headline(EVIL_ROWS)["changed"] == ["c2_claim", "c2_number",
                                                         "c2_artefact"]  # fmt: skip


@pytest.fixture
def built(tmp_path, monkeypatch):
    """A page with an evil name, and its figure and table."""
    base = small_checkout(tmp_path)
    for old, new in (("fig_2_3", "fig_2_3"), ("table_2_1", "table_2_1")):
        about = json.loads((base / f"{old}.json").read_text())
        about |= {"caption": EVIL, "evidence": EVIL}
        about["source"] = [f"ch02_x/set/{EVIL}.py", EVIL]
        about["results"] = [f"study{EVIL}"]
        (base / f"{new}.json").write_text(json.dumps(about))
    (base / "table_2_1.csv").write_text('"<svg onload=1>","b"\n"<svg>","1.5"\n')
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("RAXEL_EFFORT", "quick")
    monkeypatch.setenv("RAXEL_PAGE", f"ch02_x/{EVIL}")
    return tmp_path


def test_figures_tables_and_code_escape_values(built, monkeypatch):
    figure, table = reader.show("fig_2_3"), reader.show_table("table_2_1")
    harmless(figure.html)
    harmless(table.html)
    assert "<svg>" in Tags(table.html).text
    for shown in (figure, table):
        links = next(n for n in shown.markdown.splitlines() if "every trial" in n)
        found = harmless(links)
        assert f"../results/study{EVIL}.json" in found.values
    turned = next(n for n in figure.markdown.splitlines() if "<details" in n)
    assert "svg" not in Tags(turned).tags
    assert "svg" not in Tags(reader.show_code(evil_row).html).tags
    harmless(check(1.0, expected=lambda: 2.0, hint=EVIL).html)


def test_artefact_block_escapes_values(built):
    shutil.copy(built / "figures/quick/fig_2_3.json",
                built / "figures/quick/ext_x.json")  # fmt: skip
    furnisher = Furnisher(built, "quick", f"ch02_x/{EVIL}")
    harmless(furnisher.block("fig_2_3"))
    harmless(furnisher.block("ext_x"))


def test_source_page_escapes_code(tmp_path):
    path = tmp_path / "evil.py"
    path.write_text(f"TEXT = {EVIL!r}\n")
    page = source_page(path, "<svg>.py", "../")
    assert "svg" not in Tags(page).tags
    assert f"TEXT = {EVIL!r}" in Tags(page).text


def test_templates_are_found_from_any_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    output = rows.part("badge", "reproduced")
    assert re.sub("<[^>]*>", "", output) == "✓ reproduced"
