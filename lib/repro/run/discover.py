"""Find pages and producers by parsing the chapters, never by importing them."""

from __future__ import annotations

import ast
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from repro.judge.kept import Kept
from repro.run import bare_syntax, names
from repro.run.bare_syntax import FAMILIES, MARKS
from repro.run.names import Sources, dotted
from repro.run.rendered import rig_file

PAGE_FILE = "page.py"


@dataclass(frozen=True)
class Producer:
    """One marked function of a chapter page."""

    kind: str
    id: str
    module: str
    function: str
    page: str
    line: int
    details: dict

    @property
    def path(self) -> str:
        """File of the function, below chapters/."""
        return "/".join(self.module.split(".")[1:]) + ".py"

    @property
    def needs(self) -> tuple[str, ...]:
        """Experiments whose results the function reads."""
        return tuple(self.details.get("needs", ()))

    @property
    def inputs(self) -> tuple[str, ...]:
        """Files that an experiment declares, and the rigs of its rendered sets."""
        sizes = self.details.get("rendered", {})
        rigs = [rig_file(name) for size in sizes for name in self.rendered(size)]
        return tuple(dict.fromkeys([*self.details.get("inputs", ()), *rigs]))

    def rendered(self, effort: str) -> tuple[str, ...]:
        """Return the rendered sets, ``RIG/SEED``, that an experiment of this size
        opens."""
        return tuple(self.details.get("rendered", {}).get(effort, ()))

    @property
    def published(self) -> tuple[str, ...]:
        """Printed numbers that a figure or table shows next to the results."""
        return tuple(self.details.get("published", ()))


def page_files(root: Path) -> list[Path]:
    """Chapter pages below ``root/chapters``, in reading order."""
    found = (root / "chapters").glob(f"*/*/{PAGE_FILE}")
    return sorted(found, key=lambda path: page_id(root, path))


def page_id(root: Path, path: Path) -> str:
    """Return the page id of a chapter file: the folders of chapter and page."""
    return "/".join(path.relative_to(root / "chapters").parts[:2])


def page_module(page: str) -> str:
    """Name of the module of a page, `chapters.<chapter>.<page>.page`."""
    return f"chapters.{page.replace('/', '.')}.{PAGE_FILE.removesuffix('.py')}"


def producers(root: Path) -> list[Producer]:
    """Return every marked function of every chapter file; ids are unique within a
    kind."""
    paths = sorted((root / "chapters").glob("*/*/**/*.py"))
    return list(_producers(root, tuple((p, p.stat().st_mtime_ns) for p in paths)))


@cache
def _producers(root: Path, dated: tuple[tuple[Path, int], ...]) -> list[Producer]:
    """Producers of files with these modification times."""
    found: dict[tuple[str, str], Producer] = {}
    sources = Sources(root)

    def read(path: Path) -> tuple[list[list], set[Path]]:
        sources.asked = {path}
        made = [list(vars(p).values()) for p in marked_in(sources, path)]
        return made, sources.asked

    kept = Kept(root, "producers", (__file__, names.__file__, bare_syntax.__file__))
    for path, _ in dated:
        for producer in (Producer(*fields) for fields in kept.of(path, read)):
            key = (producer.kind, producer.id)
            if key in found:
                other = found[key]
                raise ValueError(
                    f"{path}:{producer.line}: {producer.kind} {producer.id} is made by "
                    f"{other.module}:{other.line} too; keep one of the two"
                )
            found[key] = producer
    kept.keep()
    return list(found.values())


def marked_in(sources: Sources, path: Path) -> list[Producer]:
    """The marked functions of one file, in the order of their lines."""
    module = ".".join(path.relative_to(sources.root).with_suffix("").parts)
    page = page_id(sources.root, path)
    made = []
    for node in sources.body(path):
        if not isinstance(node, ast.FunctionDef):
            continue
        for call in node.decorator_list:
            kind = getattr(getattr(call, "func", None), "id", "")
            if kind not in MARKS:
                continue
            details = {k.arg: _literal(sources, path, k.value) for k in call.keywords}
            first = _literal(sources, path, call.args[0])
            place = module, node.name, page, node.lineno
            if kind not in FAMILIES:
                made.append(Producer(kind, first, *place, details))
                continue
            for identifier in first:
                own = details | {"family": True}
                if isinstance(first, dict):
                    field = "artefact" if kind == "experiments" else "needs"
                    own[field] = first[identifier]
                made.append(Producer(FAMILIES[kind], identifier, *place, own))
    return made


def _literal(sources: Sources, path: Path, node: ast.expr) -> object:
    """Value of a decorator's argument: a literal, or a module's name of one.

    A tuple becomes a list, as in the stored index.
    """
    value = node
    name = dotted(node)
    place = sources.find(path, name) if name else None
    if place and isinstance(place.node, ast.Assign | ast.AnnAssign):
        value = place.node.value
    try:
        return _listed(ast.literal_eval(value))
    except ValueError:
        raise ValueError(
            f"{path}:{node.lineno}: {ast.unparse(node)} is not a literal; write the "
            "value, or the name of a literal at the top of a module"
        ) from None


def _listed(value: object) -> object:
    if isinstance(value, tuple | list):
        return [_listed(one) for one in value]
    if isinstance(value, dict):
        return {key: _listed(one) for key, one in value.items()}
    return value
