"""Find the definition of a name of a chapter by parsing, through imports."""

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
    """The files of the checkout at ``root`` (chapters, lib/), each read once.

    ``read_files`` collects the files that were read.
    """

    def __init__(self, root: Path) -> None:
        self.root = root
        self.asked: set[Path] = set()
        self._files: dict[str, Path | None] = {}
        self._bodies: dict[Path, list[ast.stmt]] = {}
        self._known: dict[Path, tuple[dict[str, ast.stmt], dict]] = {}

    def body(self, path: Path) -> list[ast.stmt]:
        """The statements of a file."""
        if path not in self._bodies:
            self._bodies[path] = parsed(path, path.read_text("utf-8"))
        return self._bodies[path]

    def find(self, path: Path, name: Sequence[str]) -> Place | None:
        """Return the definition of ``name`` in the file ``path``; None outside the
        project.

        ``name`` is split at its dots: `results.GRIDS` is ("results", "GRIDS").
        """
        self.asked.add(path)
        first, *rest = name
        defined, imports = self._names(path)
        if first in defined:
            return None if rest else Place(path, defined[first])
        if first in imports:
            return self.imported(*imports[first], rest)
        return None

    def _names(self, path: Path) -> tuple[dict[str, ast.stmt], dict]:
        """Names that a file defines, each with the first statement that does; and those
        that it imports, as (module, name).
        """
        if path not in self._known:
            defined: dict[str, ast.stmt] = {}
            imports: dict[str, tuple[str, str]] = {}
            for node in self.body(path):
                for name in defined_by(node):
                    defined.setdefault(name, node)
                if isinstance(node, ast.ImportFrom) and node.module and not node.level:
                    for alias in node.names:
                        names = alias.asname or alias.name
                        imports.setdefault(names, (node.module, alias.name))
            self._known[path] = defined, imports
        return self._known[path]

    def imported(self, module: str, name: str, rest: Sequence[str]) -> Place | None:
        """What ``name`` of ``module``, with attributes, stands for."""
        inner = self.file(f"{module}.{name}")
        if inner:
            return self.find(inner, rest) if rest else None
        home = self.file(module)
        return self.find(home, [name, *rest]) if home else None

    def file(self, module: str) -> Path | None:
        """The file of a module of the checkout."""
        if module not in self._files:
            self._files[module] = self._file(module)
        return self._files[module]

    def _file(self, module: str) -> Path | None:
        base = self.root if module.startswith("chapters.") else self.root / "lib"
        stem = base.joinpath(*module.split("."))
        for path in (stem.with_suffix(".py"), stem / "__init__.py"):
            if path.is_file():
                return path
        return None


@cache
def parsed(path: Path, text: str) -> list[ast.stmt]:
    """Statements of a file with this text; an unchanged text is parsed once."""
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
