"""Cells of the pages, read as the code that they are in a notebook."""

import ast
import builtins

import pytest

from repro.page.notebook import read_page
from repro.run.discover import page_files, page_id
from tests.small_checkouts import ROOT

PAGES = {page_id(ROOT, path): path for path in page_files(ROOT)}


def tree_of(path):
    """The code of all cells, those that a page file has as comments too."""
    cells = read_page(path).cells
    return ast.parse("\n".join(c.source for c in cells if c.cell_type == "code"))


def names_given(tree):
    """Names that code binds anywhere: imports, definitions, assignments, arguments."""
    found = set(dir(builtins))
    for node in ast.walk(tree):
        if isinstance(node, ast.Import | ast.ImportFrom):
            found |= {(a.asname or a.name).split(".")[0] for a in node.names}
        elif isinstance(node, ast.FunctionDef | ast.ClassDef | ast.ExceptHandler):
            found.add(node.name)
        elif isinstance(node, ast.arg):
            found.add(node.arg)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            found.add(node.id)
    return found


@pytest.mark.parametrize("page", PAGES)
def test_page_names_are_defined(page):
    tree = tree_of(PAGES[page])
    used = {
        node.id
        for node in ast.walk(tree)
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load)
    }
    assert not used - names_given(tree)


@pytest.mark.parametrize("page", PAGES)
def test_page_imports_exist(page):
    tree = tree_of(PAGES[page])
    imports = [n for n in ast.walk(tree) if isinstance(n, ast.Import | ast.ImportFrom)]
    found = {}
    exec(compile(ast.Module(imports, []), page, "exec"), found)
    names = {a.asname or a.name for node in imports for a in node.names}
    assert names
    assert {name.split(".")[0] for name in names} <= found.keys()
