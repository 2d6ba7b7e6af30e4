"""Source files as pages: numbered lines, and an anchor for every function and class.

An anchor is the name, `Camera` or `Camera.rays`, so that a link to a function holds
when lines move.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from html import escape
from pathlib import Path

from jinja2 import Template

from repro.page.templates import environment

TEMPLATES = Path(__file__).with_name("templates")


def source_page(path: Path, name: str, up: str) -> str:
    """Return HTML of a Python file; ``name`` is its path, ``up`` the path to the
    top."""
    text = path.read_text("utf-8")
    first: dict[str, int] = {}
    for anchor, line in definitions(ast.parse(text), ""):
        first.setdefault(anchor, line)  # a property and its setter have the same name
    anchors = {line: anchor for anchor, line in first.items()}
    lines = escape(text, quote=False).splitlines()  # code has many quotes
    width = len(str(len(lines)))
    numbered = [
        (anchors.get(number, f"L{number}"), f"{number:{width}}", line)
        for number, line in enumerate(lines, 1)
    ]
    return _template().render(name=name, up=up, lines=numbered) + "\n"


@cache
def _template() -> Template:
    return environment(TEMPLATES).get_template("source.html.jinja")


def definitions(tree: ast.AST, inside: str) -> Iterator[tuple[str, int]]:
    """(name, line) of the functions and classes, methods with their class."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            yield f"{inside}{node.name}", node.lineno
        if isinstance(node, ast.ClassDef):
            yield from definitions(node, f"{inside}{node.name}.")
