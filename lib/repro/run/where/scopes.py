"""Names of a page's functions and what they are bound to, through imports and calls.

A page's display lines are comments in its file; here they are read as what runs.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from repro.run.discover import PAGE_FILE
from repro.run.names import Sources, dotted

FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda)
COMPREHENSIONS = (ast.GeneratorExp, ast.ListComp, ast.SetComp, ast.DictComp)
ELEMENT = "element"
# Line and column; None where the order of running is not that of the lines.
Position = tuple[int, int] | None
ADDS = (["update"], ["extend"], ["append"], ["add"])
BLOCKS = ("body", "orelse", "finalbody", "handlers")
ACTIVE = re.compile(r"^# %%.*active-ipynb")
CELL = "# %%"
CHAPTERS = "chapters"


@dataclass(frozen=True, eq=False)
class Term:
    """An expression in its scope; ``entry`` is the dict entry whose key it is."""

    node: ast.AST
    scope: Scope
    entry: DictEntry | None = None


@dataclass(frozen=True, eq=False)
class LoopRow:
    """Terms that stand beside each other, as those of `zip` or of `items()`."""

    terms: tuple[Term | LoopRow, ...]


@dataclass(frozen=True, eq=False)
class DictEntry:
    """A key of a dict with its value, and the statement or line that puts it there."""

    key: ast.expr
    value: ast.expr
    scope: Scope


@dataclass(frozen=True)
class Binding:
    """What a name stands for: an expression, then parts of it.

    ``steps`` lead from the expression to the name: `ELEMENT` for one of all that it
    goes over, a number for a place in it. It holds from ``start`` on to the ``end`` of
    its block, unless it only ``adds`` to what stood there.
    """

    node: ast.AST
    steps: tuple[str | int, ...] = ()
    start: Position = None
    end: Position = None
    adds: bool = False


@dataclass(eq=False)
class Scope:
    """A module, a function or a comprehension, with the names that it binds.

    ``calls`` are the calls of a function that were met, each in its own scope.
    """

    path: Path
    node: ast.AST
    parent: Scope | None = None
    fixed: dict[str, Term | LoopRow] = field(default_factory=dict)
    calls: list[Term] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.bound: dict[str, list[Binding]] = {}
        self.entries: dict[str, list[tuple[ast.expr, ast.expr]]] = {}
        self.functions: dict[str, ast.FunctionDef] = {}
        self.imports: dict[str, tuple[str, str]] = {}
        ends: dict[ast.AST, Position] = {}
        for node in self.own():
            end = ends.get(node)
            self._bind(node, end)
            for child in ast.iter_child_nodes(node):
                ends[child] = end
            for block in (getattr(node, name, None) for name in BLOCKS):
                for child in block if isinstance(block, list) else ():
                    ends[child] = position(block[-1], last=True)

    def own(self) -> Iterator[ast.AST]:
        """Nodes of this scope, without those of the functions defined inside."""
        if isinstance(self.node, COMPREHENSIONS):
            yield from self.node.generators
            return
        body = self.node.body
        todo = list(body) if isinstance(body, list) else [body]
        while todo:
            node = todo.pop(0)
            yield node
            if isinstance(node, ast.FunctionDef | ast.ClassDef):
                continue
            todo += ast.iter_child_nodes(node)

    def _bind(self, node: ast.AST, end: Position) -> None:
        if isinstance(node, ast.Assign):
            for target in node.targets:
                self._target(target, node, node.value, end)
        elif isinstance(node, ast.AnnAssign | ast.AugAssign | ast.NamedExpr):
            if node.value:
                self._target(node.target, node, node.value, end)
        elif isinstance(node, ast.For | ast.comprehension):
            self._target(node.target, node, node.iter, _end_of(node), (ELEMENT,))
        elif isinstance(node, ast.withitem) and node.optional_vars:
            self._target(node.optional_vars, node, node.context_expr, end)
        elif isinstance(node, ast.FunctionDef):
            self.functions[node.name] = node
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            for alias in node.names:
                self.imports[alias.asname or alias.name] = (node.module, alias.name)
        elif isinstance(node, ast.Call) and dotted(node.func)[1:] in ADDS:
            (name, method), start = dotted(node.func), position(node, last=True)
            whole = method in ("update", "extend")
            self.bound.setdefault(name, []).extend(
                Binding(g if whole else ast.List([g]), (), start, end, adds=True)
                for g in node.args
            )

    def _target(
        self,
        target: ast.expr,
        by: ast.AST,
        value: ast.expr,
        end: Position,
        steps: tuple[str | int, ...] = (),
    ) -> None:
        if isinstance(target, ast.Name):
            adds, start = isinstance(by, ast.AugAssign), position(value, last=True)
            binding = Binding(value, steps, start, end, adds)
            self.bound.setdefault(target.id, []).append(binding)
        elif isinstance(target, ast.Subscript) and isinstance(target.value, ast.Name):
            self.entries.setdefault(target.value.id, []).append((target.slice, value))
        elif isinstance(target, ast.Tuple | ast.List):
            stars = [isinstance(t, ast.Starred) for t in target.elts]
            after = stars.index(True) if any(stars) else len(stars)
            for place, inner in enumerate(target.elts):
                if place != after:
                    step = place if place < after else place - len(stars)
                    self._target(inner, by, value, end, (*steps, step))

    def reaching(self, name: str, used: Position) -> list[Binding]:
        """Bindings of a name that may hold where it is used; all where that is open."""
        every = self.bound.get(name, [])
        if used is None or any(b.start is None for b in every):
            return every
        before = sorted((b for b in every if b.start <= used), key=lambda b: b.start)
        found = []
        for binding in reversed(before):
            holds = binding.end is None or used <= binding.end
            found.append(binding)
            if holds and not binding.adds:
                return found
        return found or every

    def parameters(self) -> list[str]:
        """Names of the parameters of a function that stand in their order."""
        if not isinstance(self.node, FUNCTIONS):
            return []
        given = self.node.args
        return [a.arg for a in (*given.posonlyargs, *given.args, *given.kwonlyargs)]

    def arguments(self, name: str) -> list[Term]:
        """What a parameter was given at the calls that were met, or its default."""
        given = self.node.args
        order = [a.arg for a in (*given.posonlyargs, *given.args)]
        defaults = dict(zip(reversed(order), reversed(given.defaults), strict=False))
        defaults |= {
            a.arg: d
            for a, d in zip(given.kwonlyargs, given.kw_defaults, strict=True)
            if d
        }
        found = []
        for call in self.calls:
            named = {k.arg: k.value for k in call.node.keywords}
            place = order.index(name) if name in order else len(call.node.args)
            if name in named:
                found.append(Term(named[name], call.scope))
            elif place < len(call.node.args):
                found.append(Term(call.node.args[place], call.scope))
            elif name in defaults:
                found.append(Term(defaults[name], self.parent or self))
        return found


class ScopeAtlas:
    """Scopes of the modules and functions of one page, each made once."""

    def __init__(self, sources: Sources) -> None:
        self.sources = sources
        self._modules: dict[Path, Scope] = {}
        self._functions: dict[ast.AST, Scope] = {}

    def module(self, path: Path) -> Scope:
        """The scope of a file; that of a page with its display lines."""
        if path not in self._modules:
            body = self.sources.body(path)
            if path.name == PAGE_FILE:
                body = ast.parse(displayed(path.read_text("utf-8")), str(path)).body
            self._modules[path] = Scope(path, ast.Module(body, []))
        return self._modules[path]

    def within(self, node: ast.AST, parent: Scope) -> Scope:
        """The scope of a function or a comprehension that stands in another one."""
        if node not in self._functions:
            self._functions[node] = Scope(parent.path, node, parent)
        return self._functions[node]

    def function(self, name: list[str], scope: Scope) -> Scope | None:
        """The function of the chapters that a name stands for, there."""
        inner: Scope | None = scope
        while inner and len(name) == 1:
            if name[0] in inner.functions:
                return self.within(inner.functions[name[0]], inner)
            if name[0] in (*inner.bound, *inner.parameters()):
                return None
            inner = inner.parent
        home = self.home(name, scope)
        if home is None or home[1] not in home[0].functions:
            return None
        return self.within(home[0].functions[home[1]], home[0])

    def home(self, name: list[str], scope: Scope) -> tuple[Scope, str] | None:
        """The module of the chapters that defines what is not local, and its name."""
        inner: Scope | None = scope
        while inner and name:
            if name[0] in inner.imports:
                return self._imported(*inner.imports[name[0]], name[1:])
            if inner.parent is None and name[0] in (*inner.bound, *inner.functions):
                return (inner, name[0]) if len(name) == 1 else None
            inner = inner.parent
        return None

    def _imported(
        self, module: str, name: str, rest: list[str]
    ) -> tuple[Scope, str] | None:
        if module.partition(".")[0] != CHAPTERS:
            return None
        inside = self.sources.file(f"{module}.{name}")
        home = inside or self.sources.file(module)
        if home is None:
            return None
        return self.home(rest if inside else [name, *rest], self.module(home))


def position(node: ast.AST, last: bool = False) -> Position:
    """Where an expression begins, or ends; None for one that stands nowhere."""
    if not hasattr(node, "lineno"):
        return None
    if last:
        return node.end_lineno, node.end_col_offset
    return node.lineno, node.col_offset


def _end_of(loop: ast.For | ast.comprehension) -> Position:
    """Where the target of a loop no longer holds."""
    return position(loop, last=True) if isinstance(loop, ast.For) else None


def displayed(text: str) -> str:
    """A page's text, of the same lines, with its display cells as code."""
    lines, active = [], False
    for line in text.splitlines():
        if line.startswith(CELL):
            active = bool(ACTIVE.match(line))
        elif active and line.startswith("#"):
            line = line[1:].removeprefix(" ")
        lines.append(line)
    return "\n".join(lines)
