"""`make where ID`: where an artefact, claim, number, experiment or page is made.

    python -m repro.run.where table_3_4

One line for each of page, trial, experiment, figure or table, numbers, claim and built
data, as `file:line`. Everything is parsed; no chapter is imported.
"""

from __future__ import annotations

import ast
import difflib
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

from repro.judge.ledger import FOLDER, read_yaml
from repro.run.discover import PAGE_FILE, Producer, page_files, page_id, producers
from repro.run.names import Place, Sources, defined_by, dotted
from repro.run.rendered import manifest, rig_file

READERS = ("figure", "table", "numbers", "claim")
WRAPPERS = ("partial", "functools.partial")
STEMS = ("artefacts", "claims", "numbers")


class UnknownId(Exception):
    """An id that nothing has; the message says which are near."""


class PlaceLine(NamedTuple):
    """One thing and its place, `path:line`, with its own name."""

    word: str
    place: str
    name: str


@dataclass(frozen=True)
class Whereabouts:
    """What the chapters of the checkout at ``root`` make, and where."""

    root: Path

    @cached_property
    def made(self) -> list[Producer]:
        """Every producer of the chapters."""
        return producers(self.root)

    @cached_property
    def sources(self) -> Sources:
        """The chapters' syntax."""
        return Sources(self.root)

    @cached_property
    def ledger(self) -> dict[str, list[dict]]:
        """Entries of the files of the ledger by their stem, as they stand."""
        folder = self.root / FOLDER
        return {stem: read_yaml(folder / f"{stem}.yaml")[stem] for stem in STEMS}

    def lines(self, identifier: str) -> list[PlaceLine]:
        """Every place behind an id, in the order of reading; raises UnknownId."""
        claims = self._claims_about(identifier)
        mine = self._of_page(identifier) or self._of_id(identifier) or claims
        if not mine:
            raise UnknownId(self._unknown(identifier))
        experiments = self._experiments(mine)
        pages = dict.fromkeys(p.page for p in mine)
        found = [
            PlaceLine("page", f"chapters/{page}/{PAGE_FILE}:1", page) for page in pages
        ]
        for one in experiments:
            trial = self.trial_of(one)
            if trial:
                found.append(trial)
            found.append(_line(one))
        names = dict.fromkeys(n for one in experiments for n in _rendered_by(one))
        found += [PlaceLine("set", f"{rig_file(name)}:1", name) for name in names]
        every = [*mine, *(claim for claim in claims if claim not in mine)]
        readers = [p for kind in READERS for p in every if p.kind == kind]
        found += [_line(p) for p in readers]
        return found + self._data([*readers, *experiments])

    def _of_page(self, identifier: str) -> list[Producer]:
        return [
            p for p in self.made if identifier in (p.page, p.page.rpartition("/")[2])
        ]

    def _claims_about(self, identifier: str) -> list[Producer]:
        """The tests of the claims that name an artefact or section of the thesis."""
        about = [e["id"] for e in self.ledger["claims"] if identifier in e["artefacts"]]
        return [p for p in self.made if p.kind == "claim" and p.id in about]

    def _of_id(self, identifier: str) -> list[Producer]:
        """Producers of that id; those that read the set, or give the number, of it."""
        mine = [p for p in self.made if identifier in (p.id, *_rendered_by(p))]
        if mine:
            return mine
        given = [e["artefact"] for e in self.ledger["numbers"] if e["id"] == identifier]
        of_it = [p for p in self.made if p.id in given]
        # A setting has no producer of its own: it stands where its artefact is made.
        return [p for p in of_it if p.kind == "numbers"] or of_it

    def _experiments(self, mine: Iterable[Producer]) -> list[Producer]:
        """The experiments among ``mine`` and all that they read, and theirs."""
        known = {p.id: p for p in self.made if p.kind == "experiment"}
        found: dict[str, Producer] = {}
        todo = list(mine)
        while todo:
            one = todo.pop(0)
            if one.kind == "experiment":
                found.setdefault(one.id, one)
            todo += [known[n] for n in one.needs if n in known and n not in found]
        return list(found.values())

    def trial_of(self, experiment: Producer) -> PlaceLine | None:
        """The function that the experiment's Plan runs, for every condition."""
        path = self.root / "chapters" / experiment.path
        place = self.sources.find(path, [experiment.function])
        while place and isinstance(place.node, ast.FunctionDef):
            plan = _call(place.node, "Plan")
            if plan:
                return self._line_of(place, _first(plan, "trial"))
            built = _returned(place.node)
            place = self.sources.find(place.path, dotted(built.func)) if built else None
        return None

    def _line_of(self, inside: Place, node: ast.expr) -> PlaceLine:
        """The line of the function that an expression inside another one names."""
        while isinstance(node, ast.Call):  # of partial(trial, ...) or trial_of(...)
            wraps = ".".join(dotted(node.func)) in WRAPPERS
            node = node.args[0] if wraps else node.func
        name = dotted(node)
        local = [n for n in ast.walk(inside.node) if name[-1:] == defined_by(n)]
        if local and len(name) == 1 and local[0] is not inside.node:
            if isinstance(local[0], ast.Assign):
                return self._line_of(inside, local[0].value)
            found: Place | None = Place(inside.path, local[0])
        else:
            found = self.sources.find(inside.path, name) if name else None
        place = found or Place(inside.path, node)
        shown = place.path.relative_to(self.root).as_posix()
        said = name[-1] if found else "lambda"
        return PlaceLine("trial", f"{shown}:{place.node.lineno}", said)

    def _data(self, made: Iterable[Producer]) -> list[PlaceLine]:
        """Files of the full build that these have left, one set after the other."""
        base = self.root / "figures" / "full"
        files: list[Path] = []
        for one in made:
            folder = base / "results" if one.kind == "experiment" else base
            if one.kind in ("figure", "table", "experiment"):
                files += sorted(
                    [*folder.glob(f"{one.id}.*"), *folder.glob(f"{one.id}@*")]
                )
            files += [self.root / manifest(name) for name in _rendered_by(one)]
        names = dict.fromkeys(path.relative_to(self.root).as_posix() for path in files)
        return [
            PlaceLine("data", f"{name}:1", "")
            for name in names
            if not name.endswith(".run.json") and (self.root / name).is_file()
        ]

    def _unknown(self, identifier: str) -> str:
        printed = {entry["id"] for stem in STEMS for entry in self.ledger[stem]}
        if identifier in printed:
            return f"{identifier}: the thesis has it, and no page makes it yet"
        known = printed | {p.id for p in self.made}
        known |= {page_id(self.root, path) for path in page_files(self.root)}
        near = difflib.get_close_matches(identifier, sorted(known), n=3)
        hint = (
            f"did you mean {', '.join(near)}?" if near else "the scoreboard lists all"
        )
        return f"{identifier}: no such id; {hint}"


def _line(one: Producer) -> PlaceLine:
    name = one.id if one.id == one.function else f"{one.id} {one.function}"
    return PlaceLine(one.kind, f"chapters/{one.path}:{one.line}", name)


def _rendered_by(one: Producer) -> list[str]:
    """The rendered sets, ``RIG/SEED``, that a producer opens at either size."""
    sizes = one.details.get("rendered", {})
    return list(dict.fromkeys(name for size in sizes for name in one.rendered(size)))


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


def shown(lines: Sequence[PlaceLine]) -> str:
    """Lines below each other, words and places aligned."""
    word = max(len(line.word) for line in lines)
    place = max(len(line.place) for line in lines)
    rows = (f"{n.word:{word}}  {n.place:{place}}  {n.name}".rstrip() for n in lines)
    return "\n".join(rows)


def main(argv: list[str] | None = None) -> int:
    """Print where the given ids are made; exit status 1 for one that nothing has."""
    given = sys.argv[1:] if argv is None else argv
    if not given:
        print("make where ID: give an id, such as table_3_4", file=sys.stderr)
        return 1
    atlas = Whereabouts(Path.cwd())
    try:
        found = [shown(atlas.lines(identifier)) for identifier in given]
    except UnknownId as error:
        print(f"make where: {error}", file=sys.stderr)
        return 1
    print("\n\n".join(found))
    return 0


if __name__ == "__main__":
    sys.exit(main())
