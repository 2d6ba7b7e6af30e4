"""Keys over the code that a function reaches.

A result is rebuilt when something it was computed with changed, and only then. The key
of a function covers its own syntax tree and, followed by name through the chapters and
`lib/`, every function, class and constant it can reach; comments, docstrings and
annotations do not count. A package from outside counts with its pinned version.
"""

from __future__ import annotations

import hashlib
import re
from collections import deque
from collections.abc import Iterable, Iterator
from pathlib import Path

from repro.run.source_index import Definition, Module, index

PROJECT = ("chapters", "raxel", "repro")
DISTRIBUTION = {"cv2": "opencv-python-headless", "yaml": "pyyaml"}


class Reach:
    """Keys of functions in the checkout at ``root`` (modules: chapters, lib/)."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self._modules: dict[str, Module | None] = {}
        self._known: dict[tuple[str, str], tuple[dict, list]] = {}
        self._keys: dict[tuple[tuple[str, str], ...], str] = {}
        self.versions = _pins(root / "environment.txt")

    def key(self, *functions: tuple[str, str]) -> str:
        """Hash over everything the (module, name) pairs reach."""
        if functions not in self._keys:
            digest = hashlib.sha256()
            for name, part in sorted(self.parts(*functions).items()):
                digest.update(f"{name}={part}\n".encode())
            self._keys[functions] = digest.hexdigest()[:16]
        return self._keys[functions]

    def parts(self, *functions: tuple[str, str]) -> dict[str, str]:
        """Reached definition -> hash of its bare syntax, or pinned version."""
        found: dict[str, str] = {}
        for place in self._walked(functions):
            found |= self._direct(place)[0]
        return found

    def reached(self, *functions: tuple[str, str]) -> list[tuple[str, str]]:
        """Definitions of the checkout, (module, name), that these reach: nearest first.

        The functions themselves are the first of them.
        """
        return [place for place in self._walked(functions) if self._defined(*place)]

    def place(self, module: str, name: str) -> tuple[Path, int]:
        """File and line of a definition; LookupError for what is none."""
        found = self._defined(module, name)
        if found is None:
            raise LookupError(f"{module} defines no {name}")
        return self._path(module), found.line

    def _defined(self, module_name: str, name: str) -> Definition | None:
        module = self._module(module_name)
        return module.definitions.get(name) if module else None

    def _walked(
        self, functions: Iterable[tuple[str, str]]
    ) -> Iterator[tuple[str, str]]:
        """Each place that the functions reach, once: the nearest first."""
        seen = dict.fromkeys(functions)
        todo = deque(seen)
        while todo:
            place = todo.popleft()
            yield place
            further = [p for p in self._direct(place)[1] if p not in seen]
            seen |= dict.fromkeys(further)
            todo += dict.fromkeys(further)

    def _direct(
        self, place: tuple[str, str]
    ) -> tuple[dict[str, str], list[tuple[str, str]]]:
        """Parts of one definition itself, and the definitions it names."""
        if place not in self._known:
            self._known[place] = self._looked_up(*place)
        return self._known[place]

    def _looked_up(
        self, module_name: str, name: str
    ) -> tuple[dict[str, str], list[tuple[str, str]]]:
        module = self._module(module_name)
        if module is None:
            package = module_name.split(".")[0]
            pin = DISTRIBUTION.get(package, package)
            return ({pin: self.versions[pin]} if pin in self.versions else {}), []
        if name == "*":
            return {}, [(module_name, n) for n in module.definitions]
        if name in module.definitions:
            found = module.definitions[name]
            return {f"{module_name}:{name}": found.hash}, self._named(module, found)
        if name in module.imports:
            return {}, self._resolve(*module.imports[name], [])
        if self._module(f"{module_name}.{name}") is not None:
            return {}, [(f"{module_name}.{name}", "*")]
        return {}, []

    def _named(self, module: Module, found: Definition) -> list[tuple[str, str]]:
        """Definitions that a definition names, wherever they are."""
        aliases = module.imports | found.imports
        named: list[tuple[str, str]] = []
        for root, attributes in found.chains:
            if root in aliases:
                named += self._resolve(*aliases[root], attributes)
            elif root in module.definitions:
                named.append((module.name, root))
        return named

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

    def _module(self, name: str) -> Module | None:
        if name not in self._modules:
            path = self._path(name)
            self._modules[name] = (
                index(name, path, self.root / ".cache" / "reach") if path else None
            )
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


def _pins(path: Path) -> dict[str, str]:
    text = path.read_text("utf-8") if path.is_file() else ""
    return dict(re.findall(r"^([a-z0-9_.-]+)==([^\s;\\]+)", text, flags=re.M))
