"""Names that a page quotes, and the statement that makes each.

Prose takes a value as {glue:text}`name:.2f`; `repro.page.reader.value` names it, in the
page's display lines or in a function that these call. `values()` names the regenerated
numbers of the page, from its functions that are marked with `numbers`.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from repro.run.discover import PAGE_FILE, Producer
from repro.run.names import Sources, dotted
from repro.run.where.meanings import given_back
from repro.run.where.scopes import COMPREHENSIONS, Scope, ScopeAtlas, Term, position
from repro.run.where.texts import Reader, Text, fits, fixed_length, merged

GLUED = re.compile(r"\{glue:text\}`([^`:]+)")
READER = "repro.page.reader"
OF_NUMBERS = ("", ".low", ".high", ".text")


def quotes(text: str) -> dict[str, int]:
    """Names that the text of a page quotes, each with the line that does so first."""
    found: dict[str, int] = {}
    for number, line in enumerate(text.splitlines(), 1):
        for name in GLUED.findall(line):
            found.setdefault(name, number)
    return found


@dataclass(frozen=True)
class Maker:
    """A statement that names a value: the texts that its name can be, and its place.

    ``made`` is what it names; ``numbers`` the marked function whose number it is.
    """

    text: Text
    path: Path
    line: int
    function: str
    made: Term | None = None
    numbers: Producer | None = None


class Quoted:
    """What one page names: its display lines and the functions that they call."""

    def __init__(self, sources: Sources, page: str, numbers: Iterable[Producer]):
        self.sources = sources
        self.page = page
        self.numbers = tuple(numbers)
        self.atlas = ScopeAtlas(sources)
        self.reader = Reader(self.atlas)
        self._calls: list[Term] = []
        self._walked: set[Scope] = set()
        self.home = self.atlas.module(sources.root / "chapters" / page / PAGE_FILE)
        self._walk(self.home)
        self.makers = list(self._makers())

    def made_by(self, name: str) -> list[Maker]:
        """The statements that may make a name: those that know most of it."""
        known = [m for m in self.makers if fits(m.text, name)]
        most = max((fixed_length(m.text) for m in known), default=0)
        best = [m for m in known if fixed_length(m.text) == most]
        return list({(m.path, m.line): m for m in best}.values())

    def _walk(self, scope: Scope) -> None:
        """Meet every call of a scope, and of the functions that it calls."""
        self._walked.add(scope)
        for node, inner in self._within(scope):
            if not isinstance(node, ast.Call):
                continue
            called = self.reader.called(Term(node, inner))
            if called and called not in self._walked:
                self._walk(called)
            elif _names(node, inner):
                self._calls.append(Term(node, inner))

    def _within(self, scope: Scope) -> Iterator[tuple[ast.AST, Scope]]:
        """Nodes of a scope, each with the scope in which its names are bound."""
        inside: dict[ast.AST, Scope] = {}
        for node in scope.own():
            inner = inside.get(node, scope)
            yield node, inner
            if isinstance(node, COMPREHENSIONS):
                inner = self.atlas.within(node, inner)
            for child in ast.iter_child_nodes(node):
                inside[child] = inner

    def _makers(self) -> Iterator[Maker]:
        for call in self._calls:
            if not call.node.args:
                yield from self._of_numbers()
                continue
            name, *rest = call.node.args
            at_call = isinstance(name, ast.Constant | ast.JoinedStr)
            for text, entry in self.reader.placed(Term(name, call.scope)):
                as_they_are = _names_entries(call) or (
                    entry and _elsewhere(entry.scope, call.scope)
                )
                if entry and not at_call and as_they_are:
                    made = Term(entry.value, entry.scope)
                    yield self._maker(text, entry.key, made)
                else:
                    made = Term(rest[0], call.scope) if rest else call
                    yield self._maker(text, call.node, made)

    def _maker(self, text: Text, node: ast.AST, made: Term) -> Maker:
        function = getattr(_function(made.scope).node, "name", "")
        return Maker(text, made.scope.path, node.lineno, function, made)

    def _of_numbers(self) -> Iterator[Maker]:
        """The numbers that the marked functions of the page give, by their keys."""
        for one in self.numbers:
            path = self.sources.root / "chapters" / one.path
            given = self.atlas.function([one.function], self.atlas.module(path))
            for back in given_back(given):
                for entry in self.reader.entries(back):
                    value = Term(entry.value, entry.scope)
                    for text in self.reader.texts(Term(entry.key, entry.scope)):
                        for ending in OF_NUMBERS:
                            yield Maker(
                                merged((*text, ending)), entry.scope.path,
                                entry.key.lineno, one.function, value, one,
                            )  # fmt: skip


def _names(call: ast.Call, scope: Scope) -> bool:
    """Whether a call names values for the prose."""
    name = dotted(call.func)
    inner: Scope | None = scope
    while inner and name:
        if name[0] in inner.imports:
            return inner.imports[name[0]] in ((READER, "value"), (READER, "values"))
        inner = inner.parent
    return False


def _names_entries(call: Term) -> bool:
    """Whether a call names a key and its value, as one loop over a dict gives both."""
    both = call.node.args
    if len(both) != 2 or not all(isinstance(one, ast.Name) for one in both):
        return False
    name, value = (call.scope.reaching(one.id, position(one)) for one in both)
    return bool(name) and [b.node for b in name] == [b.node for b in value]


def _elsewhere(scope: Scope, other: Scope) -> bool:
    """Whether a scope is of a function, and of another one."""
    function = _function(scope)
    return isinstance(function.node, ast.FunctionDef) and function is not _function(
        other
    )


def _function(scope: Scope) -> Scope:
    """The function, or the module, around a comprehension."""
    while isinstance(scope.node, COMPREHENSIONS) and scope.parent:
        scope = scope.parent
    return scope
