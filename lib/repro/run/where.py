"""`make where ID`: the lines behind a figure, table, claim, number, experiment or page.

    python -m repro.run.where table_3_4

One line for each location, as `file:line`, from the page to the functions of the
library. Producers are found by their decorators. The site leads from the numbers in its
text to their code.
"""

from __future__ import annotations

import difflib
import re
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

from raxel.errors import InputError
from repro.judge.ledger import load
from repro.run.discover import PAGE_FILE, Producer, page_files, page_id, producers
from repro.run.reach import Reach
from repro.run.rendered import rig_file

READERS = ("figure", "table", "numbers", "claim")
MAX_ALGORITHMS = 12
ALGORITHMS = ("calibration", "features", "multiview")  # the first packages
# Endings of names of a ledger number (`repro.page.reader.values`).
OF_NUMBER = re.compile(r"\.(low|high|text)$")


class UnknownId(Exception):
    """An id that no page makes."""


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
        self.pages = {page_id(root, path): path for path in page_files(root)}

    def lines(self, identifier: str) -> list[PlaceLine]:
        """Return every location behind an id, in the order of reading; raises
        UnknownId."""
        claims = self._claims_about(identifier)
        mine = self._producers(identifier) or claims
        if not mine:
            raise UnknownId(self._unknown(identifier))
        given = [*mine, *(claim for claim in claims if claim not in mine)]
        every = [p for kind in READERS for p in given if p.kind == kind]
        pages = dict.fromkeys(p.page for p in mine)
        experiments = self._experiments(mine)
        return [
            *(PlaceLine("page", f"chapters/{p}/{PAGE_FILE}:1", p) for p in pages),
            *dict.fromkeys(map(_line, experiments)),
            *self._algorithms([*experiments, *every]),
            *self._sets(experiments),
            *map(_line, every),
        ]

    # Producers of an id

    def _producers(self, identifier: str) -> list[Producer]:
        """Producers of an id, of a page, of a rendered set or of a ledger number."""
        pages = self._pages(identifier)
        number = self.book.numbers.get(OF_NUMBER.sub("", identifier), {})
        of_number = [p for p in self.made if p.id == number.get("artefact")]
        candidates = (
            [p for p in self.made if p.page in pages],
            [p for p in self.made if p.id == identifier],
            [p for p in self.made if identifier in _rendered(p)],
            [p for p in of_number if p.kind == "numbers"],
            of_number,
        )
        return next((found for found in candidates if found), [])

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

    def _algorithms(self, makers: Iterable[Producer]) -> list[PlaceLine]:
        """Functions and classes of the library that chapters name, nearest first."""
        starts = [(p.module, p.function) for p in makers]
        called = dict.fromkeys(
            target
            for place in self.reach.reached(*starts)
            if place[0].startswith("chapters.")
            for target in self.reach.named(place)
            if target[0].startswith("raxel.") and not target[1].isupper()
        )
        ranked = sorted(called, key=lambda t: t[0].split(".")[1] not in ALGORITHMS)
        lines = [
            PlaceLine("algorithm", self._at(*self.reach.place(*t)), t[1])
            for t in ranked[:MAX_ALGORITHMS]
        ]
        if len(ranked) > MAX_ALGORITHMS:
            more = f"{lines[-1].name}, and {len(ranked) - MAX_ALGORITHMS} more"
            lines[-1] = lines[-1]._replace(name=more)
        return lines

    def _sets(self, experiments: Iterable[Producer]) -> list[PlaceLine]:
        names = dict.fromkeys(name for one in experiments for name in _rendered(one))
        return [PlaceLine("set", f"{rig_file(name)}:1", name) for name in names]

    def _at(self, path: Path, line: int) -> str:
        return f"{path.relative_to(self.root).as_posix()}:{line}"

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
        return 0
    except (UnknownId, InputError) as error:
        fault = str(error)
    except SyntaxError as error:
        fault = f"{error.filename}:{error.lineno}: not Python; correct it"
    print(f"make where: {fault}", file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main())
