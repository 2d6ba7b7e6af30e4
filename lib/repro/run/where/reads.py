"""Which experiments a value is computed from, and what else it is made of."""

from __future__ import annotations

import ast
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache

from repro.run.names import Place, dotted
from repro.run.where.scopes import (
    COMPREHENSIONS,
    FUNCTIONS,
    LoopRow,
    Scope,
    Term,
    position,
)
from repro.run.where.texts import ANY, Reader, Text

OPENS = "open_results"
BEHIND = "results_behind"


@dataclass
class Read:
    """What stands behind a value.

    ``named`` are the experiments that it names, ``among`` those of which it may take
    some (all that were opened together); ``functions`` are those of the chapters that
    compute it, ``constants`` what stands at the top of a module and goes into it.
    """

    named: dict[str, None] = field(default_factory=dict)
    among: dict[str, None] = field(default_factory=dict)
    functions: list[Place] = field(default_factory=list)
    constants: list[tuple[str, Place]] = field(default_factory=list)

    @property
    def experiments(self) -> list[str]:
        """The experiments: those that are named, or else those opened together."""
        return list(self.named or self.among)


class Reads:
    """Follows a value back to the results that it is computed from.

    ``experiments`` gives the experiments that a text is or can be the id of;
    ``behind`` those behind a figure or table.
    """

    def __init__(
        self,
        reader: Reader,
        experiments: Callable[[Text], list[str]],
        behind: Callable[[str], list[str]],
    ) -> None:
        self.reader = reader
        self.experiments = experiments
        self.behind = behind
        self.whole = False

    def of(self, made: Term) -> Read:
        """What stands behind an expression that is named for the prose."""
        read = Read()
        self._follow(made, read, set(), among=False)
        if not read.experiments:
            # A value picked by what stands beside it: all that it was picked from.
            self.whole = True
            self._follow(made, read, set(), among=False)
            self.whole = False
        return read

    def _follow(self, term: Term | LoopRow, read: Read, seen: set, among: bool) -> None:
        if isinstance(term, LoopRow):
            for part in term.terms:
                self._follow(part, read, seen, among)
            return
        key = (term.node, term.scope, among)
        if key in seen:
            return
        seen.add(key)
        node, scope = term.node, term.scope
        if isinstance(node, ast.Name | ast.Attribute) and dotted(node):
            self._name(term, read, seen, among)
            return
        self._texts(term, read, among)
        inner = scope
        if isinstance(node, COMPREHENSIONS):
            inner = (
                scope if scope.node is node else self.reader.atlas.within(node, scope)
            )
            among = among or _opens(node)
        if isinstance(node, ast.Call):
            called = self.reader.called(term)
            if called:
                self._function(called, read, seen)
        for child in ast.iter_child_nodes(node):
            if not isinstance(child, ast.expr_context | ast.operator):
                self._follow(Term(child, inner), read, seen, among)

    def _name(self, term: Term, read: Read, seen: set, among: bool) -> None:
        """Go on to what a name is bound to where it is used."""
        name, scope = dotted(term.node), term.scope
        function = self.reader.atlas.function(name, scope)
        if function:
            self._function(function, read, seen)
            return
        owner = _owner(name[0], scope)
        if owner is None:
            self._constant(term, read, seen, among)
            return
        if name[0] in owner.fixed:
            self._follow(owner.fixed[name[0]], read, seen, among)
            return
        here = owner is scope or not isinstance(scope.node, FUNCTIONS)
        used = position(term.node) if here else None
        for binding in owner.reaching(name[0], used):
            parts = [] if self.whole else self.reader.bound(binding, owner)
            where = owner.parent if isinstance(owner.node, COMPREHENSIONS) else owner
            for part in parts or [Term(binding.node, where)]:
                self._follow(part, read, seen, among)
        for _, value in owner.entries.get(name[0], ()):
            self._follow(Term(value, owner), read, seen, among)
        if name[0] in owner.parameters():
            for given in owner.arguments(name[0]):
                self._follow(given, read, seen, among)

    def _constant(self, term: Term, read: Read, seen: set, among: bool) -> None:
        """Go on to what stands at the top of a module."""
        name, atlas = dotted(term.node), self.reader.atlas
        home = atlas.home(name, term.scope) or atlas.home(name[:1], term.scope)
        if home is None or home[1] not in home[0].bound:
            return
        module, last = home
        bound = module.bound[last]
        known = any(place.node is bound[0].node for _, place in read.constants)
        if last.isupper() and not known:
            read.constants.append((last, Place(module.path, bound[0].node)))
        for text in self.reader.texts(term):
            self._experiments(text, read, among)
        for binding in bound:
            parts = self.reader.bound(binding, module)
            for part in parts or [Term(binding.node, module)]:
                self._follow(part, read, seen, among)

    def _function(self, called: Scope, read: Read, seen: set) -> None:
        """All that a function names; what it was given is followed at its call."""
        if called in seen:
            return
        seen.add(called)
        place = Place(called.path, called.node)
        if place not in read.functions:
            read.functions.append(place)
        # The constants that it names are its own matter.
        constants = list(read.constants)
        inside: dict[ast.AST, Scope] = {}
        for node in called.own():
            scope = inside.get(node, called)
            if isinstance(node, COMPREHENSIONS):
                scope = self.reader.atlas.within(node, scope)
            for child in ast.iter_child_nodes(node):
                inside[child] = scope
            term, among = Term(node, scope), _together(scope, called)
            self._texts(term, read, among)
            if isinstance(node, ast.Name | ast.Attribute) and dotted(node):
                owner = _owner(dotted(node)[0], scope)
                if owner is None or not _inside(owner, called):
                    self._name(term, read, seen, among)
        read.constants[:] = constants

    def _texts(self, term: Term, read: Read, among: bool) -> None:
        """Experiments that a text in the code is the id of."""
        node = term.node
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            self._experiments((node.value,), read, among)
        elif isinstance(node, ast.JoinedStr):
            for text in self.reader.texts(term):
                self._experiments(text, read, among)
        elif isinstance(node, ast.Call) and dotted(node.func)[-1:] == [BEHIND]:
            for text in self.reader.texts(Term(node.args[0], term.scope)):
                if ANY not in text:
                    read.among |= dict.fromkeys(self.behind("".join(text)))

    def _experiments(self, text: Text, read: Read, among: bool) -> None:
        found = dict.fromkeys(self.experiments(text))
        if among:
            read.among |= found
        else:
            read.named |= found


def _owner(name: str, scope: Scope) -> Scope | None:
    """The function or comprehension that binds a name; None for a module."""
    inner: Scope | None = scope
    while inner and inner.parent:
        if name in inner.fixed or name in inner.bound or name in inner.parameters():
            return inner
        inner = inner.parent
    return None


def _inside(scope: Scope, function: Scope) -> bool:
    """Whether a scope is that of the function, or stands in it."""
    inner: Scope | None = scope
    while inner and inner is not function:
        inner = inner.parent
    return inner is function


def _together(scope: Scope, function: Scope) -> bool:
    """Whether a comprehension of a function opens results there, one after another."""
    inner: Scope | None = scope
    while inner and inner is not function:
        if _opens(inner.node):
            return True
        inner = inner.parent
    return False


@cache
def _opens(node: ast.AST) -> bool:
    return any(isinstance(n, ast.Name) and n.id == OPENS for n in ast.walk(node))
