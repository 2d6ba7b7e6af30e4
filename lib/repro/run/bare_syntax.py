"""Names and statements of a module, without the syntax that changes no result.

Docstrings, annotations and the decorators of producers are excluded; so are comments.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping

PROJECT = ("chapters", "raxel", "repro")
# These decorators state how a producer is split and judged, not what it computes.
KINDS = ("experiment", "figure", "table", "claim", "numbers")
FAMILIES = {"experiments": "experiment", "figures": "figure"}
MARKS = (*KINDS, *FAMILIES)
FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)
COMPREHENSIONS = (ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp)
SCOPES = (*FUNCTIONS, ast.ClassDef, ast.Lambda, *COMPREHENSIONS)
# Context of a name, type comments, the `u` of a string: no effect on results.
UNWRITTEN = {"ctx", "type_comment", "kind"}
OWN = "§"

Chain = tuple[str, tuple[str, ...]]
"""``a.b.c`` as root and attributes."""
Target = tuple[str, str | None]
"""Module and attribute that a name is imported from; no attribute: the module."""


def bare(tree: ast.Module) -> ast.Module:
    """The tree without docstrings, annotations and marks."""
    return _Bare().visit(tree)


class _Bare(ast.NodeTransformer):
    def visit(self, node: ast.AST) -> ast.AST:
        if isinstance(node, (*FUNCTIONS, ast.ClassDef)):
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


def below(node: ast.AST) -> Iterator[tuple[ast.AST, bool]]:
    """Yield each node at or below this one, and whether it is in an inner scope."""
    todo = [(node, False)]
    while todo:
        one, inside = todo.pop()
        yield one, inside
        inner = inside or isinstance(one, SCOPES)
        todo += [(child, inner) for child in ast.iter_child_nodes(one)]


def bound_by(node: ast.AST) -> list[str]:
    """Return the names that a node itself binds, without imports and keywords of
    calls."""
    if isinstance(node, ast.Name):
        return [] if isinstance(node.ctx, ast.Load) else [node.id]
    if isinstance(node, ast.Global | ast.Nonlocal):
        return node.names
    if isinstance(node, ast.alias | ast.keyword):
        return []
    given = (getattr(node, field, None) for field in ("name", "arg", "rest"))
    return [name for name in given if isinstance(name, str)]


def filled_by(node: ast.AST) -> list[str]:
    """Return the name whose entry or attribute a node sets: ``TABLE`` of ``TABLE[1] =
    2``."""
    if not isinstance(node, ast.Attribute | ast.Subscript):
        return []
    base: ast.expr = node
    while isinstance(base, ast.Attribute | ast.Subscript):
        base = base.value
    set_here = isinstance(base, ast.Name) and not isinstance(node.ctx, ast.Load)
    return [base.id] if set_here else []


def import_aliases(
    node: ast.Import | ast.ImportFrom, package: str
) -> dict[str, Target]:
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


def chain(node: object) -> Chain | None:
    """Return the chain of a node; None for any other node."""
    attributes: list[str] = []
    while isinstance(node, ast.Attribute):
        attributes.insert(0, node.attr)
        node = node.value
    return (node.id, tuple(attributes)) if isinstance(node, ast.Name) else None


def chains(nodes: Iterable[ast.AST]) -> Iterator[Chain]:
    """Yield every name used at or below the nodes, with its attributes."""
    todo = list(nodes)
    while todo:
        one = todo.pop()
        found = chain(one)
        if found:
            yield found
        else:
            todo += ast.iter_child_nodes(one)


class Writer:
    """Write the statements of a definition independently of the names of definitions.

    Its ``own`` name is replaced by a sign. A chain whose root is in ``leads`` is
    replaced by the number of its module and path in ``numbers``. Imports of the project
    are omitted, except of names in ``kept``, which do not change.
    """

    def __init__(
        self,
        own: str,
        leads: Mapping[str, Target],
        kept: Collection[str],
        imported: Callable[[ast.Import | ast.ImportFrom], Mapping[str, Target]],
    ) -> None:
        self.own = own
        self.leads = leads
        self.kept = kept
        self.imported = imported
        self.numbers: dict[tuple[str, tuple[str, ...]], int] = {}

    def statement(self, node: ast.stmt) -> str:
        """Return a statement of the module. A class keeps its name, because values show
        it."""
        ours = isinstance(node, FUNCTIONS) and self._is_own(node.name)
        return self._node(node, {"name", *UNWRITTEN} if ours else UNWRITTEN)

    def _node(self, node: ast.AST, left_out: Collection[str] = UNWRITTEN) -> str:
        found = chain(node)
        if found:
            return self._chain(*found)
        if isinstance(node, ast.Import | ast.ImportFrom) and self._settled(node):
            return "Pass()"
        given = ((f, getattr(node, f, None)) for f in node._fields if f not in left_out)
        text = ",".join(
            f"{f}={self._value(v)}" for f, v in given if v not in (None, [])
        )
        return f"{type(node).__name__}({text})"

    def _value(self, value: object) -> str:
        if isinstance(value, list):
            return f"[{','.join(map(self._value, value))}]"
        return self._node(value) if isinstance(value, ast.AST) else repr(value)

    def _chain(self, root: str, attributes: tuple[str, ...]) -> str:
        if root in self.leads:
            module, name = self.leads[root]
            path = (module, ((name,) if name else ()) + attributes)
            return f"{OWN}{self.numbers.setdefault(path, len(self.numbers))}"
        return ".".join((OWN if self._is_own(root) else root, *attributes))

    def _is_own(self, name: str) -> bool:
        return name == self.own and name not in self.kept

    def _settled(self, node: ast.Import | ast.ImportFrom) -> bool:
        """Whether the names used later cover everything that an import does."""
        aliases = self.imported(node)
        homes = {module.split(".")[0] for module, _ in aliases.values()}
        return homes <= set(PROJECT) and not aliases.keys() & set(self.kept)
