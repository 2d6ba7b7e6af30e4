"""`make where ID`: the lines behind a figure, table, claim, number, experiment or page.

    python -m repro.run.where table_3_4 s3_2_results:omni.left_out

One line for each location, as `file:line`, from the page to the functions of the
library. Producers are found by their decorators. A name that prose quotes is looked up
in the built page, which records the line and the results of each name.
"""

from __future__ import annotations

import difflib
import json
import re
import sys
from collections import deque
from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path
from typing import NamedTuple

from raxel.errors import InputError
from repro.judge.ledger import load
from repro.run.discover import PAGE_FILE, Producer, page_files, page_id, producers
from repro.run.reach import Reach
from repro.run.rendered import manifest, rig_file

READERS = ("figure", "table", "numbers", "claim")
MAX_ALGORITHMS = 12
# Packages of the library, the most relevant first.
PACKAGES = (
    ("calibration", "features", "multiview"),
    ("cameras", "evaluation"),
    ("lab", "sets", "io"),
    ("geometry", "show", "report"),
)
# Distance in definitions between an experiment and the reader of its result.
STEPS_OF_RESULT = 3
# Endings of names of a ledger number (`repro.page.reader.values`).
OF_NUMBER = re.compile(r"\.(low|high|text)$")


class UnknownId(Exception):
    """An unknown id, or a name that no built page records."""


class PlaceLine(NamedTuple):
    """One entry with its location, `path:line`, and its name."""

    word: str
    place: str
    name: str


class Whereabouts:
    """Locations of everything that the chapters of the checkout at ``root`` make."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.made = producers(root)
        self.book = load(root)
        self.reach = Reach(root)
        self.named = cache(self.reach.named)
        self.pages = {page_id(root, path): path for path in page_files(root)}

    def lines(self, identifier: str) -> list[PlaceLine]:
        """Return every location behind an id, in the order of reading; raises
        UnknownId."""
        claims = self._claims_about(identifier)
        mine = self._producers(identifier) or claims
        if not mine:
            return self._of_quoted(identifier)
        given = [*mine, *(claim for claim in claims if claim not in mine)]
        every = [p for kind in READERS for p in given if p.kind == kind]
        pages = dict.fromkeys(p.page for p in mine)
        experiments = self._experiments(mine)
        starts = [(p.module, p.function) for p in every]
        return [
            *(PlaceLine("page", f"chapters/{p}/{PAGE_FILE}:1", p) for p in pages),
            *self._computed(experiments, starts),
            *(_line(p) for p in every),
            *self._data([*every, *experiments]),
        ]

    # Producers of an id

    def _producers(self, identifier: str) -> list[Producer]:
        """Producers of an id, of a page, of a rendered set or of a ledger number."""
        pages = self._pages(identifier)
        number = self.book.numbers.get(OF_NUMBER.sub("", identifier), {})
        candidates = (
            [p for p in self.made if p.page in pages],
            [p for p in self.made if p.id == identifier],
            [p for p in self.made if identifier in _rendered(p)],
            self._of_artefact(number.get("artefact")),
        )
        return next((found for found in candidates if found), [])

    def _of_artefact(self, artefact: str | None) -> list[Producer]:
        """The producer of an artefact's numbers, or else of the artefact."""
        found = [p for p in self.made if p.id == artefact]
        return [p for p in found if p.kind == "numbers"] or found

    def _pages(self, identifier: str) -> list[str]:
        """Pages of this id, or of this last part of an id."""
        return [p for p in self.pages if identifier in (p, p.rpartition("/")[2])]

    def _claims_about(self, identifier: str) -> list[Producer]:
        claims = self.book.claims
        about = {c for c, e in claims.items() if identifier in e["artefacts"]}
        return [p for p in self.made if p.kind == "claim" and p.id in about]

    def _experiments(self, mine: Iterable[Producer]) -> list[Producer]:
        """The experiments among ``mine`` and all that they read, recursively."""
        by_id = {p.id: p for p in self.made if p.kind == "experiment"}
        found: dict[str, Producer] = {}
        todo = list(mine)
        while todo:
            one = todo.pop(0)
            if one.kind == "experiment":
                found.setdefault(one.id, one)
            todo += [by_id[n] for n in one.needs if n in by_id and n not in found]
        return list(found.values())

    # From experiments to the library

    def _computed(
        self, experiments: Iterable[Producer], readers: Iterable[tuple[str, str]]
    ) -> list[PlaceLine]:
        """Experiments, functions of the library, and rendered sets."""
        found, starts, sets = [], [], {}
        for between, one in enumerate(experiments):
            steps = min(between, 1) * STEPS_OF_RESULT
            starts.append(((one.module, one.function), steps))
            found.append(_line(one))
            sets |= dict.fromkeys(_rendered(one))
        algorithms = dict.fromkeys(
            [*self._algorithms(starts), *self._algorithms([(r, 0) for r in readers])]
        )
        lines = list(algorithms)[:MAX_ALGORITHMS]
        left = len(algorithms) - len(lines)
        if left:
            lines[-1] = lines[-1]._replace(name=f"{lines[-1].name}, and {left} more")
        rigs = [PlaceLine("set", f"{rig_file(name)}:1", name) for name in sets]
        return [*dict.fromkeys(found), *lines, *rigs]

    def _algorithms(
        self, starts: Sequence[tuple[tuple[str, str], int]]
    ) -> list[PlaceLine]:
        """Functions and classes of the library that code of the chapters names.

        In the order of `PACKAGES`, functions before classes, callers of the library
        before others, nearest first.
        """
        found: dict[tuple[str, str], tuple] = {}
        todo = deque(sorted(starts, key=lambda start: start[1]))
        seen = set()
        while todo:
            place, steps = todo.popleft()
            if place in seen:
                continue
            seen.add(place)
            for target in self.named(place):
                if target[0].startswith("chapters."):
                    todo.append((target, steps + 1))
                elif target[0].startswith("raxel.") and target not in found:
                    found[target] = self._rank(target, steps)
        ranked = sorted((t for t in found if found[t]), key=found.get)
        return [
            PlaceLine("algorithm", self._at(*self.reach.place(*t)), t[1])
            for t in ranked
        ]

    def _rank(self, target: tuple[str, str], steps: int) -> tuple:
        """Sort key of a function or class; empty for a constant and for an error."""
        path, line = self.reach.place(*target)
        written = _lines(path)[line - 1].lstrip()
        if not written.startswith(("def ", "class ")) or target[1].endswith("Error"):
            return ()
        folder = target[0].split(".")[1]
        inside = [number for number, rooms in enumerate(PACKAGES) if folder in rooms]
        room = (*inside, len(PACKAGES))[0] + 1.5 * written.startswith("class ")
        uses = any(m.startswith("raxel.") for m, _ in self.named(target))
        return room, target[1].startswith("_"), not uses, steps

    # Names that prose quotes

    def _of_quoted(self, identifier: str) -> list[PlaceLine]:
        page, parted, name = identifier.rpartition(":")
        found, unbuilt = [], []
        for one in self._pages(page) if parted else self.pages:
            line = _line_with(self.pages[one], f"`{name}")
            if line:
                place = f"chapters/{one}/{PAGE_FILE}:{line}"
                quoted = PlaceLine("quoted", place, f"{one.rpartition('/')[2]}:{name}")
                record = self.recorded(one).get(name)
                found += [quoted, *self._behind(record)] if record else []
                unbuilt += [] if record else [one]
        if unbuilt and not found:
            raise UnknownId(
                f"{name}: quoted on {', '.join(unbuilt)}, which is not built; run make "
                "quick (or make report)"
            )
        if not found:
            raise UnknownId(self._unknown(identifier))
        return found

    def recorded(self, page: str) -> dict[str, dict]:
        """Name -> where it was made, from the built page (full preferred to quick)."""
        for effort in ("full", "quick"):
            built = self.root / f"report/build/{effort}/pages/{page}.ipynb"
            if built.is_file():
                content = json.loads(built.read_text("utf-8"))
                return content["metadata"]["raxel"].get("names", {})
        return {}

    def _behind(self, record: dict) -> list[PlaceLine]:
        """The origin of a name: its line, experiments, algorithms and data."""
        module = self._module(self.root / record["path"])
        place = f"{record['path']}:{record['line']}"
        value = PlaceLine("value", place, record["function"])
        results = set(record["results"])
        mine = [p for p in self.made if p.kind == "experiment" and p.id in results]
        experiments = self._experiments(mine)
        starts = [(module, record["function"].partition(".")[0])]
        return [value, *self._computed(experiments, starts), *self._data(experiments)]

    # Places

    def _data(self, made: Iterable[Producer]) -> list[PlaceLine]:
        """Files of these in the full build."""
        base = self.root / "figures" / "full"
        names: list[Path] = []
        for one in made:
            folder = base / "results" if one.kind == "experiment" else base
            if one.kind in ("figure", "table", "experiment"):
                names += sorted(folder.glob(f"{one.id}.*"))
            names += [self.root / manifest(name) for name in _rendered(one)]
        return [
            PlaceLine("data", self._at(path, 1), "")
            for path in dict.fromkeys(names)
            if path.is_file() and not path.name.endswith(".run.json")
        ]

    def _at(self, path: Path, line: int) -> str:
        return f"{path.relative_to(self.root).as_posix()}:{line}"

    def _module(self, path: Path) -> str:
        return ".".join(path.relative_to(self.root).with_suffix("").parts)

    def _unknown(self, identifier: str) -> str:
        book = self.book
        printed = {*book.artefacts, *book.claims, *book.numbers}
        if identifier in printed:
            return f"{identifier}: in the thesis, but no page makes it yet"
        known = printed | {p.id for p in self.made} | set(self.pages)
        near = difflib.get_close_matches(identifier, sorted(known), n=3)
        hint = f"did you mean {', '.join(near)}?" if near else "see the scoreboard"
        return f"{identifier}: no such id; {hint}"


def _rendered(one: Producer) -> list[str]:
    """The rendered sets, ``RIG/SEED``, that a producer opens at either size."""
    sizes = one.details.get("rendered", {})
    return list(dict.fromkeys(name for size in sizes for name in one.rendered(size)))


def _line(one: Producer) -> PlaceLine:
    name = one.id if one.id == one.function else f"{one.id} {one.function}"
    return PlaceLine(one.kind, f"chapters/{one.path}:{one.line}", name)


@cache
def _lines(path: Path) -> list[str]:
    return path.read_text("utf-8").splitlines()


def _line_with(path: Path, quoted: str) -> int:
    """Number of the first line that quotes a whole name; 0 without one."""
    whole = re.compile(re.escape(quoted) + "[:`]")
    return next((n for n, li in enumerate(_lines(path), 1) if whole.search(li)), 0)


def shown(lines: Sequence[PlaceLine]) -> str:
    """Lines below each other, words and places aligned."""
    word = max(len(line.word) for line in lines)
    place = max(len(line.place) for line in lines)
    return "\n".join(
        f"{li.word:{word}}  {li.place:{place}}  {li.name}".rstrip() for li in lines
    )


def main(argv: Sequence[str] | None = None) -> int:
    """Print where the given ids are made; exit status 1 for an unknown one."""
    given = list(sys.argv[1:] if argv is None else argv)
    if not given:
        print("make where ID: give an id, such as table_3_4", file=sys.stderr)
        return 1
    try:
        atlas = Whereabouts(Path.cwd())
        print("\n\n".join(shown(atlas.lines(one)) for one in given))
    except (UnknownId, InputError) as error:
        print(f"make where: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
