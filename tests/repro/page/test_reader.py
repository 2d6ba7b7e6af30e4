"""What a page shows: labels, captions, numbers, and files that are missing."""

import csv
import json
import string

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from markdown_it.renderer import RendererHTML
from myst_parser.config.main import MdParserConfig
from myst_parser.parsers.mdit import create_md_parser

from repro.page import reader, wording
from repro.run.outcomes import Table
from repro.run.results import write_json
from tests.small_checkouts import ODD, small_checkout

EXTENSIONS = {"amsmath", "attrs_inline", "colon_fence", "deflist", "dollarmath"}
MYST = create_md_parser(MdParserConfig(enable_extensions=EXTENSIONS), RendererHTML)


@pytest.fixture
def built(tmp_path, monkeypatch):
    """A checkout with two tables, of which one is empty."""
    for folder in ("chapters", "data/published", "figures/quick"):
        (tmp_path / folder).mkdir(parents=True)
    for name, rows in (("one", "left.jpg,54\n"), ("two", "")):
        stem = tmp_path / "figures" / "quick" / f"ext_images_{name}"
        stem.with_suffix(".csv").write_text("Photograph,Corners\n" + rows)
        about = {"caption": "Photographs.", "results": [], "evidence": "photograph"}
        stem.with_suffix(".json").write_text(json.dumps(about))
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("RAXEL_EFFORT", "quick")
    monkeypatch.setenv("RAXEL_PAGE", "ch02_x/one")
    return tmp_path


@pytest.mark.parametrize(("name", "cells"), [("one", 2), ("two", 0)])
def test_table_without_rows_is_valid(built, name, cells):
    text = reader.show_table(f"ext_images_{name}").markdown
    table = "\n".join(line for line in text.splitlines() if line.startswith("|"))
    tokens = [token.type for token in _parsed(table)]
    assert (tokens.count("table_open"), tokens.count("th_open")) == (1, 2)
    assert tokens.count("td_open") == cells


def test_cell_has_placeholder_for_printed_number(built):
    stem = built / "figures" / "quick" / "table_4_3"
    stem.with_suffix(".csv").write_text("Method,<mm>\n<std>,0.5\nCGSP,0.25\n")
    about = {"caption": "Errors.", "results": [], "evidence": "rendered"}
    about["printed"] = {"<mm>": [None, "t4_3_x"]}
    stem.with_suffix(".json").write_text(json.dumps(about))
    table = reader.show_table("table_4_3")
    place = '<span data-raxel-printed="t4_3_x"></span>'
    assert f"| CGSP | 0.2500{place} |" in table.markdown
    assert "| --- | ---: |" in table.markdown
    assert f"<td>0.2500{place}</td>" in table.html
    assert "<td>&lt;std&gt;</td>" in table.html
    assert (table.markdown + table.html).count("t4_3_x") == 2


def test_printed_requires_one_id_per_row():
    columns = {"Method": ["std", "CGSP"], "Mean": [1.0, 2.0]}
    assert Table(columns, "", printed={"Mean": ["a", None]}).printed
    for wrong in ({"Mean": ["a"]}, {"SD": ["a", "b"]}):
        with pytest.raises(ValueError, match="give one for each row"):
            Table(columns, "", printed=wrong)


def _parsed(text: str):
    from markdown_it import MarkdownIt

    return MarkdownIt("gfm-like", {"linkify": False}).parse(text)


def test_names_and_captions_are_plain_text():
    names = "fig_2_3", "table_2_1", "alg_1", "ext_fig_2_3_readings"
    labels = ["Fig. 2.3", "Table 2.1", "Algorithm 1", ""]
    assert [wording.label(name) for name in names] == labels
    assert wording.plain("a *b* [c](d.md) $\\mathbf{x}_1 \\| y$") == "a b c x_1 | y"
    assert reader.pipe_table(["a|b"], [["1"]], [True]) == "| a\\|b |\n| ---: |\n| 1 |"


@pytest.mark.parametrize(
    ("value", "interval", "text"),
    [
        (0.11345, (0.111, 0.1162), "0.1134 px (0.1110 to 0.1162)"),
        (123.4, (100.0, 150.0), "123 px (100 to 150)"),
        # A low end that its interval's width would make 0.0 keeps two digits.
        (2.399, (0.0448, 4.4028), "2.4 px (0.045 to 4.4)"),
        (0.41, (0.0, 2.68), "0.4 px (0.0 to 2.7)"),
        (0.41, (1e-9, 2.68), "0.4 px (0.0 to 2.7)"),
        (2.0, (2.0, 2.0), "2 px"),
        (0.123456, None, "0.123 px"),
        (1000, None, "1000 px"),
        (1234.5, None, "1234 px"),
        (2.5e7, None, "2.5e+07 px"),
        ("exact", None, "exact px"),
    ],
)
def test_numbers_are_rounded_by_interval(value, interval, text):
    assert wording.rounded(value, interval, "px") == text


@pytest.mark.parametrize(
    ("number", "text"),
    [
        ((0.999998, None), "0.999998"),
        ((1.0007, None, "1"), "1.0007"),
        ((-0.9999, None), "-0.9999"),
        ((1 - 1e-14, None, "px"), "1 px"),
        ((12, None, "count"), "12"),
        ((0.9999980, (0.9999979, 0.9999981)), "0.999998 (0.999998 to 0.999998)"),
    ],
)
def test_numbers_near_1_keep_digits(number, text):
    assert wording.rounded(*number) == text


@pytest.mark.parametrize(
    ("cells", "shown"),
    [
        (["0.2", "0.18844", "–", "0.21541"], ["0.200", "0.188", "–", "0.215"]),
        (["12.34", "-0.5"], ["12.3", "-0.5"]),
        (["1234.5", "0.012"], ["1.23e+03", "0.012"]),
        (["7e-14", "2.25e-14"], ["7e-14", "2.25e-14"]),
        (["54", "52"], ["54", "52"]),
        (["100.0", "93.51851"], ["100", "94"]),
        (["nan", "0.0", "0.25", "0.5"], ["nan", "0", "0.250", "0.500"]),
    ],
)
def test_column_numbers_have_equal_decimals(cells, shown):
    assert wording.alike(cells, 3) == shown


def test_missing_file_names_command(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("RAXEL_EFFORT", raising=False)
    with pytest.raises(
        reader.Missing, match=r"fig_2_3\.json is missing; `make fig_2_3`"
    ):
        reader.show("fig_2_3")


@pytest.mark.parametrize("lines", [True, False])
def test_figure_without_images_is_marked_for_dark_mode(tmp_path, monkeypatch, lines):
    base = small_checkout(tmp_path)
    about = json.loads((base / "fig_2_3.json").read_text("utf-8"))
    write_json(base / "fig_2_3.json", about | {"lines": lines})
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("RAXEL_EFFORT", "quick")
    assert (":class: raxel-lines" in reader.show("fig_2_3").markdown) is lines


def only_text_of(markdown):
    """The text of one paragraph or table cell of MyST that holds nothing else."""
    begin, inline, end, *rest = MYST.parse(markdown)
    assert (begin.type, end.type, rest) == ("paragraph_open", "paragraph_close", [])
    assert {child.type for child in inline.children} <= {"text", "text_special"}
    return "".join(child.content for child in inline.children)


@settings(max_examples=300, deadline=None)
@given(st.text(st.sampled_from(string.punctuation + " 1a\té"), min_size=1))
def test_literal_escapes_markdown(text):
    wanted = " ".join(text.split())
    if wanted:
        assert only_text_of(wording.literal(text)) == wanted
        assert wording.unescaped(wording.literal(text)) == wanted
        assert wording.plain(wording.literal(text)) == wanted


@pytest.mark.parametrize("name", ODD)
def test_unusual_name_is_escaped_everywhere(built, name):
    wanted = " ".join(name.split())
    assert only_text_of(f"See {wording.literal(name)}.") == f"See {wanted}."
    stem = built / "figures" / "quick" / "ext_images_one"
    with stem.with_suffix(".csv").open("w", newline="") as file:
        csv.writer(file).writerows([["Photograph", "Corners"], [name, "1.234567"]])
    about = json.loads(stem.with_suffix(".json").read_text()) | {
        "texts": ["Photograph"], "caption": wording.literal(name)
    }  # fmt: skip
    stem.with_suffix(".json").write_text(json.dumps(about))
    markdown = reader.show_table("ext_images_one").markdown
    table = "\n".join(x for x in markdown.splitlines() if x.startswith("| "))
    cells = [t for t in MYST.parse(table) if t.type == "inline"]
    assert [len(cells), cells[-1].content] == [4, "1.235"]
    assert {c.type for c in cells[2].children} <= {"text", "text_special"}
    assert "".join(c.content for c in cells[2].children) == wanted


def test_control_characters_are_removed():
    assert wording.literal("a\x1b[31mb\u202ec\x00\n") == r"a \[31mb c"
