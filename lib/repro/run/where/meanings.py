"""What a name stands for: followed through assignments, loops, calls and imports.

Loops are not followed together: two in one expression give every pair.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import product
from pathlib import Path

from repro.run.names import dotted
from repro.run.where.scopes import (
    COMPREHENSIONS,
    ELEMENT,
    FUNCTIONS,
    Binding,
    DictEntry,
    LoopRow,
    Position,
    Scope,
    ScopeAtlas,
    Term,
    position,
)

Part = Term | LoopRow
ORDERED = (ast.Tuple, ast.List, ast.Call, ast.GeneratorExp, ast.ListComp)
SAME_ELEMENTS = ("sorted", "reversed", "list", "tuple", "set", "iter", "dict", "chain")


class Meanings:
    """What names and expressions of a page's scopes stand for."""

    def __init__(self, atlas: ScopeAtlas) -> None:
        self.atlas = atlas
        self._open: set[tuple[str, ast.AST, int]] = set()

    @contextmanager
    def _once(self, what: str, term: Term) -> Iterator[bool]:
        """Whether this is not being looked up already: names may go in circles."""
        key = (what, term.node, id(term.scope))
        if key in self._open:
            yield False
            return
        self._open.add(key)
        try:
            yield True
        finally:
            self._open.discard(key)

    def resolved(self, term: Part) -> list[Part]:
        """The expressions that a name, a call of ours, or a choice stands for."""
        if isinstance(term, LoopRow):
            return [term]
        with self._once("resolved", term) as first:
            return self._resolved(term) if first else []

    def _resolved(self, term: Term) -> list[Part]:
        before = self._before(term)
        found = [r for one in before for r in self.resolved(one)]
        if not before and not isinstance(term.node, ast.Name | ast.Attribute):
            return [term]
        if term.entry is None:
            return found
        return [
            Term(r.node, r.scope, r.entry or term.entry) if isinstance(r, Term) else r
            for r in found
        ]

    def called(self, call: Term) -> Scope | None:
        """The function of the chapters that a call runs; it keeps the call."""
        name = dotted(call.node.func)
        scope = self.atlas.function(name, call.scope) if name else None
        if scope and not any(c.node is call.node for c in scope.calls):
            scope.calls.append(call)
        return scope

    def meanings(
        self, name: list[str], scope: Scope, used: Position = None
    ) -> list[Part]:
        """What a name, split at its dots, is bound to where it is used."""
        if not name:
            return []
        inner: Scope | None = scope
        while inner:
            if name[0] in inner.fixed:
                return [inner.fixed[name[0]]] if len(name) == 1 else []
            if name[0] in inner.bound or name[0] in inner.parameters():
                break
            if name[0] in inner.imports:
                inner = None
                break
            if isinstance(inner.node, FUNCTIONS):
                used = None  # a function runs when it is called, not where it stands
            inner = inner.parent
        if inner is None:
            home = self.atlas.home(name, scope)
            if home is None or home[1] not in home[0].bound:
                return []
            inner, name = home[0], [home[1]]
        if len(name) > 1:
            return []
        found = [
            part
            for binding in inner.reaching(name[0], used)
            for part in self.bound(binding, inner)
        ]
        if name[0] in inner.parameters() and not found:
            found += inner.arguments(name[0])
        return found

    def bound(self, binding: Binding, scope: Scope) -> list[Part]:
        """The parts of an expression that a binding gives a name."""
        where = scope.parent if isinstance(scope.node, COMPREHENSIONS) else scope
        # A later loop of a comprehension may go over what an earlier one binds.
        where = scope if where and self._binds(binding.node, scope) else where
        parts: list[Part] = [Term(binding.node, where or scope)]
        for step in binding.steps:
            parts = [
                inner
                for part in parts
                for inner in (
                    self.elements(part) if step == ELEMENT else self.at(part, step)
                )
            ]
        return parts

    @staticmethod
    def _binds(node: ast.AST, scope: Scope) -> bool:
        if not isinstance(scope.node, COMPREHENSIONS):
            return False
        names = {n.id for n in ast.walk(node) if isinstance(n, ast.Name)}
        return bool(names & set(scope.bound))

    def at(self, part: Part, step: int) -> list[Part]:
        """The term at a place of what has an order."""
        found: list[Part] = []
        for one in self.resolved(part):
            if isinstance(one, LoopRow):
                inside: list[Part] = list(one.terms)
            elif isinstance(one.node, ORDERED):
                inside = self.elements(one)
            else:
                continue
            if -len(inside) <= step < len(inside):
                found.append(inside[step])
        return found

    def _subscripted(self, node: ast.Subscript, scope: Scope) -> list[Part]:
        base = Term(node.value, scope)
        if isinstance(node.slice, ast.Slice):
            return []
        if isinstance(node.slice, ast.Constant) and isinstance(node.slice.value, int):
            known = self.at(base, node.slice.value)
            if known:
                return known
        entries = self.entries(base)
        keys = self._constants(Term(node.slice, scope))
        chosen = [
            Term(e.value, e.scope)
            for e in entries
            if keys & self._constants(Term(e.key, e.scope))
        ]
        return chosen or [Term(e.value, e.scope) for e in entries]

    def _constants(self, term: Term) -> set:
        """Constants that an expression can be, as far as they are known."""
        known = (r.node for r in self.resolved(term) if isinstance(r, Term))
        return {node.value for node in known if isinstance(node, ast.Constant)}

    def elements(self, part: Part) -> list[Part]:
        """All that a loop over an expression goes over, as far as it is known."""
        if isinstance(part, LoopRow):
            return list(part.terms)
        with self._once("elements", part) as first:
            if not first:
                return []
            found = [
                inner for one in self._before(part) for inner in self.elements(one)
            ]
            if isinstance(part.node, ast.Name):
                found += [self._key(e) for e in self._put(part)]
            return found or self._elements(part)

    def _before(self, term: Term) -> list[Part]:
        """What a name, a call of ours or a choice stands for, one step back."""
        node, scope = term.node, term.scope
        if isinstance(node, ast.Name | ast.Attribute):
            return self.meanings(dotted(node), scope, position(node))
        if isinstance(node, ast.NamedExpr | ast.Starred):
            return [Term(node.value, scope)]
        if isinstance(node, ast.IfExp):
            return [Term(n, scope) for n in (node.body, node.orelse)]
        if isinstance(node, ast.BoolOp):
            return [Term(n, scope) for n in node.values]
        if isinstance(node, ast.Subscript):
            return self._subscripted(node, scope)
        if isinstance(node, ast.Call):
            called = self.called(term)
            return given_back(called) if called else []
        return []

    def _elements(self, term: Term) -> list[Part]:
        node, scope = term.node, term.scope
        if isinstance(node, ast.Tuple | ast.List | ast.Set):
            return [
                part
                for item in node.elts
                for part in (
                    self.elements(Term(item.value, scope))
                    if isinstance(item, ast.Starred)
                    else [Term(item, scope)]
                )
            ]
        if isinstance(node, ast.Dict | ast.DictComp):
            return [self._key(e) for e in self.entries(term)]
        if isinstance(node, COMPREHENSIONS):
            return self._comprehended(node, scope)
        if isinstance(node, ast.Subscript):
            return self.elements(Term(node.value, scope))
        if isinstance(node, ast.BinOp):
            return [
                part
                for side in (node.left, node.right)
                for part in self.elements(Term(side, scope))
            ]
        if isinstance(node, ast.Call):
            return self._of_call(node, scope)
        return []

    def _comprehended(self, node: ast.AST, scope: Scope) -> list[Part]:
        """Elements of a comprehension: one for each turn where it has one loop."""
        inner = self.atlas.within(node, scope)
        if len(node.generators) > 1:
            return [Term(node.elt, inner)]
        loop = node.generators[0]
        turns = self.elements(Term(loop.iter, scope))
        if not turns or not isinstance(loop.target, ast.Name):
            return [Term(node.elt, inner)]
        return [
            Term(node.elt, Scope(scope.path, node, scope, {loop.target.id: turn}))
            for turn in turns
        ]

    def _of_call(self, call: ast.Call, scope: Scope) -> list[Part]:
        name = dotted(call.func)
        given = [Term(a, scope) for a in call.args]
        if isinstance(call.func, ast.Attribute):
            owner = Term(call.func.value, scope)
            if call.func.attr == "items":
                return [
                    LoopRow((self._key(e), Term(e.value, e.scope)))
                    for e in self.entries(owner)
                ]
            if call.func.attr == "keys":
                return [self._key(e) for e in self.entries(owner)]
            if call.func.attr == "values":
                return [Term(e.value, e.scope) for e in self.entries(owner)]
            if name == ["dict", "fromkeys"]:
                return self.elements(given[0])
        last = name[-1:]
        if last == ["zip"]:
            columns = [self.elements(g) for g in given]
            return _beside(columns)
        if last == ["product"]:
            return [LoopRow(turn) for turn in _pairs([self.elements(g) for g in given])]
        if last == ["enumerate"]:
            return [LoopRow((_blank(), e)) for e in self.elements(given[0])]
        if last == ["map"] and len(given) == 2:
            return [
                Term(ast.Call(call.args[0], [e.node], []), e.scope)
                for e in self.elements(given[1])
                if isinstance(e, Term)
            ]
        if last == ["range"] and all(isinstance(g.node, ast.Constant) for g in given):
            numbers = range(*(g.node.value for g in given))
            return [Term(ast.Constant(n), scope) for n in numbers]
        if last and last[0] in SAME_ELEMENTS:
            return [e for g in given for e in self.elements(g)]
        return []

    def _key(self, entry: DictEntry) -> Term:
        return Term(entry.key, entry.scope, entry)

    def _put(self, term: Term) -> list[DictEntry]:
        """Entries that statements put into the dict of this name, one by one."""
        inner: Scope | None = term.scope
        while inner and term.node.id not in inner.entries:
            inner = inner.parent
        put = inner.entries[term.node.id] if inner else ()
        return [DictEntry(key, value, inner) for key, value in put]

    def entries(self, part: Part) -> list[DictEntry]:
        """Keys with values of a dict, however it was put together."""
        if isinstance(part, LoopRow):
            return []
        with self._once("entries", part) as first:
            if not first:
                return []
            found = [e for one in self._before(part) for e in self.entries(one)]
            if isinstance(part.node, ast.Name):
                found += self._put(part)
            return found or self._entries(part)

    def _entries(self, term: Term) -> list[DictEntry]:
        node, scope = term.node, term.scope
        if isinstance(node, ast.Dict):
            return [
                entry
                for key, value in zip(node.keys, node.values, strict=True)
                for entry in (
                    [DictEntry(key, value, scope)]
                    if key
                    else self.entries(Term(value, scope))
                )
            ]
        if isinstance(node, ast.DictComp):
            return [DictEntry(node.key, node.value, self.atlas.within(node, scope))]
        if isinstance(node, ast.BinOp):
            sides = (Term(side, scope) for side in (node.left, node.right))
            return [entry for side in sides for entry in self.entries(side)]
        if isinstance(node, ast.Call):
            name = dotted(node.func)
            if name == ["dict", "fromkeys"]:
                value = (*node.args[1:], ast.Constant(None))[0]
                return [
                    DictEntry(e.node, value, e.scope)
                    for e in self.elements(Term(node.args[0], scope))
                    if isinstance(e, Term)
                ]
            if name == ["dict"]:
                named = [
                    DictEntry(ast.Constant(k.arg), k.value, scope)
                    for k in node.keywords
                    if k.arg
                ]
                pairs = [p for a in node.args for p in self.elements(Term(a, scope))]
                return named + [
                    DictEntry(p.terms[0].node, p.terms[1].node, p.terms[0].scope)
                    for p in pairs
                    if isinstance(p, LoopRow)
                    and all(isinstance(t, Term) for t in p.terms)
                ]
        return []


def given_back(called: Scope) -> list[Term]:
    """What a function returns, or yields."""
    if isinstance(called.node, ast.Lambda):
        return [Term(called.node.body, called)]
    kinds = (ast.Return, ast.Yield, ast.YieldFrom)
    return [
        Term(n.value, called) for n in called.own() if isinstance(n, kinds) and n.value
    ]


def _beside(columns: list[list[Part]]) -> list[LoopRow]:
    """Rows of columns; every pair where they are not of one length."""
    if len({len(column) for column in columns}) == 1:
        return [LoopRow(row) for row in zip(*columns, strict=True)]
    return [LoopRow(turn) for turn in _pairs(columns)]


def _pairs(columns: list[list[Part]]) -> Iterator[tuple[Part, ...]]:
    """Every combination; a column that is not known stands as one term."""
    return product(*(column or [_blank()] for column in columns))


def _blank() -> Term:
    """An expression of which nothing is known."""
    return Term(ast.Set([]), Scope(Path(), ast.Module([], [])))
