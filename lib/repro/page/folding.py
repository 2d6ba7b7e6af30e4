"""Fold preparatory code of a page: a page begins with its question and its figure.

Settings and registrations for the workflow are folded on the page; imports are in the
notebook only. Code that teaches remains visible, as does a trial next to its
experiment.
"""

from __future__ import annotations

import ast
from itertools import groupby

from nbformat import NotebookNode
from nbformat.v4 import new_code_cell

from repro.run.discover import MARKS

FOLDED = ("hide-cell", "hide-input", "remove-cell", "remove-input")
IMPORTS, SETTINGS = "imports of this page", "settings of the experiments"
REGISTRATION = "registration of the experiments"


def folded(cell: NotebookNode) -> list[NotebookNode]:
    """Return a code cell of a page's file with its preparatory code folded.

    A cell with registrations is split, so that its other code remains visible.
    """
    hidden = set(cell.metadata.get("tags", [])) & set(FOLDED)
    if kind_of(cell.source) == REGISTRATION and not hidden:
        parts = [new_code_cell(source) for source in _parts(cell.source)]
    else:
        parts = [cell]
    for part in parts:
        _fold(part)
    return parts


def _parts(source: str) -> list[str]:
    """The source in alternating pieces of preparatory and other code."""
    lines = source.splitlines()
    pieces, begin = [], 0
    for _, run in groupby(ast.parse(source).body, _prepares):
        # Comments and decorators above a statement belong to it.
        end = max(statement.end_lineno for statement in run)
        pieces.append("\n".join(lines[begin:end]).strip("\n"))
        begin = end
    return pieces


def _fold(cell: NotebookNode) -> None:
    """Fold a preparatory cell, and label the fold."""
    what = kind_of(cell.source)
    if not what:
        return
    tags = cell.metadata.setdefault("tags", [])
    if not set(tags) & set(FOLDED):
        tags.append("remove-cell" if what == IMPORTS else "hide-input")
    cell.metadata["mystnb"] = NotebookNode(
        code_prompt_show=f"Show the {what}", code_prompt_hide=f"Hide the {what}"
    )


def kind_of(source: str) -> str:
    """Kind of a preparatory cell; empty for other cells."""
    try:
        body = ast.parse(source).body
    except SyntaxError:
        return ""
    if any(_registers(statement) for statement in body):
        return REGISTRATION
    if not all(map(_prepares, body)):
        return ""
    return IMPORTS if any(map(_imports, body)) else SETTINGS


def _prepares(statement: ast.stmt) -> bool:
    """Whether a statement is irrelevant to a reader who does not run the page."""
    return any(of(statement) for of in (_imports, _registers, _is_setting))


def _imports(statement: ast.stmt) -> bool:
    return isinstance(statement, ast.Import | ast.ImportFrom)


def _registers(statement: ast.stmt) -> bool:
    """Whether a function is marked for the workflow (`repro.run.marks`)."""
    return any(
        isinstance(mark, ast.Call) and getattr(mark.func, "id", "") in MARKS
        for mark in getattr(statement, "decorator_list", ())
    )


def _is_setting(statement: ast.stmt) -> bool:
    """Whether a statement names constants, or is a function of settings or plans."""
    if isinstance(statement, ast.FunctionDef):
        called = (part for part in ast.walk(statement) if isinstance(part, ast.Call))
        plans = any(getattr(call.func, "id", "") == "Plan" for call in called)
        return plans or statement.name == "settings"
    return isinstance(statement, ast.Assign) and all(
        isinstance(target, ast.Name) and target.id.isupper()
        for named in statement.targets
        for target in getattr(named, "elts", [named])
    )
