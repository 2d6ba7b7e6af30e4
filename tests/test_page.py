"""From page file to site: execution, assembling, rendering only what changed."""

import json
import os
import re
import shutil
from pathlib import Path

import nbformat
import numpy as np
import pytest

from repro import assemble, exercise, reader, scoreboard, style
from repro.check_site import check_site
from repro.jobs import csv_text
from repro.mirror import mirror
from repro.notebook import PageError, read_page, settle
from repro.outcomes import Drawing
from repro.page import main
from repro.results import write_atomic, write_json
from repro.scene import Points, Scene
from repro.scene_page import scene_html
from repro.site import build_site, without_source

ROOT = Path(__file__).parents[1]

PAGE = """# %% [markdown]
# # 2.5 A page
#
# The value is {glue:text}`n_one.text`; half of it is {glue:text}`half:.2f` px.
# See [Fig. 2.3](#fig_2_3), [Table 2.1](#table_2_1), {cite}`zhang2000` and the
# [order of coordinates](../conventions.md#plucker).
#
# $$
# M = \\begin{bmatrix} 1 & 0 \\\\ 0 & 1 \\end{bmatrix}
# \\tag{2.11}
# $$

# %%
from repro.exercise import check
from repro.reader import open_results, show, show_code, show_table, value, values


def half_of(number):
    '''Half of ``number``.'''
    return number / 2


# %% tags=["active-ipynb"]
# values()

# %% tags=["active-ipynb"]
# value("half", half_of(open_results("sweep").column("x").mean()))

# %% tags=["active-ipynb"]
# show("fig_2_3")

# %% tags=["active-ipynb"]
# show_table("table_2_1")

# %% tags=["active-ipynb"]
# show_code(csv_text)

# %% tags=["active-ipynb"]
# check(0.5, expected=lambda: half_of(1.0))

# %% tags=["active-py"]
if __name__ == "__main__":
    raise SystemExit("the notebook has no command line")
""".replace("# show_code(csv_text)", "# show_code(check)")


LIBRARY = '''"""Lines: M = [a|b], `nan` where not valid."""


class Line:
    """A line through *two* points, (N, 3) each, #1 and $2."""

    places: int

    def __init__(self, a, b):
        self._a = a

    @property
    def length(self) -> float:
        """Its length, mm."""

    def moved(self, by, *, very_long_name_of_an_argument=1.0, another_argument=None):
        """The line moved.

            code = here

        Aligned:
          a   one
        """


def _hidden():
    """Nobody reads this."""
'''


@pytest.fixture
def page(tmp_path):
    def write(text, name="s5_page"):
        path = tmp_path / "chapters" / "ch02_sample" / f"{name}.py"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, "utf-8")
        return path

    return write


def run(page_file, out, *more):
    """Execute a page as the workflow does; return the exit status."""
    return main(
        ["execute", str(page_file), "--effort", "quick", "--out", str(out), *more]
    )


def small_checkout(root):
    """Figures, results and a scoreboard, as the jobs before the pages leave them."""
    base = root / "figures" / "quick"
    shutil.copytree(ROOT / "data" / "published", root / "data" / "published")
    shutil.copy(ROOT / "CITATION.cff", root)
    drawn, axes = style.figure()
    axes.plot([0, 1], [0, 1])
    axes.set(xlabel="Noise (px)", ylabel="Residual (px)")
    caption = "Residual against noise $\\sigma$."
    style.save_drawing(Drawing(drawn, {"noise_px": [0, 1]}, caption), base / "fig_2_3")
    about = {"caption": caption, "evidence": "synthetic", "results": {"sweep": "sweep"}}
    about |= {"source": ["ch02_sample/s5_page.py", "half_of"], "scene": False}
    write_json(base / "fig_2_3.json", about | {"scene": True})
    scene = Scene([Points([[0, 0, 0]], "k")], (0, 0, -5), (0, 0, 1))
    write_atomic(base / "fig_2_3.html", scene_html(scene, "Fig. 2.3"))
    columns = {"i": ["1", "2"], "V_i": ["$|a|$", "0"], "residual": [1.23456, 2.0]}
    write_atomic(base / "table_2_1.csv", csv_text(columns))
    write_json(base / "table_2_1.json", about | {"results": {}, "caption": "Cells."})
    write_json(
        base / "results" / "sweep.json",
        {
            "experiment": "sweep",
            "effort": "quick",
            "settings": {},
            "conditions": [{}],
            "trials_per_condition": 2,
            "trials": [{"condition": 0, "values": {"x": x}} for x in (1.0, 2.0)],
        },
    )
    number = {"value": 0.11345, "interval": [0.111, 0.1162], "unit": "px"}
    run = {"seconds": 1.5, "host": "some-machine", "versions": {"numpy": "2"}}
    write_json(base / "results" / "sweep.run.json", run)
    write_json(
        base / "judged" / "ch02_sample" / "s5_page.json", {"numbers": {"n_one": number}}
    )
    kinds = [("artefact", "not yet"), ("claim", "differs"), ("number", "setting")]
    write_json(
        base / "scoreboard.json",
        [{"id": k, "kind": k, "chapter": 2, "verdict": v} for k, v in kinds],
    )
    write_atomic(base / "scoreboard.md", "# Scoreboard\n\nRows.\n")
    chapter = root / "chapters" / "ch02_sample" / "__init__.py"
    write_atomic(chapter, '"""Chapter 2: a sample.\n\nIts introduction.\n"""\n')
    library = root / "lib" / "raxel" / "rays" / "lines.py"
    write_atomic(library, LIBRARY)
    write_atomic(library.with_name("__init__.py"), '"""Rays | of <cameras>."""\n')
    write_atomic(library.parents[1] / "__init__.py", '"""A *library*."""\n')
    source = {
        name: path
        for name, path in assemble.files_below(ROOT / "report" / "source").items()
        if path.suffix != ".pyc"
    }
    mirror(source, root / "report" / "source")
    write_atomic(root / "data" / "recorded" / "README.md", "# Your own photographs\n")
    return base


def test_one_page_becomes_a_site_and_only_what_changed_is_rendered(
    page, tmp_path, monkeypatch
):
    base = small_checkout(tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(ROOT / "lib"))
    book = Path("report/build/quick/pages/ch02_sample/s5_page.ipynb")
    source, site = Path("report/build/quick/source"), Path("report/site-quick")

    def build():
        boards = (base / "scoreboard.md", base / "scoreboard.json")
        assemble.assemble(tmp_path, "quick", [book], *boards, source)
        return build_site(source, site)

    assert run(page(PAGE).relative_to(tmp_path), book) == 0
    build()
    assert check_site(site) == []
    text = (site / "ch02_sample" / "s5_page.html").read_text("utf-8")
    assert "The value is 0.1134 px (0.1110 to 0.1162); half of it is 0.75 px." in text
    assert "<strong>Fig. 2.3.</strong> Residual against noise" in text
    assert 'alt="Fig. 2.3 Residual against noise sigma."' in text
    assert 'id="fig_2_3"' in text
    assert 'id="table_2_1"' in text
    assert "1.235" in text
    assert "The library computes the same." in text
    assert r"\end{split}\tag{2.11}\end{equation}" in text
    assert "command line" not in text
    assert 'data-src="../figures/fig_2_3.html"' in text
    assert "data-raxel-about" not in text
    assert "section 2.5.1 (Experiments with Synthetic Data, from p. 43)" in text
    assert "<b>(b)</b>: x: field of view (deg), 30..150; y: distortion" in text
    assert "@phdthesis{dunne2009," in text
    assert 'href="../source/ch02_sample/s5_page.py.html#half_of"' in text
    assert 'href="../logs/sweep.json"' in text
    assert "some-machine" not in (site / "logs" / "sweep.json").read_text()
    reference = (site / "api" / "rays.html").read_text("utf-8")
    assert "A line through *two* points, (N, 3) each, #1 and $2." in reference
    assert "Rays | of &lt;cameras&gt;." in reference
    assert 'id="raxel.rays.lines.Line"' in reference
    assert "Nobody reads this" not in reference
    index = (site / "index.html").read_text("utf-8")
    assert "<strong>3</strong> rows" in index
    assert "<strong>1</strong> differs" in index
    for name in (
        "scoreboard.json",
        "figures/fig_2_3.svg",
        "figures/fig_2_3.png",
        "figures/fig_2_3.csv",
        "figures/fig_2_3.html",
        "figures/table_2_1.csv",
        "logs/sweep.json",
        "source/ch02_sample/s5_page.py.html",
        "source/raxel/rays/lines.py.html",
        "api/index.html",
        "results/sweep.json",
        "notebooks/ch02_sample/s5_page.ipynb",
        "source/ch02_sample/s5_page.py",
    ):
        assert (site / name).is_file(), name

    sentence = book.read_text("utf-8").replace("The value is", "The number is")
    book.write_text(sentence, "utf-8")
    before = pages_of(site)
    build()
    after = pages_of(site)
    assert [name for name in after if after[name] != before[name]] == [
        "ch02_sample/s5_page.html"
    ]


def pages_of(site):
    """Every HTML page by name, without the stamps that Sphinx puts on style sheets."""
    texts = {
        path.relative_to(site).as_posix(): path.read_text("utf-8")
        for path in site.rglob("*.html")
    }
    return {name: re.sub(r"\?v=\w+", "", text) for name, text in texts.items()}


def test_a_warning_fails_the_site_every_time(tmp_path):
    source, site = tmp_path / "build" / "source", tmp_path / "site"
    source.mkdir(parents=True)
    (source / "conf.py").write_text('project = "x"\nhtml_theme = "basic"\n')
    (source / "index.rst").write_text("Title\n=====\n\nSee :doc:`nowhere`.\n")
    for _attempt in range(2):
        with pytest.raises(PageError, match=r"^site: index\.rst:4: WARNING"):
            build_site(source, site)
    assert not site.exists()


def test_no_home_no_installed_kernel_and_a_path_with_spaces(
    page, tmp_path, monkeypatch
):
    monkeypatch.setenv("HOME", "/nonexistent")
    monkeypatch.setenv("JUPYTER_PATH", "/nonexistent")
    folder = tmp_path / ("a long name with spaces " * 5)
    folder.mkdir()
    monkeypatch.chdir(folder)
    text = (
        "# %% [markdown]\n# # T\n\n# %% tags=['active-ipynb']\n"
        "# import os, sys\n"
        "# print(os.getcwd(), os.environ['RAXEL_SET'], sys.executable)\n"
    )
    out = folder / "pages" / "ch02_sample" / "s1.ipynb"
    assert run(page(text), out, "--set", "x/my set") == 0
    first = out.read_bytes()
    printed = nbformat.read(out, 4).cells[1].outputs[0].text.strip()
    assert printed == f"{folder} x/my set {os.sys.executable}"
    assert run(page(text), out, "--set", "x/my set") == 0
    assert out.read_bytes() == first
    assert sorted(path.name for path in folder.iterdir()) == [".cache", "pages"]


@pytest.mark.parametrize(
    ("cell", "complaint"),
    [
        ("def f():\n    return 1 / 0\n\n\n# %%\nf()", "ZeroDivisionError"),
        ("import os\nos._exit(3)", "kernel died"),
    ],
)
def test_a_failing_cell_is_one_line_and_leaves_no_notebook(
    page, tmp_path, monkeypatch, capfd, cell, complaint
):
    monkeypatch.chdir(tmp_path)
    path = page(f"# %% [markdown]\n# # T\n\n# %%\n{cell}\n")
    out = tmp_path / "pages" / "ch02_sample" / "s5_page.ipynb"
    write_atomic(out, "the old one")
    assert run(path, out) == 1
    last = capfd.readouterr().err.strip().splitlines()[-1]
    assert last.startswith(f"{path}:")
    assert ": cell " in last
    assert complaint in last
    assert out.read_text() == "the old one"
    assert list(out.parent.iterdir()) == [out]


def test_a_cell_that_hangs_is_stopped(page, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("repro.page.CELL_SECONDS", 1)
    path = page("# %% [markdown]\n# # T\n\n# %%\nimport time\ntime.sleep(60)\n")
    assert run(path, tmp_path / "pages" / "ch02_sample" / "s.ipynb") == 1
    assert "longer than 1 s; stopped" in capfd.readouterr().err


def test_page_file_to_notebook(page):
    cells = read_page(page(PAGE)).cells
    assert [cell.cell_type for cell in cells] == ["markdown"] + ["code"] * 7
    assert cells[2].source == "values()"
    assert [cell.id for cell in cells[:2]] == ["cell-001", "cell-002"]
    with pytest.raises(PageError, match="no cells"):
        read_page(page("", "empty"))


def test_prose_takes_values_and_refuses_unknown_ones(page):
    notebook = read_page(page("# %% [markdown]\n# # T {glue:text}`a:.1f`\n\n# %%\n1\n"))
    with pytest.raises(PageError, match="cell 1: prose asks for the value 'a'"):
        settle(notebook, Path("p.py"))
    output = nbformat.v4.new_output(
        "display_data", metadata={"scrapbook": {"name": "a", "value": "word"}}
    )
    notebook.cells[1].outputs = [output]
    with pytest.raises(PageError, match="value a = 'word'"):
        settle(notebook, Path("p.py"))
    output.metadata.scrapbook["value"] = 2.0
    notebook.cells[1].outputs = [output]
    settle(notebook, Path("p.py"))
    assert notebook.cells[0].source == "# T 2.0"
    assert notebook.cells[1].outputs == []
    assert "remove-input" in notebook.cells[1].metadata.tags


def test_mirror_touches_only_what_differs(tmp_path):
    wanted = {"a.txt": "1", "sub/b.txt": "2"}
    assert sorted(mirror(wanted, tmp_path)) == ["a.txt", "sub/b.txt"]
    os.utime(tmp_path / "a.txt", (1, 1))
    assert mirror(wanted | {"sub/b.txt": "3"}, tmp_path) == ["sub/b.txt"]
    assert (tmp_path / "a.txt").stat().st_mtime == 1
    assert mirror({"a.txt": "1"}, tmp_path) == ["sub/b.txt"]
    assert [path.name for path in tmp_path.iterdir()] == ["a.txt"]


def test_chapters_stand_in_the_order_of_the_thesis(tmp_path):
    books = []
    names = [
        "guides/s1_first",
        "photographs/b10",
        "photographs/b9",
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
    chapters = assemble.chapters_of(tmp_path, books)
    assert [c.number for c in chapters] == ["2", "10", "A", "", ""]
    assert [c.guides for c in chapters] == [False, False, False, True, False]
    assert [p.title for p in chapters[4].pages] == ["photographs/b9", "photographs/b10"]
    assert chapters[0].title == "About ch02_x"
    write_atomic(tmp_path / "chapters" / "ch02_x" / "__init__.py", "")
    with pytest.raises(PageError, match=r"ch02_x/__init__\.py: no docstring"):
        assemble.chapters_of(tmp_path, books)


@pytest.mark.parametrize(
    ("text", "summary"),
    [
        ("# T\n\nA [way](x.md) to\n*go*, $x$.\n\nMore.", "A way to go, x."),
        ("# T\n\n## Next\n\nText.", ""),
        ("# T\n\n| a |\n| - |\n", ""),
        ("# T\n", ""),
    ],
)
def test_a_guide_is_announced_by_its_first_paragraph(tmp_path, text, summary):
    path = tmp_path / "guide.md"
    path.write_text(text)
    assert assemble.summary_of(path) == summary


def test_guides_stand_on_the_start_page_one_by_one(tmp_path):
    small_checkout(tmp_path)
    books = []
    for name in ("guides/which_method", "guides/teachers", "ch02_sample/s5_page"):
        title = name.rpartition("/")[2].replace("_", " ")
        cells = [
            {"cell_type": "markdown", "source": [f"# {title}\n"]},
            {"cell_type": "markdown", "source": [f"About {title}.\n"]},
        ]
        book = tmp_path / "pages" / f"{name}.ipynb"
        notes = {"raxel": {"source": f"{name}.py"}}
        write_json(book, {"cells": cells, "metadata": notes})
        write_atomic(tmp_path / "chapters" / f"{name}.py", "# %%\n")
        books.append(book)
    write_atomic(tmp_path / "chapters" / "guides" / "__init__.py", '"""Guides."""\n')
    base, out = tmp_path / "figures" / "quick", tmp_path / "source"
    boards = (base / "scoreboard.md", base / "scoreboard.json")
    assemble.assemble(tmp_path, "quick", books, *boards, out)
    start = (out / "index.md").read_text("utf-8")
    places = [
        start.index(text)
        for text in (
            "{grid-item-card} teachers\n:link: guides/teachers\n",
            "About teachers.",
            "{grid-item-card} which method\n:link: guides/which_method\n",
            "{grid-item-card} Chapter 2: a sample\n",
            "{toctree}",
            "guides/index\nch02_sample/index\nscoreboard\n",
        )
    ]
    assert places == sorted(places)
    assert "{grid-item-card} Guides" not in start


def test_pictures_of_a_set_without_a_page_are_not_handed_out(tmp_path):
    base = tmp_path / "figures" / "quick"
    for name in ("ext_a@my.set.png", "ext_a@gone.png", "fig_2_3.png"):
        write_atomic(base / name, name)
    for name in ("study@my.set.json", "study@gone.json", "study@gone.run.json"):
        write_json(base / "results" / name, {})
    book = tmp_path / "pages" / "photographs" / "my.set.ipynb"
    write_json(book, {"metadata": {"raxel": {"source": "photographs/set.py"}}})
    handed = assemble._extra(tmp_path, "quick", [book], base / "scoreboard.json")
    assert "figures/ext_a@my.set.png" in handed
    assert "figures/fig_2_3.png" in handed
    assert "results/study@my.set.json" in handed
    assert not [name for name in handed if "gone" in name]


def test_names_and_captions_for_people():
    assert reader.label("fig_2_3") == "Fig. 2.3"
    assert reader.label("table_2_1") == "Table 2.1"
    assert reader.label("alg_1") == "Algorithm 1"
    assert reader.label("ext_fig_2_3_readings") == ""
    assert reader.plain("a *b* [c](d.md) $\\mathbf{x}_1 \\| y$") == "a b c x_1 | y"
    assert reader.pipe_table(["a|b"], [["1"]], [True]) == "| a\\|b |\n| ---: |\n| 1 |"


@pytest.mark.parametrize(
    ("value", "interval", "text"),
    [
        (0.11345, (0.111, 0.1162), "0.1134 px (0.1110 to 0.1162)"),
        (123.4, (100.0, 150.0), "123 px (100 to 150)"),
        (2.0, (2.0, 2.0), "2 px"),
        (0.123456, None, "0.123 px"),
        ("exact", None, "exact px"),
    ],
)
def test_numbers_are_rounded_to_their_interval(value, interval, text):
    assert reader.rounded(value, interval, "px") == text


def test_a_missing_file_names_the_command(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("RAXEL_EFFORT", raising=False)
    monkeypatch.delenv("RAXEL_SET", raising=False)
    with pytest.raises(
        reader.Missing, match=r"fig_2_3\.json is missing; `make fig_2_3`"
    ):
        reader.show("fig_2_3")


def test_an_artefact_of_a_set_is_found_by_its_plain_name(tmp_path, monkeypatch):
    base = small_checkout(tmp_path)
    for ending in ("svg", "json"):
        (base / f"ext_corners@my-set.{ending}").write_bytes(
            (base / f"fig_2_3.{ending}").read_bytes()
        )
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("RAXEL_EFFORT", "quick")
    monkeypatch.setenv("RAXEL_PAGE", "photographs/my-set")
    monkeypatch.setenv("RAXEL_SET", str(tmp_path / "my set"))
    shown = reader.show("ext_corners")
    assert "/_extra/figures/ext_corners@my-set.svg" in shown.markdown
    assert 'href="../figures/ext_corners@my-set.csv"' in shown.markdown


def test_exercises_know_right_from_wrong():
    def expected():
        return np.array([1.0, 2.0, 3.0])

    assert exercise.check(None, expected).right is None
    assert exercise.check([1.0, 2.0, 3.0005], expected).right is True
    wrong = exercise.check([1.0, 2.0, 3.5], expected, hint="look at z")
    assert wrong.right is False
    assert wrong.text == "The largest error is 0.5. Hint: look at z"
    slip = exercise.check(
        [-1.0, -2.0, -3.0], expected, slips={"Mind the sign.": lambda: -expected()}
    )
    assert slip.text == "Mind the sign."
    assert "shape is (2,)" in exercise.check([1.0, 2.0], expected).text
    assert "not str" in exercise.check("one", expected).text
    assert exercise.check(3, lambda: 2).text == "Too large."
    assert exercise.check(2, lambda: 2).right is True
    assert exercise.check("  Negated  Moment", lambda: "negated moment").right is True
    assert "3.0" not in wrong.text


def test_exercises_in_functions():
    cases = [(1.0,), (4.0,)]
    good = exercise.check_function(lambda x: x**0.5, np.sqrt, lambda: cases)
    assert good.right is True
    bad = exercise.check_function(lambda x: x / 2, np.sqrt, lambda: cases, hint="root")
    assert bad.text == "Case 1: Too small. Hint: root"
    broken = exercise.check_function(lambda: 0, np.sqrt, lambda: cases)
    assert broken.text.startswith("Case 1: TypeError")
    assert exercise.check_function(None, np.sqrt, lambda: cases).right is None


def test_counts_come_in_the_order_of_the_verdicts():
    rows = [
        {"kind": "claim", "verdict": v, "chapter": c}
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


def test_what_has_no_source_any_more_leaves_the_site(tmp_path):
    source, built = tmp_path / "source", tmp_path / "html"
    kept = {
        "source": ("index.md", "sets/one.ipynb", "_extra/figures/a@one.svg"),
        "html": ("index.html", "sets/one.html", "search.html", "figures/a@one.svg"),
    }
    gone = ("sets/two.html", "figures/a@two.svg", "_images/a@two.svg")
    for folder, names in (("source", kept["source"]), ("html", kept["html"] + gone)):
        for name in names:
            path = tmp_path / folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text("x")
    assert sorted(without_source(source, built)) == sorted(gone)
