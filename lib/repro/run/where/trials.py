"""The trial of an experiment: the function that its Plan runs for every condition."""

from __future__ import annotations

import ast
from dataclasses import dataclass

from repro.run.discover import Producer
from repro.run.names import Place, Sources, defined_by, dotted

WRAPPERS = ("partial", "functools.partial")


@dataclass(frozen=True)
class Trial:
    """A trial's definition and name, and the function that makes the Plan."""

    place: Place
    name: str
    planned: Place


def trial_of(sources: Sources, experiment: Producer) -> Trial | None:
    """The function that the experiment's Plan runs, for every condition."""
    path = sources.root / "chapters" / experiment.path
    place = sources.find(path, [experiment.function])
    while place and isinstance(place.node, ast.FunctionDef):
        plan = _call(place.node, "Plan")
        if plan:
            return _named(sources, place, _first(plan, "trial"))
        built = _returned(place.node)
        place = sources.find(place.path, dotted(built.func)) if built else None
    return None


def _named(sources: Sources, inside: Place, node: ast.expr) -> Trial:
    """The function that an expression inside another one names."""
    while isinstance(node, ast.Call):  # of partial(trial, ...) or trial_of(...)
        wraps = ".".join(dotted(node.func)) in WRAPPERS
        node = node.args[0] if wraps else node.func
    name = dotted(node)
    local = [n for n in ast.walk(inside.node) if name[-1:] == defined_by(n)]
    if local and len(name) == 1 and local[0] is not inside.node:
        if isinstance(local[0], ast.Assign):
            return _named(sources, inside, local[0].value)
        found: Place | None = Place(inside.path, local[0])
    else:
        found = sources.find(inside.path, name) if name else None
    place = found or Place(inside.path, node)
    return Trial(place, name[-1] if found else "lambda", inside)


def _call(function: ast.FunctionDef, name: str) -> ast.Call | None:
    calls = (node for node in ast.walk(function) if isinstance(node, ast.Call))
    return next((c for c in calls if dotted(c.func)[-1:] == [name]), None)


def _returned(function: ast.FunctionDef) -> ast.Call | None:
    """The call whose value a function returns: that of a function which builds it."""
    values = (n.value for n in ast.walk(function) if isinstance(n, ast.Return))
    return next((v for v in values if isinstance(v, ast.Call) and dotted(v.func)), None)


def _first(call: ast.Call, keyword: str) -> ast.expr:
    named = {k.arg: k.value for k in call.keywords}
    return call.args[0] if call.args else named[keyword]
