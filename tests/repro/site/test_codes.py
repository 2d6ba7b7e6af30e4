"""Codes in prose and in HTML lead to the ledger's pages, and to nothing else."""

import re

import pytest
from docutils import nodes
from docutils.core import publish_doctree

from repro.judge import ledger
from repro.site.codes import link_codes, linked_html
from repro.site.ledger_pages import codes, errata_page, ledger_pages
from tests.scoreboard_rows import row
from tests.small_checkouts import ROOT

KNOWN = {"E-2.10": "errata.html#E-2.10", "c2_motion": "scoreboard.html#c2_motion"}
LINK = '<a href="../errata.html#E-2.10">E-2.10</a>'


@pytest.mark.parametrize(
    ("html", "linked"),
    [
        ("<p>(E-2.10, E-9.99)</p>", f"<p>({LINK}, E-9.99)</p>"),
        ('<i title="E-2.10">E-2.10</i>', f'<i title="E-2.10">{LINK}</i>'),
        ('<a href="x">E-2.10 <code>c2_motion</code></a>', None),
        ("<pre>E-2.10</pre><h3>E-2.10</h3>", None),
        ("<code>f(E-2.10)</code>", None),
        ("c2_motion.csv, x/c2_motion, c2_motion(), c2_motions", None),
        ("(c2_motion)", '(<a href="../scoreboard.html#c2_motion">c2_motion</a>)'),
        (
            "<td><code>c2_<wbr>motion</code></td>",
            '<td><a href="../scoreboard.html#c2_motion"><code>c2_<wbr>motion</code></a>'
            "</td>",
        ),
        ("<code>c2_other</code> a < b E-2.10", f"<code>c2_other</code> a < b {LINK}"),
    ],
)
def test_codes_in_html_become_links(html, linked):
    assert linked_html(html, KNOWN, "../") == (linked or html)


def test_codes_in_prose_become_links():
    text = """
About E-2.10
============

|open| E-2.10 |close| See E-2.10 and E-9.99, `E-2.10 <x.html>`_,
``c2_motion``, ``E-2.10`` and ``other``.

.. |open| raw:: html

   <a href="x">

.. |close| raw:: html

   </a>

.. raw:: html

   <b>E-2.10</b>
"""
    doctree = publish_doctree(text)
    before = doctree.astext()
    link_codes(doctree, KNOWN, "../")
    links = [node for node in doctree.findall(nodes.reference) if node.get("internal")]
    assert [(link["refuri"], link.astext()) for link in links] == [
        ("../errata.html#E-2.10", "E-2.10"),
        ("../scoreboard.html#c2_motion", "c2_motion"),
        ("../errata.html#E-2.10", "E-2.10"),
    ]
    *_, raw = doctree.findall(nodes.raw)
    assert raw.astext() == f"<b>{LINK}</b>"
    assert doctree.astext().replace(LINK, "E-2.10") == before


def test_ledger_entries_have_anchors():
    book = ledger.load(ROOT)
    pages = ledger_pages(ROOT, book)
    found = codes(ROOT, book, [row("c2_motion")])
    ids = {
        name.replace(".md", ".html"): set(re.findall(r'id="([^"]+)"', text))
        for name, text in pages.items()
    }
    for code, address in found.items():
        page, _, anchor = address.partition("#")
        assert code == "c2_motion" or anchor in ids[page], code
    named = {*book.settings, *book.readings}
    assert {name for name in named if "_" in name} < set(found)
    assert "noise" in named - set(found)
    text = (ROOT / ledger.FOLDER / "errata.md").read_text("utf-8")
    assert len(re.findall(r"^- \*\*E-", text, re.MULTILINE)) == len(ids["errata.html"])
    assert errata_page("- **E-1.01** (derived) x") == (
        '- <span id="E-1.01"></span>**E-1.01** (derived) x'
    )
