"""From page file to notebook: cells read, executed, and values put in the prose."""

import ast
import os
from functools import partial
from pathlib import Path

import nbformat
import pytest

from repro.page import reader
from repro.page.notebook import PageError, read_page, settle
from repro.run.results import write_atomic
from tests.small_checkouts import PAGE, run, write_page


@pytest.fixture
def page(tmp_path):
    return partial(write_page, tmp_path)


def test_page_runs_without_home_and_kernel(page, tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", "/nonexistent")
    monkeypatch.setenv("JUPYTER_PATH", "/nonexistent")
    folder = tmp_path / ("a long name with spaces " * 5)
    folder.mkdir()
    monkeypatch.chdir(folder)
    text = (
        "# %% [markdown]\n# # T\n\n# %% tags=['active-ipynb']\n"
        "# import os, sys\n"
        "# print(os.getcwd(), os.environ['RAXEL_PAGE'], sys.executable)\n"
    )
    out = folder / "pages" / "ch02_sample" / "s1.ipynb"
    run(page(text), out)
    first = out.read_bytes()
    printed = nbformat.read(out, 4).cells[1].outputs[0].text.strip()
    assert printed == f"{folder} ch02_sample/s1 {os.sys.executable}"
    run(page(text), out)
    assert out.read_bytes() == first
    assert sorted(path.name for path in folder.iterdir()) == [".cache", "pages"]


def test_cell_outputs_are_stored(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    cell = (
        "from IPython.display import HTML, display\n"
        "display(HTML('<i>one</i>'))\nprint('two')\nHTML('<b>three</b>')"
    )
    path = page(f"# %% [markdown]\n# # T\n\n# %%\n{cell}\n\n# %%\nNone\n")
    out = tmp_path / "pages" / "ch02_sample" / "s5_page.ipynb"
    run(path, out)
    stream, first, last = nbformat.read(out, 4).cells[1].outputs
    assert stream.text == "two\n"
    assert first.data["text/html"] == "<i>one</i>"
    assert last.data["text/html"] == "<b>three</b>"
    assert nbformat.read(out, 4).cells[2].outputs == []


def test_failing_cell_is_one_line(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    cell = "def f():\n    return 1 / 0\n\n\n# %%\nf()"
    path = page(f"# %% [markdown]\n# # T\n\n# %%\n{cell}\n")
    out = tmp_path / "pages" / "ch02_sample" / "s5_page.ipynb"
    write_atomic(out, "the old one")
    with pytest.raises(PageError) as fault:
        run(path, out)
    last = str(fault.value)
    assert last.startswith(f"{path}:")
    assert ": cell " in last
    assert "ZeroDivisionError: division by zero" in last
    assert (out.read_text(), list(out.parent.iterdir())) == ("the old one", [out])


def test_hanging_cell_is_stopped(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("repro.page.execute.CELL_SECONDS", 1)
    path = page("# %% [markdown]\n# # T\n\n# %%\nimport time\ntime.sleep(60)\n")
    with pytest.raises(PageError, match="longer than 1 s; stopped"):
        run(path, tmp_path / "pages" / "ch02_sample" / "s.ipynb")


def test_page_file_to_notebook(page):
    cells = read_page(page(PAGE)).cells
    assert [cell.cell_type for cell in cells] == ["markdown"] + ["code"] * 7
    assert cells[2].source == "values()"
    assert [cell.id for cell in cells[:2]] == ["cell-001", "cell-002"]
    with pytest.raises(PageError, match="no cells"):
        read_page(page("", "empty"))


def test_prose_gets_values_and_rejects_unknown_ones(page):
    notebook = read_page(page("# %% [markdown]\n# # T {glue:text}`a:.1f`\n\n# %%\n1\n"))
    with pytest.raises(PageError, match="cell 1: value 'a' is not defined"):
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
    assert (notebook.cells[0].source, notebook.cells[1].outputs) == ("# T 2.0", [])
    assert "remove-input" in notebook.cells[1].metadata.tags


def test_display_cell_without_output_is_omitted(page):
    notebook = read_page(
        page(
            "# %% [markdown]\n# # T\n\n"
            '# %% tags=["active-ipynb"]\n# ran = open_results("sweep")\n\n'
            '# %% tags=["active-ipynb"]\n# ran\n\n'
            "# %%\nlevels = 3\n"
        )
    )
    shown = nbformat.v4.new_output("execute_result", data={"text/plain": "1"})
    notebook.cells[2].outputs = [shown]
    settle(notebook, Path("p.py"))
    left_out = [
        "remove-input" in cell.metadata.get("tags", ()) for cell in notebook.cells
    ]
    assert left_out == [False, True, False, False]


def test_preparatory_code_is_folded(page):
    cells = (
        "import os\n\nREADS_PAGES = True",
        "TRIALS = {'quick': 1}\n\n\ndef settings(effort):\n    return TRIALS",
        "def trial(c, rng):\n    return {}\n\n\n"
        "@experiment('x', artefact='y')\ndef sweep(effort):\n    pass",
        "def half_of(number):\n    return number / 2",
        "LIMIT = 3\nprint(LIMIT)",
    )
    text = "\n\n".join(f"# %%\n{cell}" for cell in ("'T'", *cells))
    hidden = '# %% tags=["remove-cell"]\nimport sys\n\n'
    display = '# %% tags=["active-ipynb"]\n# SCENE = 3\n'
    found = read_page(page(f"{text}\n\n{hidden}{display}")).cells
    tags = [cell.metadata.get("tags", []) for cell in found]
    assert tags[1:3] == [["remove-cell"], ["hide-input"]]
    assert tags[3:7] == [[], ["hide-input"], [], []]
    assert tags[7:] == [["remove-cell"], ["active-ipynb"]]
    # The trial stands open, what registers it is folded.
    assert found[3].source == "def trial(c, rng):\n    return {}"
    assert found[4].source.startswith("@experiment('x', artefact='y')\ndef sweep")
    shown = [found[place].metadata.mystnb.code_prompt_show for place in (1, 2, 4)]
    assert shown == [
        "Show the imports of this page",
        "Show the settings of the experiments",
        "Show the registration of the experiments",
    ]


def test_split_cell_runs_as_whole(page):
    body = (
        "import os\n\nA, B = 1, 2\n\n\n"
        "# Why so.\ndef trial(c, rng):\n    return A\n\n\n"
        "def plan(effort):\n    return Plan(trial, [], 1)\n\n\n"
        "# All of it.\n@experiment('x', artefact='y')\ndef sweep(effort):\n    pass"
    )
    cells = read_page(page(f"# %%\n{body}\n")).cells
    assert [cell.source.split("\n")[0] for cell in cells] == [
        "import os", "# Why so.", "def plan(effort):",
    ]  # fmt: skip
    assert ["tags" in cell.metadata for cell in cells] == [True, False, True]
    together = "\n".join(cell.source for cell in cells)
    assert ast.dump(ast.parse(together)) == ast.dump(ast.parse(body))
    assert [cell.id for cell in cells] == ["cell-001", "cell-002", "cell-003"]


def test_page_forgets_results_of_earlier_pages(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(reader, "_opened", ["of_another_page"])
    run(
        page("# %% [markdown]\n# # T\n\n# %%\n1\n"),
        tmp_path / "pages" / "c" / "s.ipynb",
    )
    assert reader._opened == []
