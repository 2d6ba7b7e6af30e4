"""From a trial to the algorithm: functions of the library that chapter code calls.

The walk goes from a function through all that it names in the chapters and stops at the
library: what stands there is the border, and the library's own calls are its matter.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator, Mapping, Sequence
from heapq import heapify, heappop, heappush
from itertools import count
from pathlib import Path
from typing import NamedTuple

from repro.run.names import Place, Sources, dotted

# Rooms of the library by what a reader looks for first: how things are found and
# calibrated, what is modelled and measured with, what makes pictures, the arithmetic.
ROOMS = (
    ("calibration", "features", "multiview"),
    ("cameras", "evaluation"),
    ("lab", "sets", "cli"),
    ("geometry", "show", "report"),
)
# In so many of them, what calls nothing of the library helps what does.
CALLING = 2
CLASS = 1.5
LIBRARY = "raxel"
TYPES = ("returns", "annotation", "decorator_list")


class Called(NamedTuple):
    """A function or class of the library, with what the order is made of.

    ``room`` is the place of its room in `ROOMS`, classes behind the functions of the
    next room; ``steps`` is how many definitions lead to it.
    """

    room: float
    is_private: bool
    is_leaf: bool
    steps: int
    name: str
    path: Path
    line: int


class Border:
    """What code of the chapters calls of the library."""

    def __init__(self, sources: Sources) -> None:
        self.sources = sources
        self._known: dict[ast.stmt, list[tuple[str, Place]]] = {}
        self._within: dict[tuple[Path, Path], bool] = {}
        self._library = sources.root / "lib" / LIBRARY
        self._chapters = sources.root / "chapters"

    def calls(self, starts: Iterable[tuple[Place, int]]) -> list[Called]:
        """Functions and classes of the library that the code from there on names.

        ``starts`` are definitions of the chapters, and how many steps lead to each.

        The order: rooms in that of `ROOMS`, the classes of each behind the functions of
        the next one; the public before the private ones; in the first two rooms those
        that call others of the library before those that call none; those that fewer
        steps lead to first; and then as they stand in the text. Constants and classes
        of errors are left out.
        """
        found: dict[tuple[Path, str], Called] = {}
        seen: set[ast.stmt] = set()
        todo = [(steps, number, place) for number, (place, steps) in enumerate(starts)]
        heapify(todo)
        numbers = count(len(todo))
        while todo:
            steps, _, place = heappop(todo)
            if place.node in seen:
                continue
            seen.add(place.node)
            for name, named in self._named(place):
                if self._is_within(named.path, self._chapters):
                    heappush(todo, (steps + 1, next(numbers), named))
                elif self._is_of_library(named) and (named.path, name) not in found:
                    one = self._called(name, named, steps)
                    found[named.path, name] = one
        return sorted(found.values(), key=lambda one: one[:4])

    def _called(self, name: str, place: Place, steps: int) -> Called:
        folder = place.path.relative_to(self._library).parts[0]
        inside = [number for number, rooms in enumerate(ROOMS) if folder in rooms]
        room: float = (*inside, len(ROOMS))[0]
        is_leaf = room < CALLING and not any(
            self._is_of_library(p)
            for _, p in self._named(place)
            if p.node is not place.node
        )
        room += CLASS * isinstance(place.node, ast.ClassDef)
        is_private = name.startswith("_")
        line = place.node.lineno
        return Called(room, is_private, is_leaf, steps, name, place.path, line)

    def _is_of_library(self, place: Place) -> bool:
        return self._is_within(place.path, self._library) and _is_code(place.node)

    def _is_within(self, path: Path, folder: Path) -> bool:
        if (path, folder) not in self._within:
            self._within[path, folder] = path.is_relative_to(folder)
        return self._within[path, folder]

    def _named(self, place: Place) -> list[tuple[str, Place]]:
        """Definitions that a definition names, in the order of its text."""
        if place.node not in self._known:
            self._known[place.node] = list(dict.fromkeys(self._looked_up(place)))
        return self._known[place.node]

    def _looked_up(self, place: Place) -> Iterator[tuple[str, Place]]:
        used = _Names(place.node)
        for name in used.chains:
            if name[0] in used.bound:
                continue
            for length in range(len(name), 0, -1):
                found = self._find(place.path, name[:length], used.imports)
                if found:
                    yield name[length - 1], found
                    break

    def _find(
        self, path: Path, name: Sequence[str], imports: Mapping[str, tuple[str, str]]
    ) -> Place | None:
        if name[0] in imports:
            return self.sources.imported(*imports[name[0]], name[1:])
        return self.sources.find(path, name)


class _Names:
    """Names that a definition uses, each once with its attributes, and those it binds.

    Types and marks are left out.
    """

    def __init__(self, node: ast.AST) -> None:
        self.chains: dict[tuple[str, ...], None] = {}
        self.bound: set[str] = set()
        self.imports: dict[str, tuple[str, str]] = {}
        self._read(node)

    def _read(self, node: ast.AST) -> None:
        if isinstance(node, ast.Name | ast.Attribute):
            name = tuple(dotted(node))
            if name and isinstance(node.ctx, ast.Load):
                self.chains[name] = None
            elif len(name) == 1:
                self.bound.add(name[0])
            if name:
                return
        elif isinstance(node, ast.arg):
            self.bound.add(node.arg)
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            for alias in node.names:
                self.imports[alias.asname or alias.name] = (node.module, alias.name)
        for field in node._fields:
            if field in TYPES:
                continue
            value = getattr(node, field, None)
            for child in value if isinstance(value, list) else (value,):
                if isinstance(child, ast.AST):
                    self._read(child)


def _is_code(node: ast.stmt) -> bool:
    if isinstance(node, ast.ClassDef):
        return not any(
            "".join(dotted(base)[-1:]).endswith(("Error", "Exception"))
            for base in node.bases
        )
    return isinstance(node, ast.FunctionDef)
