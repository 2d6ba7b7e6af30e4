"""From an id to lines: each thing behind it, as `file:line` with its name."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

from repro.run.discover import PAGE_FILE, Producer
from repro.run.names import Place, Sources
from repro.run.rendered import manifest, rig_file
from repro.run.where.algorithms import Border
from repro.run.where.marked import Marked, rendered_by
from repro.run.where.quoted import Maker, Quoted, quotes
from repro.run.where.reads import Read, Reads
from repro.run.where.texts import ANY, Text, fits, fixed_length
from repro.run.where.trials import Trial, trial_of

READERS = ("figure", "table", "numbers", "claim")
# More lines of the library than these say nothing of what matters.
MAX_ALGORITHMS = 12
# How much farther what a result is read from stands than what reads it.
STEPS_OF_RESULT = 3
# An f-string with less than this that is known may be the id of anything.
MIN_KNOWN = 5


class UnknownId(Exception):
    """An id that nothing has; the message says which are near."""


class PlaceLine(NamedTuple):
    """One thing and its place, `path:line`, with its own name."""

    word: str
    place: str
    name: str


class Whereabouts:
    """What the chapters of the checkout at ``root`` make, and where."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.sources = Sources(root)
        self.marked = Marked(self.sources)
        self.border = Border(self.sources)
        self._quoted: dict[str, Quoted] = {}

    @cached_property
    def experiment_ids(self) -> set[str]:
        """What may be the id of an experiment."""
        return self.marked.ids(("experiment", "experiments"))

    def lines(self, identifier: str) -> list[PlaceLine]:
        """Every place behind an id, in the order of reading; raises UnknownId."""
        claims = self._claims_about(identifier)
        mine = self._of_page(identifier) or self._of_id(identifier) or claims
        quoting = self.quoting(identifier)
        if not mine and not quoting:
            raise UnknownId(self._unknown(identifier))
        every = [*mine, *(claim for claim in claims if claim not in mine)]
        found = self._of_producers(mine, every) if mine else []
        for page, name in quoting:
            found += self._of_quoted(page, name, alone=not mine)
        return found

    def _of_producers(
        self, mine: Sequence[Producer], every: Sequence[Producer]
    ) -> list[PlaceLine]:
        experiments = self._experiments(mine)
        pages = dict.fromkeys(p.page for p in mine)
        readers = [p for kind in READERS for p in every if p.kind == kind]
        return [
            *(PlaceLine("page", f"chapters/{p}/{PAGE_FILE}:1", p) for p in pages),
            *self._computed(experiments, [self._function(p) for p in readers]),
            *(_line(p) for p in readers),
            *self._data([*readers, *(one for one, _ in experiments)]),
        ]

    def _computed(
        self, experiments: Sequence[tuple[Producer, int]], readers: Iterable[Place]
    ) -> list[PlaceLine]:
        """Trials and experiments, the library's functions, and the rendered sets."""
        found, starts = [], []
        for one, between in experiments:
            trial = self.trial_of(one)
            if trial:
                # The function that makes the Plan comes after its trial.
                starts.append((trial.place, between * STEPS_OF_RESULT))
                starts.append((trial.planned, between * STEPS_OF_RESULT + 1))
                found.append(self._at("trial", trial.place, trial.name))
            found.append(_line(one))
        names = dict.fromkeys(n for one, _ in experiments for n in rendered_by(one))
        return [
            *dict.fromkeys(found),
            *self._algorithms(starts, readers),
            *(PlaceLine("set", f"{rig_file(name)}:1", name) for name in names),
        ]

    def _algorithms(
        self, starts: Sequence[tuple[Place, int]], readers: Iterable[Place]
    ) -> list[PlaceLine]:
        """Functions of the library, in the order of `Border.calls`.

        Those that trials call come first, and then those that figures, tables, claims
        and numbers call themselves. Of many the last are counted and not listed.
        """
        called = dict.fromkeys(
            (one.path, one.line, one.name)
            for some in (starts, [(place, 0) for place in readers])
            for one in self.border.calls(some)
        )
        lines = [
            PlaceLine("algorithm", f"{self._shown(path)}:{line}", name)
            for path, line, name in called
        ]
        left = len(lines) - MAX_ALGORITHMS
        if left > 0:
            word, place, name = lines[MAX_ALGORITHMS - 1]
            lines[MAX_ALGORITHMS - 1 :] = [
                PlaceLine(word, place, f"{name}, and {left} more")
            ]
        return lines

    def trial_of(self, experiment: Producer) -> Trial | None:
        """The trial of an experiment."""
        return trial_of(self.sources, experiment)

    def _function(self, one: Producer) -> Place:
        path = self.root / "chapters" / one.path
        return self.sources.find(path, [one.function])

    def _of_page(self, identifier: str) -> list[Producer]:
        pages = self._pages(identifier)
        return [p for page in pages for p in self.marked.of_page(page)]

    def _pages(self, identifier: str) -> list[str]:
        """Pages of this id, or of this last part of an id."""
        return [
            page
            for page in self.marked.pages
            if identifier in (page, page.rpartition("/")[2])
        ]

    def _claims_about(self, identifier: str) -> list[Producer]:
        """The tests of the claims that name an artefact or section of the thesis."""
        entries = self.marked.entries("claims", identifier)
        about = [e["id"] for e in entries if identifier in e["artefacts"]]
        made = [p for one in about for p in self.marked.of_id(one)]
        order = {path: place for place, path in enumerate(self.marked.texts)}
        made.sort(key=lambda p: (order[self.root / "chapters" / p.path], p.line))
        return [p for p in made if p.kind == "claim"]

    def _of_id(self, identifier: str) -> list[Producer]:
        """Producers of that id; those that read the set, or give the number, of it."""
        mine = self.marked.of_id(identifier) or (
            self.marked.of_set(identifier) if "/" in identifier else []
        )
        if mine:
            return mine
        entries = self.marked.entries("numbers", identifier)
        given = [e["artefact"] for e in entries if e["id"] == identifier]
        of_it = [p for one in given for p in self.marked.of_id(one)]
        # A setting has no producer of its own: it stands where its artefact is made.
        return [p for p in of_it if p.kind == "numbers"] or of_it

    def _experiments(self, mine: Iterable[Producer]) -> list[tuple[Producer, int]]:
        """The experiments among ``mine`` and all that they read, and theirs.

        Each with how many results lie between.
        """
        found: dict[str, tuple[Producer, int]] = {}
        todo = [(one, 0) for one in mine]
        while todo:
            one, between = todo.pop(0)
            if one.kind == "experiment":
                found.setdefault(one.id, (one, between))
                between += 1
            needed = self.experiments(n for n in one.needs if n not in found)
            todo += [(further, between) for further in needed]
        return list(found.values())

    def experiments(self, ids: Iterable[str]) -> list[Producer]:
        """The experiments of these ids."""
        made = [p for one in ids for p in self.marked.of_id(one)]
        return [p for p in made if p.kind == "experiment"]

    def quoting(self, identifier: str) -> list[tuple[str, str]]:
        """Pages that quote a name, each with it; ``page:name`` asks for one page."""
        page, parted, name = identifier.partition(":")
        name = name if parted else identifier
        asked = self._pages(page) if parted else self.marked.pages
        written = f"`{name}".encode()
        return [
            (one, name)
            for one in asked
            if written in self.marked.texts[self.marked.pages[one]]
            and name in self.quotes(one)
        ]

    def quotes(self, page: str) -> dict[str, int]:
        """Names that a page quotes, with the lines."""
        return quotes(self.marked.texts[self.marked.pages[page]].decode())

    def makers(self, page: str, name: str) -> list[Maker]:
        """The statements that may make a name that a page quotes."""
        return self._named_by(page).made_by(name)

    def _named_by(self, page: str) -> Quoted:
        if page not in self._quoted:
            made = self.marked.of_page(page)
            numbers = [p for p in made if p.kind == "numbers"]
            self._quoted[page] = Quoted(self.sources, page, numbers)
        return self._quoted[page]

    def read_by(self, page: str, maker: Maker) -> Read:
        """What stands behind a value that a page quotes."""
        reads = Reads(self._named_by(page).reader, self._of_text, self._behind)
        read = reads.of(maker.made)
        if maker.numbers and not read.named:
            read.among = dict.fromkeys(maker.numbers.needs)
        return read

    def _of_text(self, text: Text) -> list[str]:
        """Experiments that a text is, or can be, the id of."""
        if ANY not in text:
            name = "".join(text)
            return [name] if name in self.experiment_ids else []
        if fixed_length(text) < MIN_KNOWN:
            return []
        return [one for one in sorted(self.experiment_ids) if fits(text, one)]

    def _behind(self, artefact: str) -> list[str]:
        return [n for p in self.marked.of_id(artefact) for n in p.needs]

    def _of_quoted(self, page: str, name: str, alone: bool) -> list[PlaceLine]:
        """The lines of a quoted name; not ``alone``, its own only."""
        home = f"chapters/{page}/{PAGE_FILE}"
        said = f"{page.rpartition('/')[2]}:{name}"
        found = [PlaceLine("quoted", f"{home}:{self.quotes(page)[name]}", said)]
        for maker in self.makers(page, name):
            place = f"{self._shown(maker.path)}:{maker.line}"
            found.append(PlaceLine("value", place, maker.function or page))
            if alone:
                found += self._behind_value(self.read_by(page, maker))
        return found

    def _behind_value(self, read: Read) -> list[PlaceLine]:
        experiments = self._experiments(self.experiments(read.experiments))
        lines = self._computed(experiments, read.functions)
        if not any(line.word == "algorithm" for line in lines):
            lines += [self._at("constant", p, name) for name, p in read.constants]
            lines += [self._at("function", p, p.node.name) for p in read.functions]
        return lines + self._data(one for one, _ in experiments)

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
            files += [self.root / manifest(name) for name in rendered_by(one)]
        names = dict.fromkeys(self._shown(path) for path in files)
        return [
            PlaceLine("data", f"{name}:1", "")
            for name in names
            if not name.endswith(".run.json") and (self.root / name).is_file()
        ]

    def _at(self, word: str, place: Place, name: str) -> PlaceLine:
        return PlaceLine(word, f"{self._shown(place.path)}:{place.node.lineno}", name)

    def _shown(self, path: Path) -> str:
        return path.relative_to(self.root).as_posix()

    def _unknown(self, identifier: str) -> str:
        printed = self.marked.printed()
        if identifier in printed:
            return f"{identifier}: the thesis has it, and no page makes it yet"
        known = printed | self.marked.ids() | set(self.marked.pages)
        known |= {name for page in self.marked.pages for name in self.quotes(page)}
        near = difflib.get_close_matches(identifier, sorted(known), n=3)
        hint = (
            f"did you mean {', '.join(near)}?" if near else "the scoreboard lists all"
        )
        return f"{identifier}: no such id; {hint}"


def _line(one: Producer) -> PlaceLine:
    name = one.id if one.id == one.function else f"{one.id} {one.function}"
    return PlaceLine(one.kind, f"chapters/{one.path}:{one.line}", name)


def shown(lines: Sequence[PlaceLine]) -> str:
    """Lines below each other, words and places aligned; a gap before what is quoted."""
    word = max(len(line.word) for line in lines)
    place = max(len(line.place) for line in lines)
    rows = []
    for line in lines:
        gap = "\n" if line.word == "quoted" and rows else ""
        row = f"{line.word:{word}}  {line.place:{place}}  {line.name}"
        rows.append(gap + row.rstrip())
    return "\n".join(rows)
