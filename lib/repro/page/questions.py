"""Exercises of a page, found in its cells: question, check, right answer, reason.

The cell of an exercise is one line that begins with `check(None`. Its question is the
paragraph above it. Its reason is the docstring of the function that computes the
answer, which no page shows.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Mapping
from typing import NamedTuple

from nbformat import NotebookNode

CHECK = "check"


class Exercise(NamedTuple):
    """An exercise: the Markdown of its question, and the line that checks."""

    question: str
    line: str


class Task(NamedTuple):
    """Arguments of `check` in a line: the function of the answer, and the options."""

    expected: Callable
    options: Mapping[str, object]


def exercises_of(notebook: NotebookNode) -> list[Exercise]:
    """The exercises of a page, in their order."""
    found, question = [], ""
    for cell in notebook.cells:
        if cell.cell_type == "markdown":
            question = re.split(r"^(?=\*\*\d+\.\*\*)|\n\n", cell.source, flags=re.M)[-1]
        elif _is_check(cell.source):
            found.append(Exercise(question.strip(), cell.source.strip()))
    return found


def evaluated(line: str, notebook: NotebookNode, names: Mapping, **other) -> object:
    """The value of an exercise's line.

    names: definitions of the page's module. Definitions of display cells are run first
    if the line needs them. other: replaces such names.
    """
    known = {**names, **other}
    _define(ast.parse(line), _assignments(notebook), known)
    return eval(line, known)


def task_of(exercise: Exercise, notebook: NotebookNode, names: Mapping) -> Task:
    """Return the arguments of the exercise's check, without a comparison."""

    def asked(answer, expected, *more, **options) -> Task:
        return Task(expected, options)

    return evaluated(exercise.line, notebook, names, **{CHECK: asked})


def reason_of(exercise: Exercise, names: Mapping) -> str:
    """Return the reason of the answer: the docstring of the function of the line."""
    for part in ast.walk(_statement(exercise.line)):
        found = names.get(part.id) if isinstance(part, ast.Name) else None
        if isinstance(part, ast.Attribute) and isinstance(part.value, ast.Name):
            found = getattr(names.get(part.value.id), part.attr, None)
        if callable(found) and getattr(found, "__name__", "") != CHECK:
            return " ".join((found.__doc__ or "").split("\n\n")[0].split())
    return ""


def _is_check(source: str) -> bool:
    statement = _statement(source)
    return (
        isinstance(statement, ast.Expr)
        and isinstance(statement.value, ast.Call)
        and getattr(statement.value.func, "id", "") == CHECK
    )


def _statement(source: str) -> ast.stmt | None:
    """The one statement of a cell; nothing where there are more or none."""
    try:
        body = ast.parse(source).body
    except SyntaxError:
        return None
    return body[0] if len(body) == 1 else None


def _assignments(notebook: NotebookNode) -> dict[str, str]:
    """Name -> display cell that defines it."""
    found = {}
    for cell in notebook.cells:
        statement = _statement(cell.source) if cell.cell_type == "code" else None
        if isinstance(statement, ast.Assign):
            for target in ast.walk(statement.targets[0]):
                if isinstance(target, ast.Name):
                    found[target.id] = cell.source
    return found


def _define(tree: ast.AST, made: Mapping[str, str], names: dict) -> None:
    """Run the cells that define what ``tree`` reads."""
    for part in ast.walk(tree):
        unknown = isinstance(part, ast.Name) and part.id not in names
        if unknown and part.id in made:
            _define(_statement(made[part.id]).value, made, names)
            exec(made[part.id], names)
