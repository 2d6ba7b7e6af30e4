"""Notebooks run where they lie: the first cell, what is kept, and JupyterLab's pins."""

import json
import os
import re
import sys
from importlib.machinery import ModuleSpec
from pathlib import Path

import nbformat
import pytest
from nbformat.v4 import new_code_cell, new_notebook

from repro.site import first_cell
from repro.site.notebooks import notebooks

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture
def kernel(monkeypatch):
    """A fresh kernel as far as the first cell sees it, with nothing installed."""
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.setattr(os, "environ", os.environ.copy())
    os.environ.pop("JPY_SESSION_NAME", None)
    installed = {name: ModuleSpec(name, None) for name in first_cell.NEEDED}
    monkeypatch.setattr(first_cell.importlib.util, "find_spec", installed.get)
    return installed


@pytest.fixture
def checkout(tmp_path):
    root = tmp_path / "a checkout"
    for name in ("chapters", "data/published", "lib", "figures/quick/results"):
        (root / name).mkdir(parents=True)
    (root / "report/notebooks/ch02_sample").mkdir(parents=True)
    return root


def test_first_cell_finds_checkout(kernel, checkout, tmp_path, monkeypatch):
    folder = checkout / "report" / "notebooks" / "ch02_sample"
    lib = checkout / "lib"
    places = {
        "where the notebook lies": (folder, {}, None),
        "where JupyterLab says": (
            tmp_path,
            {"JPY_SESSION_NAME": f"{folder}/page.ipynb"},
            None,
        ),
        "where raxel is installed from": (
            tmp_path,
            {},
            ModuleSpec("raxel", None, origin=f"{lib}/raxel/__init__.py"),
        ),
    }
    for what, (here, variables, raxel) in places.items():
        monkeypatch.chdir(here)
        kernel["raxel"] = raxel
        with monkeypatch.context() as patch:
            patch.setattr(os, "environ", os.environ | variables)
            sys.path.insert(0, "another/checkout/lib")
            first_cell.begin("quick", "ch02_sample/page")
            assert Path.cwd() == checkout, what
            assert sys.path[:2] == [str(lib), str(checkout)], what
            assert sys.path.count(str(lib)) == 1
            assert os.environ["RAXEL_EFFORT"] == "quick"
            assert os.environ["RAXEL_PAGE"] == "ch02_sample/page"


def test_first_cell_reports_missing_parts_in_one_line(
    kernel, checkout, tmp_path, monkeypatch
):
    def message():
        with pytest.raises(first_cell.CannotRun) as caught:
            first_cell.begin("full", "ch02_sample/page")
        (line,) = caught.value._render_traceback_()
        assert "\n" not in line
        return line

    monkeypatch.chdir(tmp_path)
    assert "No checkout of Raxel around this notebook" in message()
    monkeypatch.chdir(checkout)
    assert "`make notebooks EFFORT=full`" in message()
    del kernel["cv2"]
    assert "lacks cv2: run `make lab`" in message()


def executed(folder, name, code):
    path = folder / "pages" / "ch02_sample" / f"{name}.ipynb"
    path.parent.mkdir(parents=True, exist_ok=True)
    about = {"source": "p.py", "effort": "quick", "page": f"ch02_sample/{name}"}
    book = new_notebook(cells=[new_code_cell(code)], metadata={"raxel": about})
    nbformat.write(book, path)
    return path


def test_edited_notebook_is_kept(tmp_path):
    out = tmp_path / "notebooks"
    mine, other = out / "ch02_sample/mine.ipynb", out / "ch02_sample/other.ipynb"
    pages = [executed(tmp_path, name, "check(None)") for name in ("mine", "other")]
    notebooks(pages, out)
    cells = nbformat.read(mine, 4).cells
    assert cells[0].source.endswith("begin('quick', 'ch02_sample/mine')")
    assert cells[0].metadata.jupyter.source_hidden
    for answer in ("1", "2"):
        mine.write_text(mine.read_text("utf-8").replace("None", answer), "utf-8")
        (out / "own.ipynb").write_text("of the student")
        notebooks(pages, out)
    for name, answer in (("mine", "None"), ("mine-yours", "1"), ("mine-yours-2", "2")):
        text = (out / f"ch02_sample/{name}.ipynb").read_text("utf-8")
        assert f"check({answer})" in text
    notebooks(pages[1:], out)
    assert not mine.exists()
    assert other.exists()
    assert (out / "own.ipynb").exists()
    assert json.loads((out / ".written.json").read_text()).keys() == {
        "ch02_sample/other.ipynb"
    }


def pins(name):
    text = (ROOT / name).read_text("utf-8")
    assert text.count("==") <= text.count("--hash=sha256:")
    return dict(re.findall(r"^([\w.-]+)==([\w.+-]+)", text, flags=re.M))


@pytest.mark.parametrize(
    ("file", "package"),
    [("lab", "jupyterlab"), ("bench", "fringes"), ("bench", "pytest-benchmark")],
)
def test_further_pins_do_not_change_packages(file, package):
    report, further = pins("environment.txt"), pins(f"lib/repro/{file}.txt")
    assert package in further
    assert not [name for name in further if name.startswith("opencv")]
    shared = report.keys() & further.keys()
    assert shared
    assert {name: further[name] for name in shared} == {n: report[n] for n in shared}
