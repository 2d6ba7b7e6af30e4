"""Definitions, imports and names of a source file, for `repro.run.reach`.

An index is cached on disk under the hash of the file's content, so that a build parses
only changed files.
"""

from __future__ import annotations

import ast
import hashlib
import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from functools import cache, partial
from pathlib import Path

from repro.run import bare_syntax
from repro.run.bare_syntax import (
    Target,
    Writer,
    bare,
    below,
    bound_by,
    chains,
    filled_by,
    import_aliases,
)
from repro.run.results import write_json

# Names by which code reads its own location.
OF_PLACE = {"__file__", "__name__", "__package__", "__path__", "__spec__"}
# Names by which code reads the name or the origin of a function.
OF_NAME = {
    "__module__", "__name__", "__qualname__", "co_filename", "co_name", "co_qualname",
    "getfile", "getmodule", "getsource", "getsourcefile", "getsourcelines", "pickle",
}  # fmt: skip
PROGRAM = "__name__ == '__main__'"


@dataclass(frozen=True)
class Definition:
    """A top-level name: its line, the hash of its bare syntax, and its references.

    ``references`` are (word, module, path): the target of ``path`` from ``module``. In
    the syntax they are replaced by numbers; those with a word remain as that word,
    which may have another meaning, too. ``asks_names``: it reads names of functions.
    """

    line: int
    hash: str
    references: list[tuple[str, str, list[str]]]
    asks_names: bool


@dataclass(frozen=True)
class Module:
    """One source file: its definitions and its imports by local name."""

    name: str
    definitions: dict[str, Definition]
    imports: dict[str, Target]


def index(name: str, path: Path, folder: Path) -> Module:
    """Return the index of the module ``name`` in ``path``, cached in ``folder``.

    A stub (``.pyi``) next to it lists the lazy imports of a package.
    """
    stub = path.with_suffix(".pyi")
    source = path.read_bytes() + (stub.read_bytes() if stub.is_file() else b"")
    key = hashlib.sha256(f"{name}\n{_revision()}\n".encode() + source).hexdigest()
    kept = folder / f"{key[:32]}.json"
    try:
        content = json.loads(kept.read_text("utf-8"))
    except (OSError, ValueError):  # not kept yet, or cut
        package = name if path.name == "__init__.py" else name.rpartition(".")[0]
        content = asdict(_indexed(name, package, source, path))
        write_json(kept, content)
    definitions = {n: Definition(**d) for n, d in content["definitions"].items()}
    return Module(name, definitions, content["imports"])


@cache
def _revision() -> str:
    files = (__file__, bare_syntax.__file__)
    return hashlib.sha256(b"".join(Path(f).read_bytes() for f in files)).hexdigest()


def _indexed(name: str, package: str, source: bytes, path: Path) -> Module:
    reader = _Reader(name, package)
    for node in bare(ast.parse(source, str(path))).body:
        reader.add(node)
    definitions = {own: reader.definition(own) for own in reader.statements}
    return Module(name, definitions, reader.imports)


class _Statement:
    """A statement of a module, and what it binds, names and imports."""

    def __init__(self, node: ast.stmt, package: str) -> None:
        every = list(below(node))
        outside = [one for one, inside in every if not inside]
        self.node = node
        self.bound = {name for one in outside for name in bound_by(one)}
        self.filled = {name for one in outside for name in filled_by(one)}
        self.local = {name for one, inside in every if inside for name in bound_by(one)}
        self.chains = set(chains([node]))
        self.asks_names = any(_asks_names(one) for one, _ in every)
        self.imports = [
            (name, target, inside)
            for one, inside in every
            if isinstance(one, ast.Import | ast.ImportFrom)
            for name, target in import_aliases(one, package).items()
        ]


class _Reader:
    """Sort the statements of a module by the names that they define.

    A statement without a definition may change other definitions: it belongs to all.
    """

    def __init__(self, module: str, package: str) -> None:
        self.module = module
        self.package = package
        self.statements: dict[str, list[_Statement]] = {}
        self.imports: dict[str, Target] = {}
        self.bare: list[_Statement] = []

    def add(self, node: ast.stmt) -> None:
        one = _Statement(node, self.package)
        self.imports |= {name: to for name, to, inside in one.imports if not inside}
        if isinstance(node, ast.Import | ast.ImportFrom) or _says_nothing(node):
            return
        names = one.bound | (one.filled - self.imports.keys())
        for name in sorted(names):
            self.statements.setdefault(name, []).append(one)
        if not names:
            self.bare.append(one)

    def definition(self, own: str) -> Definition:
        """One name with all the statements that belong to it."""
        mine = [*self.statements[own], *self.bare]
        used = sorted({one for statement in mine for one in statement.chains})
        may_mean = {root: self._may_mean(root, mine) for root, _ in used}
        local = {name for statement in mine for name in statement.local}
        kept = {n for n, found in may_mean.items() if len(found) > 1 or n in local}
        leads = {
            name: found[0]
            for name, found in may_mean.items()
            if found and name not in kept and name != own
        }
        aliases = partial(import_aliases, package=self.package)
        writer = Writer(own, leads, kept, aliases)
        text = "\n".join(writer.statement(statement.node) for statement in mine)
        if any(root in OF_PLACE for root, _ in used):
            text += f"\n{self.module}"
        references = [("", module, list(path)) for module, path in writer.numbers]
        references += [
            (root, module, [*([name] if name else []), *attributes])
            for root, attributes in used
            if root in kept
            for module, name in may_mean[root]
            if (module, name) != (self.module, own)
        ]
        return Definition(
            mine[0].node.lineno,
            hashlib.sha256(text.encode()).hexdigest()[:16],
            references,
            any(statement.asks_names for statement in mine),
        )

    def _may_mean(self, name: str, mine: Iterable[_Statement]) -> list[Target]:
        """Possible targets of a name: of the module, or imported there or in an inner
        scope."""
        found = [(self.module, None)] if name == "globals" else []
        found += [(self.module, name)] if name in self.statements else []
        found += [self.imports[name]] if name in self.imports else []
        imported = (pair for one in mine for pair in one.imports if pair[2])
        found += [target for alias, target, _ in imported if alias == name]
        return list(dict.fromkeys(found))


def _says_nothing(node: ast.stmt) -> bool:
    """A docstring, or code of a program only: ``if __name__ == "__main__"``."""
    if isinstance(node, ast.Expr):
        return isinstance(node.value, ast.Constant)
    return isinstance(node, ast.If) and ast.unparse(node.test) == PROGRAM


def _asks_names(node: ast.AST) -> bool:
    """Whether names of functions may matter; a class keeps its name anyway."""
    if isinstance(node, ast.Attribute) and node.attr == "__name__":
        return getattr(getattr(node.value, "func", None), "id", "") != "type"
    words = (getattr(node, field, None) for field in ("attr", "id", "value"))
    return any(isinstance(word, str) and word in OF_NAME for word in words)
