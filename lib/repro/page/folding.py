"""Which code of a page is folded: a page opens with its question and its figure.

Imports, settings, and cells in which something is registered for the workflow stand on
the page under a line to click on. Code that teaches stays open.
"""

from __future__ import annotations

import ast

from nbformat import NotebookNode

from repro.run.discover import MARKS

FOLDED = ("hide-cell", "hide-input", "remove-cell", "remove-input")
IMPORTS, SETTINGS = "imports of this page", "settings of the experiments"
REGISTRATION = "code of the trials and experiments"


def fold(cell: NotebookNode) -> None:
    """Fold a code cell of a page's file if it only prepares, and label the fold."""
    what = kind_of(cell.source)
    if not what:
        return
    tags = cell.metadata.setdefault("tags", [])
    if not set(tags) & set(FOLDED):
        tags.append("hide-input")
    cell.metadata["mystnb"] = NotebookNode(
        code_prompt_show=f"Show the {what}", code_prompt_hide=f"Hide the {what}"
    )


def kind_of(source: str) -> str:
    """What a cell that only prepares holds; empty for any other."""
    try:
        body = ast.parse(source).body
    except SyntaxError:
        return ""
    if any(_registers(statement) for statement in body):
        return REGISTRATION
    if not all(_imports(statement) or _is_setting(statement) for statement in body):
        return ""
    return IMPORTS if any(map(_imports, body)) else SETTINGS


def _imports(statement: ast.stmt) -> bool:
    return isinstance(statement, ast.Import | ast.ImportFrom)


def _registers(statement: ast.stmt) -> bool:
    """Whether a function is marked for the workflow (`repro.run.experiment`)."""
    return any(
        isinstance(mark, ast.Call) and getattr(mark.func, "id", "") in MARKS
        for mark in getattr(statement, "decorator_list", ())
    )


def _is_setting(statement: ast.stmt) -> bool:
    """Whether a statement names a constant, or is the function `settings`."""
    if isinstance(statement, ast.FunctionDef):
        return statement.name == "settings"
    return isinstance(statement, ast.Assign) and all(
        isinstance(target, ast.Name) and target.id.isupper()
        for target in statement.targets
    )
