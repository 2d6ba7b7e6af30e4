"""What a source file defines, imports and names: what `repro.run.reach` walks.

An index is kept on disk under the file's own content, so that a build parses only what
changed since the last one.
"""

from __future__ import annotations

import ast
import hashlib
import json
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path

from repro.run.results import write_json

# Marks say how a producer is split and judged; they do not change what it computes.
MARKS = {"experiment", "experiments", "figure", "table", "claim", "numbers"}


@dataclass(frozen=True)
class Definition:
    """A top-level name: its line, hash of its bare syntax, what it names, its imports.

    ``chains`` are the names it uses, each with the attributes read from it.
    """

    line: int
    hash: str
    chains: list[tuple[str, list[str]]]
    imports: dict[str, tuple[str, str | None]]


@dataclass(frozen=True)
class Module:
    """One source file: its definitions and its imports by local name."""

    name: str
    definitions: dict[str, Definition]
    imports: dict[str, tuple[str, str | None]]


def index(name: str, path: Path, folder: Path) -> Module:
    """Index of the module ``name`` in ``path``, from ``folder`` if it is kept there."""
    source = path.read_bytes()
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
    return hashlib.sha256(Path(__file__).read_bytes()).hexdigest()


def _indexed(name: str, package: str, source: bytes, path: Path) -> Module:
    reader = _Reader(package)
    for node in _Bare().visit(ast.parse(source, str(path))).body:
        reader.add(node)
    definitions = {
        defined: _definition([*nodes, *reader.bare], package)
        for defined, nodes in reader.definitions.items()
    }
    return Module(name, definitions, reader.imports)


def _definition(nodes: list[ast.stmt], package: str) -> Definition:
    imports, chains = {}, set()
    for node in nodes:
        for inner in ast.walk(node):
            if isinstance(inner, ast.Import | ast.ImportFrom):
                imports |= import_aliases(inner, package)
        chains |= {(root, tuple(path)) for root, path in _chains(node)}
    return Definition(
        nodes[0].lineno,
        _hash(nodes),
        [(root, list(path)) for root, path in sorted(chains)],
        imports,
    )


class _Reader:
    """Sorts the statements of a module by the name that they define."""

    def __init__(self, package: str) -> None:
        self.package = package
        self.definitions: dict[str, list[ast.stmt]] = {}
        self.imports: dict[str, tuple[str, str | None]] = {}
        self.bare: list[ast.stmt] = []

    def add(self, node: ast.stmt) -> None:
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            self.definitions.setdefault(node.name, []).append(node)
        elif isinstance(node, ast.Import | ast.ImportFrom):
            self.imports.update(import_aliases(node, self.package))
        elif isinstance(node, ast.Assign | ast.AnnAssign | ast.AugAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            for target in targets:
                for name in _bound_names(target):
                    self.definitions.setdefault(name, []).append(node)
        elif isinstance(node, ast.If | ast.Try | ast.With):
            for child in ast.iter_child_nodes(node):
                if isinstance(child, ast.stmt):
                    self.add(child)
        elif not (isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)):
            self.bare.append(node)


def import_aliases(
    node: ast.Import | ast.ImportFrom, package: str
) -> dict[str, tuple[str, str | None]]:
    """Local name -> (module, attribute or None) of one import statement."""
    if isinstance(node, ast.Import):
        return {
            (a.asname or a.name.split(".")[0]): (
                a.name if a.asname else a.name.split(".")[0],
                None,
            )
            for a in node.names
        }
    base = node.module or ""
    if node.level:
        parents = package.split(".")[: len(package.split(".")) - node.level + 1]
        base = ".".join([*parents, base] if base else parents)
    return {a.asname or a.name: (base, a.name) for a in node.names}


def _bound_names(target: ast.expr) -> list[str]:
    if isinstance(target, ast.Name):
        return [target.id]
    if isinstance(target, ast.Tuple | ast.List):
        return [name for part in target.elts for name in _bound_names(part)]
    if isinstance(target, ast.Subscript | ast.Attribute | ast.Starred):
        return _bound_names(target.value)
    return []


class _Bare(ast.NodeTransformer):
    """Strip what cannot change a result: docstrings, annotations, producer marks."""

    def visit(self, node: ast.AST) -> ast.AST:
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            first = node.body[0]
            if isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant):
                node.body = node.body[1:] or [ast.Pass()]
            node.decorator_list = [d for d in node.decorator_list if not _is_mark(d)]
            if not isinstance(node, ast.ClassDef):
                node.returns = None
        if isinstance(node, ast.arg):
            node.annotation = None
        if isinstance(node, ast.AnnAssign) and node.value is not None:
            node = ast.copy_location(ast.Assign([node.target], node.value), node)
        return self.generic_visit(node)


def _is_mark(decorator: ast.expr) -> bool:
    return (
        isinstance(decorator, ast.Call) and getattr(decorator.func, "id", "") in MARKS
    )


def _chains(node: ast.AST) -> list[tuple[str, list[str]]]:
    """Every name used below ``node`` with the attributes read from it."""
    chains, inside = [], set()
    for inner in ast.walk(node):
        if isinstance(inner, ast.Attribute) and id(inner) not in inside:
            attributes, base = [], inner
            while isinstance(base, ast.Attribute):
                inside.add(id(base))
                attributes.insert(0, base.attr)
                base = base.value
            if isinstance(base, ast.Name):
                inside.add(id(base))
                chains.append((base.id, attributes))
        elif isinstance(inner, ast.Name) and id(inner) not in inside:
            chains.append((inner.id, []))
    return chains


def _hash(nodes: list[ast.stmt]) -> str:
    text = "\n".join(ast.unparse(node) for node in nodes)
    return hashlib.sha256(text.encode()).hexdigest()[:16]
