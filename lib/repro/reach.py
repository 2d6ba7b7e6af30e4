"""Keys over the code that a function reaches.

A result is rebuilt when something it was computed with changed, and only then. The key
of a function covers its own syntax tree and, followed by name through the chapters and
`lib/`, every function, class and constant it can reach; comments, docstrings and
annotations do not count. A package from outside counts with its pinned version.
"""

from __future__ import annotations

import ast
import hashlib
import re
from functools import cache
from pathlib import Path

PROJECT = ("chapters", "raxel", "repro")
DISTRIBUTION = {"cv2": "opencv-python-headless", "yaml": "pyyaml"}
# Marks say how a producer is split and judged; they do not change what it computes.
MARKS = {"experiment", "figure", "table", "claim", "numbers"}


class _Module:
    """Top-level names of one source file: definitions, imports, bare statements."""

    def __init__(self, name: str, path: Path) -> None:
        self.name = name
        self.package = name if path.name == "__init__.py" else name.rpartition(".")[0]
        self.definitions: dict[str, list[ast.stmt]] = {}
        self.imports: dict[str, tuple[str, str | None]] = {}
        self.bare: list[ast.stmt] = []
        tree = ast.parse(path.read_text("utf-8"), str(path))
        for node in tree.body:
            self._add(node)

    def _add(self, node: ast.stmt) -> None:
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
                    self._add(child)
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
        return self.generic_visit(node)


def _is_mark(decorator: ast.expr) -> bool:
    return (
        isinstance(decorator, ast.Call) and getattr(decorator.func, "id", "") in MARKS
    )


class Reach:
    """Keys of functions in the checkout at ``root`` (modules: chapters, lib/)."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self._modules: dict[str, _Module | None] = {}
        self.versions = _pins(root / "environment.txt")

    def key(self, *functions: tuple[str, str]) -> str:
        """Hash over everything the (module, name) pairs reach."""
        digest = hashlib.sha256()
        for name, part in sorted(self.parts(*functions).items()):
            digest.update(f"{name}={part}\n".encode())
        return digest.hexdigest()[:16]

    def parts(self, *functions: tuple[str, str]) -> dict[str, str]:
        """Reached definition -> hash of its bare syntax, or pinned version."""
        found: dict[str, str] = {}
        todo = list(functions)
        while todo:
            module_name, name = todo.pop()
            label = f"{module_name}:{name}"
            if label in found:
                continue
            module = self._module(module_name)
            if module is None:
                package = module_name.split(".")[0]
                pin = DISTRIBUTION.get(package, package)
                if pin in self.versions:
                    found[pin] = self.versions[pin]
                continue
            if name == "*":
                todo += [(module_name, n) for n in module.definitions]
            elif name in module.definitions:
                nodes = module.definitions[name]
                found[label] = _hash(nodes)
                if module.bare:
                    found[f"{module_name}:(statements)"] = _hash(module.bare)
                todo += self._references(module, [*nodes, *module.bare])
            elif name in module.imports:
                todo += self._resolve(*module.imports[name], [])
            elif self._module(f"{module_name}.{name}") is not None:
                todo.append((f"{module_name}.{name}", "*"))
        return found

    def _references(
        self, module: _Module, nodes: list[ast.stmt]
    ) -> list[tuple[str, str]]:
        aliases = dict(module.imports)
        for node in nodes:
            for inner in ast.walk(node):
                if isinstance(inner, ast.Import | ast.ImportFrom):
                    aliases |= import_aliases(inner, module.package)
        references: list[tuple[str, str]] = []
        for node in nodes:
            for root, attributes in _chains(node):
                if root in aliases:
                    references += self._resolve(*aliases[root], attributes)
                elif root in module.definitions:
                    references.append((module.name, root))
        return references

    def _resolve(
        self, module: str, attribute: str | None, attributes: list[str]
    ) -> list[tuple[str, str]]:
        """Definition that ``module[.attribute][.attributes...]`` names."""
        path = ([attribute] if attribute else []) + attributes
        while path and self._module(f"{module}.{path[0]}") is not None:
            submodule = self._module(module)
            if submodule is not None and path[0] in submodule.definitions:
                break
            module, path = f"{module}.{path[0]}", path[1:]
        return [(module, path[0] if path else "*")]

    def _module(self, name: str) -> _Module | None:
        if name not in self._modules:
            path = self._path(name)
            self._modules[name] = _Module(name, path) if path else None
        return self._modules[name]

    def _path(self, name: str) -> Path | None:
        top = name.split(".")[0]
        if top not in PROJECT:
            return None
        base = self.root if top == "chapters" else self.root / "lib"
        stem = base.joinpath(*name.split("."))
        for path in (stem.with_suffix(".py"), stem / "__init__.py"):
            if path.is_file():
                return path
        return None


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
    text = "\n".join(_text(ast.unparse(node)) for node in nodes)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


@cache
def _text(source: str) -> str:
    return ast.unparse(ast.fix_missing_locations(_Bare().visit(ast.parse(source))))


def _pins(path: Path) -> dict[str, str]:
    text = path.read_text("utf-8") if path.is_file() else ""
    return dict(re.findall(r"^([a-z0-9_.-]+)==([^\s;\\]+)", text, flags=re.M))
