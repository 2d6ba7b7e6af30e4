"""Keys of the code that a function depends on.

A result is rebuilt if, and only if, the code that computes it changed. The key of a
function covers its own syntax tree and, followed by name through the chapters and
`lib/`, every function, class and constant that it can reach. Comments, docstrings and
annotations are ignored. An external package enters with its pinned version.

In the hash of a definition each name of another definition is replaced by the hash of
that definition. So names and positions are ignored too: after moving a module or
renaming a constant or function, nothing is run again. Names remain in the hash if they
are visible at run time: names of classes (camera files contain them), of all
definitions of a module that is passed as an object, of the module of code that reads
``__file__``, and all reached names if code reads the name of a function. A name that is
also bound in an inner scope remains, too. Names in strings are not followed, nor side
effects of importing a module.

A reach may be limited to some folders of the project: outside them only the name
enters, not the code or the version.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections import deque
from collections.abc import Collection, Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from repro.run.bare_syntax import PROJECT
from repro.run.circles import circles
from repro.run.source_index import Module, index

DISTRIBUTION = {"cv2": "opencv-python-headless", "PIL": "pillow", "yaml": "pyyaml"}
WHOLE = "*"
"""Name for all definitions of a module."""
MAX_IMPORTS = 20
"""Largest number of re-exports of a name; more indicate a cycle."""

Place = tuple[str, str]
"""Module and name of a definition."""


class Node(NamedTuple):
    """Syntax of one definition, and the target of each of its names, in order.

    A link is the text about a target, and the target: None outside the project.
    """

    hash: str
    links: list[tuple[str, Place | None]]
    asks_names: bool = False


class Reach:
    """Keys of functions in the checkout at ``root`` (modules: chapters, lib/).

    within: the parts of the project whose code enters, all by default.
    """

    def __init__(self, root: Path, within: Collection[str] = PROJECT) -> None:
        self.root = root
        self.within = within
        self._modules: dict[str, Module | None] = {}
        self._nodes: dict[Place, Node] = {}
        self._hashes: dict[Place, str] = {}
        self._asks_names: dict[Place, bool] = {}
        self._keys: dict[tuple[Place, ...], str] = {}
        everything = set(PROJECT) <= set(within)
        self.versions = _pins(root / "environment.txt") if everything else {}

    def key(self, *functions: Place) -> str:
        """Return the hash over everything that the (module, name) pairs reach."""
        if functions not in self._keys:
            places = self._places(functions)
            found = [self._hash(place) for place in places]
            if any(self._asks_names[place] for place in places):
                found += [f"{module}:{name}" for module, name in self.reached(*places)]
            self._keys[functions] = _digest(found)
        return self._keys[functions]

    def reached(self, *functions: Place) -> list[Place]:
        """Return the definitions, (module, name), that these reach: nearest first.

        The functions themselves are the first of them.
        """
        return [place for place in self._walked(functions) if place[1] != WHOLE]

    def named(self, function: Place) -> list[Place]:
        """Return the definitions that a definition names directly, in the order of its
        text."""
        return [
            target
            for place in self._places([function])
            for _, target in self._node(place).links
            if target and target[1] != WHOLE
        ]

    def place(self, module: str, name: str) -> tuple[Path, int]:
        """Return file and line of a definition; LookupError if there is no such
        definition."""
        found = self._module(module)
        if found is None or name not in found.definitions:
            raise LookupError(f"{module}: no definition of {name}")
        return self._path(module), found.definitions[name].line

    def _walked(self, functions: Iterable[Place]) -> Iterator[Place]:
        """Each place that the functions reach, once: the nearest first."""
        seen = dict.fromkeys(self._places(functions))
        todo = deque(seen)
        while todo:
            place = todo.popleft()
            yield place
            further = [target for _, target in self._node(place).links]
            new = dict.fromkeys(t for t in further if t and t not in seen)
            seen |= new
            todo += new

    def _places(self, functions: Iterable[Place]) -> list[Place]:
        """Where the functions are defined; a module may import them from another."""
        found = (
            self._resolved(module, [] if name == WHOLE else [name])[0]
            for module, name in functions
        )
        return [place for place in found if place]

    def _hash(self, place: Place) -> str:
        """Hash over a definition and, by their hashes, all that it reaches."""
        if place not in self._hashes:
            for circle in circles(place, self._targets):
                self._settle(circle)
        return self._hashes[place]

    def _targets(self, place: Place) -> list[Place]:
        """The definitions that a definition names and that have no hash yet."""
        links = self._node(place).links
        return [t for _, t in links if t and t not in self._hashes]

    def _settle(self, circle: Collection[Place]) -> None:
        """Hash the definitions of a cycle, each with itself as the start."""
        hashes = {place: self._of_circle(place, circle) for place in circle}
        self._hashes |= hashes
        asks = any(
            self._node(place).asks_names
            or any(self._asks_names.get(t) for _, t in self._node(place).links)
            for place in circle
        )
        self._asks_names |= dict.fromkeys(circle, asks)

    def _of_circle(self, first: Place, circle: Collection[Place]) -> str:
        """Hash of one definition of a cycle: the others are numbered in the order of
        the visit."""
        met = {first: 0}
        parts: list[str] = []
        for place in (order := [first]):
            node = self._node(place)
            parts += [node.hash, str(len(node.links))]
            for words, target in node.links:
                if target in circle and target not in met:
                    met[target] = len(met)
                    order.append(target)
                parts.append(words)
                parts.append(str(met[target]) if target in met else self._known(target))
        return _digest(parts)

    def _known(self, target: Place | None) -> str:
        return self._hashes[target] if target else ""

    def _node(self, place: Place) -> Node:
        if place not in self._nodes:
            self._nodes[place] = self._read(*place)
        return self._nodes[place]

    def _read(self, module_name: str, name: str) -> Node:
        """Syntax and links of one definition; a whole module links to all that it
        defines."""
        module = self._module(module_name)
        if name == WHOLE:
            return Node("", [(n, (module_name, n)) for n in module.definitions])
        found = module.definitions[name]
        links = []
        for word, home, path in found.references:
            place, rest = self._resolved(home, path)
            if place is None and self._is_left_out(rest[0]):
                rest = rest[1:]  # the module of a name of the project is ignored
            words = ".".join([f"{word}=", *rest])
            if place is None and self._pin(rest[0]):
                words += f" {self._pin(rest[0])}"
            links.append((words, place))
        return Node(found.hash, links, found.asks_names)

    def _resolved(
        self, module: str, path: Sequence[str]
    ) -> tuple[Place | None, list[str]]:
        """The definition or module that ``path`` leads to, and the rest of the path.

        For a name outside the checkout, the rest is the whole path.
        """
        for _ in range(MAX_IMPORTS):
            found = self._module(module)
            if found is None:
                break
            if not path:
                return (module, WHOLE), []
            first, *rest = path
            if first in found.definitions:
                return (module, first), rest
            if first in found.imports:
                module, attribute = found.imports[first]
                path = [attribute, *rest] if attribute else rest
            elif self._module(f"{module}.{first}") is not None:
                module, path = f"{module}.{first}", rest
            else:
                break
        return None, [module, *path]

    def _is_left_out(self, module: str) -> bool:
        """Whether a module is part of the project, but not of the folders that
        enter."""
        top = module.split(".")[0]
        return top in PROJECT and top not in self.within

    def _pin(self, module: str) -> str | None:
        """Version of an external module, if one is pinned."""
        package = module.split(".")[0]
        return self.versions.get(
            DISTRIBUTION.get(package, package.lower().replace("_", "-"))
        )

    def _module(self, name: str) -> Module | None:
        if name not in self._modules:
            path = self._path(name)
            if path is None:
                self._modules[name] = None
            elif path.is_dir():  # a package without a file of its own
                self._modules[name] = Module(name, {}, {})
            else:
                folder = self.root / ".cache" / "reach"
                self._modules[name] = index(name, path, folder)
        return self._modules[name]

    def _path(self, name: str) -> Path | None:
        """File of a module of the checkout, or the folder of a package without a
        file."""
        top = name.split(".")[0]
        if top not in self.within:
            return None
        base = self.root if top == "chapters" else self.root / "lib"
        stem = base.joinpath(*name.split("."))
        for path in (stem.with_suffix(".py"), stem / "__init__.py"):
            if path.is_file():
                return path
        return stem if stem.is_dir() else None


def _pins(path: Path) -> dict[str, str]:
    text = path.read_text("utf-8") if path.is_file() else ""
    return dict(re.findall(r"^([a-z0-9_.-]+)==([^\s;\\]+)", text, flags=re.M))


def _digest(parts: list[str]) -> str:
    return hashlib.sha256(json.dumps(parts).encode()).hexdigest()[:16]
