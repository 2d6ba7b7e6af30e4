"""The page of all artefacts: findings from verdicts, previews, sources."""

import shutil

import cv2
import numpy as np
import pytest

from repro.page.furniture import Furnisher
from repro.run.results import write_atomic, write_json
from repro.site import artefacts, start
from repro.site.chapters import Document
from tests.scoreboard_rows import row
from tests.small_checkouts import ROOT

DRAWN = """from repro.run.marks import experiment, figure, table

@experiment("sweep", artefact="fig_2_6")
def sweep(effort): pass

@figure("fig_2_6", needs=("sweep",), evidence="synthetic")
def fig_2_6(results): pass

@table("ext_sizes", evidence="synthetic")
def ext_sizes(results): pass
"""
PAGE = "ch02_x/s5_page"


def claim(name, verdict, **more):
    return row(name, verdict=verdict, published=f"{name} is so.") | more


@pytest.mark.parametrize(
    ("verdicts", "output"),
    [
        ("r", "Holds: “a is so” (here: none of 9)."),
        ("rr", "All 2 decided claims hold: “a is so” (here: none of 9), and 1 more."),
        ("d", "Does not hold here: “a is so” (here: none of 9)."),
        ("ru", "Holds: “a is so” (here: none of 9)."),
        ("rrd", "2 of 3 decided claims hold; not: “c is so” (here: none of 9)."),
        ("rdd", "1 of 3 decided claims holds; not: “b is so” (here: none of 9), "
                "and 1 more."),
        ("uu", "Undecided: “a is so” (here: none of 9), and 1 more."),
        ("q", ""),
        ("", ""),
    ],
)  # fmt: skip
def test_finding_follows_claim_verdicts(verdicts, output):
    words = {"r": "reproduced", "d": "differs", "u": "undecided", "q": "quick"}
    claims = [
        claim(name, words[v], regenerated="none of 9")
        for name, v in zip("abc", verdicts, strict=False)
    ]
    assert artefacts.finding(row("fig_2_6", reason=""), claims) == output


def test_finding_includes_number_with_meaning():
    measured = {"regenerated": 1.376, "interval": [1.362, 1.388], "unit": "px"}
    one = claim("a", "differs", reason="ratio of means, 150/120; SDs 2.0") | measured
    assert artefacts.finding(row("fig_2_3", reason=""), [one]) == (
        "Does not hold here: “a is so”; "
        "here 1.376 px (1.362 to 1.388), ratio of means, 150/120."
    )


def test_finding_without_claims_is_check_or_caption():
    checked = row("fig_2_4", reason="check: it rises: 1, 2")
    assert artefacts.finding(checked, []) == "It rises: 1, 2."
    assert artefacts.finding(checked | {"verdict": "quick"}, []) == ""
    assert artefacts.finding(None, []) == ""
    caption = "Of Fig. 2.3, $x$ (a) first. (b) Second."
    assert artefacts.first_sentence(caption) == "Of Fig. 2.3, x (a) first."
    named = "A webcam of the make See! Cam before a sheet. It is bent."
    assert artefacts.first_sentence(named) == named.partition(" It")[0]


@pytest.fixture
def checkout(tmp_path):
    """A figure of the thesis and a table of ours, as their jobs leave them."""
    shutil.copytree(ROOT / "data" / "published", tmp_path / "data" / "published")
    shutil.copy(ROOT / "CITATION.cff", tmp_path)
    write_atomic(tmp_path / "chapters" / PAGE / "page.py", "# %%\n")
    write_atomic(tmp_path / "chapters" / PAGE / "figures.py", DRAWN)
    base = tmp_path / "figures" / "full"
    about = {"caption": "Steps. And more.", "source": [f"{PAGE}/figures.py", "draw"]}
    about |= {"lines": True}
    for name, read in (("fig_2_6", {"sweep": "sweep"}), ("ext_sizes", {}),
                       ("fig_9_9", {})):  # fmt: skip
        write_json(base / f"{name}.json", about | {"results": read})
    image = cv2.imencode(".png", np.full((900, 1500, 3), 255, np.uint8))[1]
    write_atomic(base / "fig_2_6.png", image.tobytes())
    columns = "<size>,size low,size high,words,c,d\n"
    write_atomic(base / "ext_sizes.csv", f"{columns}1.23456,1,2,{'long ' * 9},3,4\n")
    return tmp_path


def test_artefacts_have_cards_with_links(checkout):
    board = [row("fig_2_6", kind="artefact")]
    board.append(claim("c2_motion", "reproduced", artefacts=["fig_2_6"]))
    found = artefacts.artefacts(Furnisher(checkout, "full", ""), [PAGE], board)
    assert [a.name for a in found] == [
        "fig_2_6",
        "ext_sizes",
    ]  # none that nothing makes
    measured = "here 0.981 (0.951 to 1.022), slope in range"
    assert found[0].finding == f"Holds: “c2_motion is so”; {measured}."
    assert found[1].head == ["<size>", "words", "c"]
    assert found[1].cells == [["1.235", "long long long long l…", "3"]]
    chapter = ("Chapter 2", [Document(PAGE, "A page", "", "A page")])
    thesis = {name: {"chapter": int(name[4])} for name in ("fig_2_6", "fig_5_1")}
    shown = artefacts.page(found, [("Chapter 1", []), chapter], thesis)
    assert "Chapter 1" not in shown
    assert '<a href="#fig_2_6" aria-label="Fig. 2.6">2.6</a>' in shown
    assert "not built: Fig. 5.1<" in shown
    own, fold, more = shown.partition('<details class="rx-more"><summary>1 extension<')
    assert fold
    assert 'id="fig_2_6"' in own
    assert 'id="ext_sizes"' in more.partition("</details>")[0]
    card = shown[shown.index("<article") : shown.index("</article>")]
    for part in (
        f'<a class="rx-picture raxel-lines" href="{PAGE}.html#fig_2_6"',
        'href="figures/fig_2_6.csv"',
        f'href="source/{PAGE}/figures.py.html#draw"',
        'href="provenance/sweep.html"',
        'href="scoreboard.html#fig_2_6"',
        "<code>make fig_2_6</code>",
        "reproduced",
    ):
        assert part in card
    assert "\n\n" not in card
    figure = checkout / "figures" / "full" / "fig_2_6.json"
    figure.write_text(figure.read_text().replace('"lines": true', '"lines": false'))
    pictured = artefacts.artefacts(Furnisher(checkout, "full", ""), [PAGE], board)
    assert [a.lines for a in pictured] == [False, True]
    assert artefacts.artefacts(Furnisher(checkout, "full", ""), [], board) == []


def test_start_page_quotes_existing_values(tmp_path):
    trial = {"values": {"ours.right": 3, "ours.deep.x": 1, "n": 2}}
    write_json(tmp_path / "results" / "sweep.json", {"trials": [trial]})
    write_atomic(tmp_path / "table.csv", "a,b\n1,2\n")
    quote = start.Quotable(tmp_path)
    assert quote.trials_of("sweep") == [trial["values"]]
    assert quote.lines_of("table") == [{"a": "1", "b": "2"}]
    for name, only in (("lines", True), ("photo", False)):
        write_json(tmp_path / f"{name}.json", {"lines": only})
        assert quote.only_lines(name) is only
    assert quote.trials_of("none") == quote.lines_of("none") == []
