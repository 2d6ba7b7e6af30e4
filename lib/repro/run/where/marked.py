"""Producers by their ids, from the files that name them: the others are not parsed."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from functools import cached_property
from pathlib import Path

from raxel.io.documents import parse_yaml, read_text
from repro.judge.ledger import FOLDER
from repro.run.discover import MARKS, PAGE_FILE, Producer, marked_in, page_id
from repro.run.names import Sources

STEMS = ("artefacts", "claims", "numbers")
# A mark up to the function that it stands above.
MARK = re.compile(
    rb"^@(" + "|".join(MARKS).encode() + rb")\(\s*(.*?)^def ", re.M | re.S
)
LITERAL = (b'"', b"{", b"(")
# An entry of a file of the ledger, from its first line on.
ENTRY = re.compile(r"^- (?=id:)", re.M)


class Marked:
    """Marked functions of the checkout; ``sources`` keeps what was parsed."""

    def __init__(self, sources: Sources) -> None:
        self.root = sources.root
        self.sources = sources
        self._of_file: dict[Path, list[Producer]] = {}
        self._of_id: dict[str, list[Producer]] = {}
        self._blocks: dict[str, list[str]] = {}

    @cached_property
    def texts(self) -> dict[Path, bytes]:
        """Every file of the pages, as it stands."""
        paths = sorted((self.root / "chapters").glob("*/*/**/*.py"))
        return {path: path.read_bytes() for path in paths}

    @cached_property
    def pages(self) -> dict[str, Path]:
        """Files of the pages by their ids."""
        return {
            page_id(self.root, path): path
            for path in self.texts
            if path.name == PAGE_FILE and len(path.relative_to(self.root).parts) == 4
        }

    @cached_property
    def marks(self) -> dict[Path, list[tuple[str, bytes]]]:
        """Kind and arguments of the marks of every file that has any, as they stand."""
        found = {
            path: [(kind.decode(), given) for kind, given in MARK.findall(text)]
            for path, text in self.texts.items()
        }
        return {path: marks for path, marks in found.items() if marks}

    def ids(self, kinds: Sequence[str] = MARKS) -> set[str]:
        """What may be an id of these kinds: texts of their marks."""
        found = set()
        for path, marks in self.marks.items():
            for kind, given in marks:
                if kind in kinds and given.startswith(LITERAL):
                    found |= {t.decode() for t in re.findall(rb'"([^"]+)"', given)}
                elif kind in kinds:
                    found |= {p.id for p in self.in_files([path])}
        return found

    def in_files(self, paths: Iterable[Path]) -> list[Producer]:
        """Producers of those of the files that have any."""
        found = []
        for path in paths:
            if path not in self._of_file:
                made = marked_in(self.sources, path) if path in self.marks else []
                self._of_file[path] = made
            found += self._of_file[path]
        return found

    def of_id(self, identifier: str) -> list[Producer]:
        """Producers of an id: it is quoted in their file, or a name stands for it."""
        if identifier in self._of_id:
            return self._of_id[identifier]
        quoted = f'"{identifier}"'.encode()
        files = [
            path
            for path, marks in self.marks.items()
            if any(quoted in m or not m.startswith(LITERAL) for _, m in marks)
        ]
        found = [p for p in self.in_files(files) if p.id == identifier]
        return self._of_id.setdefault(identifier, found)

    def of_page(self, page: str) -> list[Producer]:
        """Producers of a page, by its id."""
        folder = self.pages[page].parent
        return self.in_files(p for p in self.texts if p.is_relative_to(folder))

    def of_set(self, name: str) -> list[Producer]:
        """Experiments that open a rendered set, ``RIG/SEED``."""
        files = [
            path
            for path, marks in self.marks.items()
            if any(b"rendered=" in given for _, given in marks)
        ]
        return [p for p in self.in_files(files) if name in rendered_by(p)]

    def entries(self, stem: str, identifier: str) -> list[dict]:
        """Entries of a file of the ledger in which an id stands."""
        path = self.root / FOLDER / f"{stem}.yaml"
        if stem not in self._blocks:
            self._blocks[stem] = ENTRY.split(read_text(path))[1:]
        blocks = [b for b in self._blocks[stem] if identifier in b]
        # As in the list that they are of, to mean the same.
        return parse_yaml("".join(f"- {block}\n" for block in blocks), path) or []

    def printed(self) -> set[str]:
        """Ids of what the thesis has."""
        found = set()
        for stem in STEMS:
            text = read_text(self.root / FOLDER / f"{stem}.yaml")
            found |= set(re.findall(r"^- id: (\S+)$", text, flags=re.M))
        return found


def rendered_by(one: Producer) -> list[str]:
    """The rendered sets, ``RIG/SEED``, that a producer opens at either size."""
    sizes = one.details.get("rendered", {})
    return list(dict.fromkeys(name for size in sizes for name in one.rendered(size)))
