"""The site's source: chapters in order, guides announced, only what differs written."""

import json

import nbformat
import pytest
from nbformat.v4 import new_markdown_cell, new_notebook

from repro.judge import scoreboard
from repro.page.notebook import PageError
from repro.run.results import write_atomic, write_json
from repro.site import assemble
from repro.site.chapters import chapters_of, summary_of
from tests.small_checkouts import small_checkout


def test_chapters_are_in_thesis_order(tmp_path):
    books = []
    names = [
        "guides/s1_first",
        "more/b10",
        "more/b9",
        "appendix_a/s1",
        "ch10_x/s1",
        "ch02_x/s1",
    ]
    for name in names:
        book = tmp_path / f"{name}.ipynb"
        cell = {"cell_type": "markdown", "source": [f"# {name}\n"]}
        write_json(book, {"cells": [cell]})
        package = tmp_path / "chapters" / book.parent.name / "__init__.py"
        write_atomic(package, f'"""About {book.parent.name}."""\n')
        books.append(book)
    chapters = chapters_of(tmp_path, books, {})
    assert [c.number for c in chapters] == ["2", "10", "A", "", ""]
    assert [c.guides for c in chapters] == [False, False, False, True, False]
    assert [p.title for p in chapters[4].pages] == ["more/b9", "more/b10"]
    assert chapters[0].title == "About ch02_x"
    write_atomic(tmp_path / "chapters" / "ch02_x" / "__init__.py", "")
    with pytest.raises(PageError, match=r"ch02_x/__init__\.py: no docstring"):
        chapters_of(tmp_path, books, {})


def test_pages_are_in_section_order(tmp_path):
    titles = {
        "s4_1_steps": "2.4.1 and 2.4.2 Steps",
        "s4_all": "2.4 All of it",
        "ext_why": "Why it fails",
        "s10": "2.10 Late",
        "s10_before": "2.10 Before: it",
        "ext_s10": "2.10 More",
        "ext_next": "6.3 Next",
    }
    books = []
    for name, title in titles.items():
        cell = {"cell_type": "markdown", "source": [f"# {title}\n"]}
        books.append(tmp_path / f"ch02_x/{name}.ipynb")
        write_json(books[-1], {"cells": [cell]})
        write_atomic(tmp_path / f"chapters/ch02_x/{name}/page.py", "")
    write_atomic(tmp_path / "chapters/ch02_x/__init__.py", '"""Chapter 2: x."""\n')
    held = {"ch02_x/s10": ["fig_2_10"], "ch02_x/s10_before": ["fig_2_9"]}
    (chapter,) = chapters_of(tmp_path, books, held)
    assert chapter.pages[2].entry == "2.10 Before: Fig. 2.9"
    assert [page.name.removeprefix("ch02_x/") for page in chapter.pages] == [
        "s4_all",
        "s4_1_steps",
        "s10_before",
        "s10",
        "ext_s10",
        "ext_next",
        "ext_why",
    ]


@pytest.mark.parametrize(
    ("text", "summary"),
    [
        ("# T\n\nA [way](x.md) to\n*go*, $x$.\n\nMore.", "A way to go, x."),
        ("# T\n\n## Next\n\nText.", ""),
        ("# T\n\n| a |\n| - |\n", ""),
        ("# T\n", ""),
    ],
)
def test_guide_is_listed_with_first_paragraph(tmp_path, text, summary):
    path = tmp_path / "guide.md"
    path.write_text(text)
    assert summary_of(path) == summary


def write_page(book, source, *paragraphs):
    """An executed page as the job before leaves it."""
    about = {"source": source, "effort": "quick", "page": "a/page"}
    cells = [new_markdown_cell(text) for text in paragraphs]
    notebook = new_notebook(cells=cells, metadata={"raxel": about})
    write_atomic(book, nbformat.writes(notebook))


def test_start_page_lists_guides_and_chapters(tmp_path):
    small_checkout(tmp_path)
    books = []
    for name in ("guides/which_method", "guides/teachers", "ch02_sample/s5_page"):
        title = name.rpartition("/")[2].replace("_", " ")
        book = tmp_path / "pages" / f"{name}.ipynb"
        write_page(book, f"{name}/page.py", f"# {title}", f"About {title}.")
        write_atomic(tmp_path / "chapters" / name / "page.py", "# %%\n")
        books.append(book)
    write_atomic(tmp_path / "chapters" / "guides" / "__init__.py", '"""Guides."""\n')
    base, out = tmp_path / "figures" / "quick", tmp_path / "source"
    boards = (base / "scoreboard.md", base / "scoreboard.json")
    assemble.assemble(tmp_path, "quick", books, *boards, out)
    start = (out / "index.md").read_text("utf-8")
    places = [
        start.index(text)
        for text in (
            "{grid-item-card} Chapter 2: a sample\n",
            "{grid-item-card} Guides\n:link: guides/index\n:link-type: doc\n",
            "\nteachers; \nwhich method.\n",
            "{toctree}",
            "guides/index\nch02_sample/index\nartefacts\nscoreboard\n",
        )
    ]
    assert places == sorted(places)


def test_image_sets_are_published_and_linked(tmp_path):
    base = small_checkout(tmp_path)
    boards = (base / "scoreboard.md", base / "scoreboard.json")
    sets = tmp_path / "report" / "build" / "sets"
    for name, message in (("lens", ""), ("flat", "flat/set.yaml: <b>: `x`")):
        files = [] if message else ["camera.npz", "report/index.html"]
        about = {"name": name, "message": message, "files": files}
        write_json(sets / f"{name}.json", about)
        for file in files:
            write_atomic(sets / name / file, "")
    # Of an earlier build, and may be private.
    write_atomic(sets / "gone" / "camera.npz", "")
    records = [sets / "lens.json", sets / "flat.json"]
    assemble.assemble(tmp_path, "quick", [], *boards, tmp_path / "source", records)
    published = assemble.files_below(tmp_path / "source" / "_extra" / "sets")
    assert set(published) == {"lens/camera.npz", "lens/report/index.html"}
    for page in ("index", "your_photographs"):
        text = (tmp_path / "source" / f"{page}.md").read_text("utf-8")
        assert '<a href="sets/lens/report/index.html">lens</a>' in text
        assert '<a href="sets/lens/camera.npz">camera.npz</a>' in text
        assert "\n- flat: not calibrated. flat/set.yaml: \\<b\\>: \\`x\\`\n" in text
    assemble.assemble(tmp_path, "quick", [], *boards, tmp_path / "source")
    assert "calibrated." not in (tmp_path / "source" / "index.md").read_text("utf-8")


def test_counts_are_in_verdict_order():
    rows = [
        {"id": "c", "kind": "claim", "verdict": v, "chapter": c}
        | {"firmness": None, "changed": ""}
        for v, c in (("not yet", 5), ("reproduced", 2), ("quick", 2), ("not yet", "A"))
    ]
    counted = scoreboard.headline(rows)
    assert list(counted["verdict"].items()) == [
        ("reproduced", 1),
        ("not yet", 2),
        ("quick", 1),
    ]
    assert [r["number"] for r in assemble.chapter_table(rows, [])] == ["2", "5", "A"]
    json.dumps(counted)


def start_page(root, base, pages=()):
    """The start page of a small checkout with these pages."""
    books = []
    for name in pages:
        book = root / "pages" / f"{name}.ipynb"
        write_page(book, f"{name}/page.py", f"# About {name}")
        write_atomic(root / "chapters" / name / "page.py", "# %%\n")
        write_atomic(root / f"chapters/{book.parent.name}/__init__.py", '"""T."""\n')
        books.append(book)
    boards = (base / "scoreboard.md", base / "scoreboard.json")
    assemble.assemble(root, "quick", books, *boards, root / "source")
    return (root / "source" / "index.md").read_text("utf-8")


def test_start_page_begins_with_summary_and_example(tmp_path):
    base = small_checkout(tmp_path)
    fit = "images: 9\nmodel: cgsp: best\nerror: held-out boards, RMS 0.028 px\nmore\n"
    trials = {
        "ext_fisheye_found": {"output.corners": "found in 9 of 9\n", "boards": 9},
        "ext_fisheye_camera": {"output.calibrate": fit},
        "ext_fisheye_look": {"output.undistort": "9 images in straight\n"},
    }
    for name, values in trials.items():
        write_json(base / f"results/{name}.json", {"trials": [{"values": values}]})
    write_atomic(base / "ext_fisheye_views.svg", "<svg/>")
    start = start_page(tmp_path, base, ["guides/fisheye_in_ten_minutes"])
    first = start.split("\n\n")[1]
    assert first.startswith("raxel is a library and a command that calibrate")
    heading = "## Example: calibrate a fisheye"
    job = start[start.index(heading) : start.index("## Does the thesis hold")]
    assert "183° from 9 images of a chessboard" in job
    lines = "\n".join(fit.splitlines()[1:3])
    for line in ("found in 9 of 9", lines, "9 images in straight"):
        assert f"\n{line}\n" in job
    assert "images: 9\n" not in job
    assert 'src="figures/ext_fisheye_views.svg"' in job
    (base / "ext_fisheye_views.svg").unlink()
    assert heading not in start_page(tmp_path, base)


def test_start_page_shows_findings_with_figure_and_page(tmp_path):
    base = small_checkout(tmp_path)
    page = "ch04_central_generic/s1_5_simulated"
    rows = "as_printed,84.2\ncgsp,0.737\nwell_conditioned,0.804\n"
    figure = base / "ext_what_cgsp_buys_figure.csv"
    write_atomic(figure, f"method,median_mm\n{rows}")
    assert "0.737 mm" not in start_page(tmp_path, base, [page])
    write_atomic(figure.with_suffix(".svg"), "<svg/>")
    write_atomic(figure.with_suffix(".json"), '{"lines": true}')
    start = start_page(tmp_path, base, [page])
    found = start[start.index("## Five findings") : start.index("## Does the thesis")]
    for output in ("centre of 0.737 mm", "84.2 mm", "reaches 0.804 mm"):
        assert output in found
    link = f'<a href="{page}.html#ext_what_cgsp_buys_figure">'
    assert f'{link}<img class="raxel-lines" src="figures/' in found
    assert found.count("<figure") == 1
    assert "0.737 mm" not in start_page(tmp_path, base)
