"""What is below an artefact: the original in words, code, provenance, citation."""

import json
import shutil

import pytest
from nbformat import v4

from repro.judge.ledger import LedgerError
from repro.page.furniture import Furnisher, in_words
from repro.page.reader import mark
from repro.page.templates import part
from tests.small_checkouts import ROOT


@pytest.fixture
def furnisher(tmp_path):
    """Furniture of a page of a checkout with two artefacts."""
    shutil.copytree(ROOT / "data" / "published", tmp_path / "data" / "published")
    shutil.copy(ROOT / "CITATION.cff", tmp_path)
    base = tmp_path / "figures" / "full"
    base.mkdir(parents=True)
    about = {"source": ["ch02_x/s5_page/figures.py", "draw"]}
    described = json.dumps(about | {"results": ["sweep", "other"]})
    for name in ("fig_2_6", "ext_corners"):
        (base / f"{name}.json").write_text(described)
    return Furnisher(tmp_path, "full", "ch02_x/s5_page")


def test_original_axes_are_described(furnisher):
    block = furnisher.block("fig_2_6")
    for text in (
        "Fig. 2.6, section 2.5.2 (Experiments with Real Data, from p. 45)",
        "x: translation; y: translation; series: standard perspective",
        "step (mm): 25",
        'href="../source/ch02_x/s5_page/figures.py.html#draw"',
        'href="../provenance/sweep.html"',
        "note = {Fig. 2.6}",
        "Dunne, Aubrey K.",
    ):
        assert text in block
    assert "\n\n" not in block


def test_block_of_extension_has_no_original(furnisher):
    block = furnisher.block("ext_corners")
    assert "In the thesis" not in block
    assert block.count("../provenance/") == 2
    assert "comparison" not in block
    assert "version 0.1.0, ext_corners." in block


def test_block_has_command_time_and_comparison(furnisher):
    block = furnisher.block("fig_2_6")
    assert "<code>make fig_2_6</code>" in block
    assert 'href="../scoreboard.html#fig_2_6">comparison</a>' in block
    quick = Furnisher(furnisher.root, "quick", "")
    assert quick._command("fig_2_6") == "make fig_2_6 EFFORT=quick"


def test_placeholder_is_replaced_by_block(furnisher):
    markdown = f"Before.\n\n{mark('fig_2_6')}\n\nAfter."
    outputs = [
        v4.new_output("display_data", {"text/markdown": text, "text/html": text})
        for text in (markdown, "plain")
    ]
    notebook = v4.new_notebook(cells=[v4.new_code_cell("show()", outputs=outputs)])
    furnisher.fill(notebook)
    first, second = (output.data for output in notebook.cells[0].outputs)
    assert first["text/markdown"].startswith("Before.\n\n<p class=")
    assert first["text/markdown"].endswith("</details>\n\nAfter.")
    assert first["text/html"] == markdown
    assert second["text/markdown"] == "plain"


def test_printed_number_is_inserted_in_cell(furnisher):
    name = "t4_3_omni_cgsp_mean_pre"
    place = part("printed_mark", name)
    shown = {
        "text/markdown": f"| 0.03 {place} |\n\n{mark('fig_2_6')}",
        "text/html": f"<td>0.03{place}</td>",
    }
    outputs = [v4.new_output("display_data", shown)]
    notebook = v4.new_notebook(
        cells=[v4.new_code_cell("show_table()", outputs=outputs)]
    )
    furnisher.fill(notebook)
    found = notebook.cells[0].outputs[0].data
    line = found["text/markdown"].splitlines()[0]
    assert f'thesis&nbsp;<a href="../scoreboard.html#{name}">0\\.19</a>' in line
    assert "thesis&nbsp;0.19</small></td>" in found["text/html"]
    # Bars would end the cell of a table in Markdown.
    assert furnisher._printed(["", "t3_1_s1"]).count("|") == 2
    assert furnisher._printed(["", "t3_1_s1"]).count("\\|") == 2
    with pytest.raises(LedgerError, match="not in numbers"):
        furnisher._printed(["", "t4_3_none"])


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (None, ""),
        ([1, [2, "a<b"]], "1, 2, a&lt;b"),
        ({"a,b": {"x": "place"}}, "<b>(a,b)</b>: x: place"),
        (
            {"fov_deg": [30, 150], "seen": True},
            "field of view (degrees): 30, 150; seen: yes",
        ),
    ],
)
def test_ledger_values_become_phrases(value, words):
    assert in_words(value) == words


def test_sections_of_artefacts_have_pages(furnisher):
    for entry in furnisher.book.artefacts.values():
        assert str(entry["section"]) in furnisher.sections
