"""Source files as pages: numbered lines, and an anchor for every function and class.

An anchor is the name, `Camera` or `Camera.rays`, so that a link to a function holds
when lines move.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from html import escape
from pathlib import Path

STYLE = """
:root { color-scheme: light dark; }
body { margin: 1rem; font: 14px/1.5 system-ui, sans-serif; }
pre { font: 13px/1.5 ui-monospace, monospace; }
a.n { color: inherit; opacity: .55; text-decoration: none; user-select: none; }
:target { background: color-mix(in srgb, currentColor 15%, transparent); }
"""


def source_page(path: Path, name: str, up: str) -> str:
    """HTML of a Python file; ``name`` is its place, ``up`` the way to the top."""
    text = path.read_text("utf-8")
    first: dict[str, int] = {}
    for anchor, line in definitions(ast.parse(text), ""):
        first.setdefault(anchor, line)  # a property has its setter under the same name
    anchors = {line: anchor for anchor, line in first.items()}
    lines = text.splitlines()
    width = len(str(len(lines)))
    body = "\n".join(
        f'<span id="{anchors.get(number, f"L{number}")}">'
        f'<a class="n" href="#{anchors.get(number, f"L{number}")}">{number:{width}}</a>'
        f"  {escape(line, quote=False)}</span>"
        for number, line in enumerate(lines, 1)
    )
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{escape(name)}</title><style>{STYLE}</style></head><body>\n"
        f'<p><a href="{up}index.html">Raxel</a> · {escape(name)}</p>\n'
        f"<pre>{body}</pre>\n</body></html>\n"
    )


def definitions(tree: ast.AST, inside: str) -> Iterator[tuple[str, int]]:
    """(name, line) of the functions and classes, methods with their class."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            yield f"{inside}{node.name}", node.lineno
        if isinstance(node, ast.ClassDef):
            yield from definitions(node, f"{inside}{node.name}.")
