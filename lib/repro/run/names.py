"""Where a name of a chapter is defined: found by parsing, through imports."""

from __future__ import annotations

import ast
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path


@dataclass(frozen=True)
class Place:
    """A definition: its file and its statement."""

    path: Path
    node: ast.stmt


class Sources:
    """The files of the checkout at ``root`` (chapters, lib/), each read once."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self._bodies: dict[Path, list[ast.stmt]] = {}

    def body(self, path: Path) -> list[ast.stmt]:
        """The statements of a file."""
        if path not in self._bodies:
            self._bodies[path] = _parsed(path, path.read_text("utf-8"))
        return self._bodies[path]

    def find(self, path: Path, name: Sequence[str]) -> Place | None:
        """What ``name`` stands for in the file ``path``; None for what is not ours.

        ``name`` is split at its dots: `results.GRIDS` is ("results", "GRIDS").
        """
        first, *rest = name
        body = self.body(path)
        for node in body:
            if first in defined_by(node):
                return None if rest else Place(path, node)
        for node in body:
            if not isinstance(node, ast.ImportFrom) or node.level or not node.module:
                continue
            for alias in node.names:
                if (alias.asname or alias.name) == first:
                    return self._imported(node.module, alias.name, rest)
        return None

    def _imported(self, module: str, name: str, rest: list[str]) -> Place | None:
        inner = self._file(f"{module}.{name}")
        if inner:
            return self.find(inner, rest) if rest else None
        home = self._file(module)
        return self.find(home, [name, *rest]) if home else None

    def _file(self, module: str) -> Path | None:
        base = self.root if module.startswith("chapters.") else self.root / "lib"
        stem = base.joinpath(*module.split("."))
        for path in (stem.with_suffix(".py"), stem / "__init__.py"):
            if path.is_file():
                return path
        return None


@cache
def _parsed(path: Path, text: str) -> list[ast.stmt]:
    """Statements of a file with this text: one that did not change is parsed once."""
    return ast.parse(text, str(path)).body


def defined_by(node: ast.stmt) -> list[str]:
    """Names that a statement defines: a function, a class, plain assignments."""
    if isinstance(node, ast.FunctionDef | ast.ClassDef):
        return [node.name]
    targets = [node.target] if isinstance(node, ast.AnnAssign) else []
    targets += node.targets if isinstance(node, ast.Assign) else []
    return [target.id for target in targets if isinstance(target, ast.Name)]


def dotted(node: ast.expr) -> list[str]:
    """The parts of a name, `a.b.c`; empty for any other expression."""
    if isinstance(node, ast.Name):
        return [node.id]
    if isinstance(node, ast.Attribute):
        before = dotted(node.value)
        return [*before, node.attr] if before else []
    return []
