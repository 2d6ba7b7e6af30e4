"""The block below an artefact: links to its files, and information about it.

A cell of the page writes a placeholder (`repro.page.reader.show`), which is replaced by
the block after the page has run: the thesis's section and the original's axes come from
`data/published`, which no chapter reads. So do the printed numbers below the cells of a
table.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from markupsafe import Markup, escape
from nbformat import NotebookNode

from repro.judge import ledger
from repro.page.cells import NOTHING
from repro.page.reader import mark
from repro.page.templates import part, render
from repro.page.wording import label, literal
from repro.run.discover import Producer, producers

MARK = re.compile(re.escape(mark("NAME")).replace("NAME", '([^"]+)'))
PRINTED = re.compile(part("printed_mark", "NAME").replace("NAME", '([^"]+)'))
WORDS = {"px": "px", "deg": "degrees", "mm": "mm", "fov": "field of view"}


@dataclass(frozen=True)
class Behind:
    """Sources of an artefact; addresses are relative to its page."""

    command: str
    provenance: Sequence[tuple[str, str]]
    source: str
    path: str
    function: str
    comparison: str


class Furnisher:
    """Fill the placeholders of one page; ``up`` is the path from the page to the site's
    top."""

    def __init__(self, root: Path, effort: str, page: str) -> None:
        self.root = root
        self.effort = effort
        self.base = root / "figures" / effort
        self.up = "../" * page.count("/")

    @cached_property
    def citation(self) -> dict:
        """Content of CITATION.cff."""
        return ledger.read_yaml(self.root / "CITATION.cff")

    @cached_property
    def book(self) -> ledger.Ledger:
        """Return the ledger."""
        return ledger.load(self.root)

    @cached_property
    def made(self) -> list[Producer]:
        """Return the producers of all chapters."""
        return producers(self.root)

    @cached_property
    def sections(self) -> Mapping[str, dict]:
        """Sections of the thesis by number: title and first page."""
        contents = self.root / ledger.FOLDER / "contents.yaml"
        return ledger.read_yaml(contents)["sections"]

    def fill(self, notebook: NotebookNode) -> None:
        """Insert blocks and printed numbers into the outputs of the cells."""
        for cell in notebook.cells:
            for output in cell.get("outputs", ()):
                data = output.get("data", {})
                text = data.get("text/markdown", "")
                if MARK.search(text):
                    text = MARK.sub(lambda m: self.block(m[1]), text)
                    data["text/markdown"] = PRINTED.sub(self._printed, text)
                if PRINTED.search(data.get("text/html", "")):
                    found = PRINTED.sub(self._printed_alone, data["text/html"])
                    data["text/html"] = found

    def _printed(self, found: re.Match) -> str:
        """A number of the thesis, in a cell of a table in Markdown."""
        text = Markup(literal(self._text(found[1])))
        return part("printed", text, f"{self.up}scoreboard.html#{found[1]}")

    def _printed_alone(self, found: re.Match) -> str:
        """The same in HTML without a link."""
        return part("printed", self._text(found[1]), "")

    def _text(self, identifier: str) -> str:
        value = self.book.printed([identifier])[identifier]
        return NOTHING if value is None else str(value)

    def block(self, name: str) -> str:
        """The folded block of one artefact, HTML without an empty line."""
        about = json.loads((self.base / f"{name}.json").read_text("utf-8"))
        entry = self.book.artefacts.get(name)
        thesis = self.citation["preferred-citation"]
        first = thesis["authors"][0]
        number = str(entry["section"]) if entry else ""
        return render(
            "about",
            behind=self.behind(name, about),
            entry=entry,
            label=label(name),
            number=number,
            known=self.sections.get(number),
            original=_original(entry) if entry else (),
            what=label(name) or name,
            citation=self.citation,
            thesis=thesis,
            person=f"{first['family-names']}, {first['given-names']}",
        )

    def behind(self, name: str, about: Mapping) -> Behind:
        """Command, provenance, code and comparison of an artefact.

        ``about`` is the content of its description file.
        """
        path, function = about["source"]
        compared = f"{self.up}scoreboard.html#{name}"
        return Behind(
            command=self._command(name),
            provenance=[(f"{self.up}provenance/{r}.html", r) for r in about["results"]],
            source=f"{self.up}source/{path}.html#{function}",
            path=path,
            function=function,
            comparison=compared if name in self.book.artefacts else "",
        )

    def _command(self, name: str) -> str:
        """The command that makes one artefact."""
        words = ["make", name]
        if self.effort != "full":
            words.append(f"EFFORT={self.effort}")
        return " ".join(words)


def _original(entry: Mapping) -> list[tuple[str, Markup]]:
    """The axes and conditions of the thesis's artefact in words."""
    return [
        ("Its panels", in_words(entry.get("panels"))),
        ("Its axes", in_words(entry.get("plot"))),
        ("Its conditions", in_words(entry.get("conditions"))),
    ]


def in_words(value: object) -> Markup:
    """A value of the ledger as a phrase in HTML; empty for nothing."""
    if value is None:
        return Markup()
    if isinstance(value, Mapping):
        pair = Markup("{}: {}")
        parts = [pair.format(_named(str(k)), in_words(v)) for k, v in value.items()]
        return Markup("; ").join(parts)
    if isinstance(value, list):
        return Markup(", ").join(in_words(part) for part in value)
    if isinstance(value, bool):
        return Markup("yes" if value else "no")
    return escape(str(value))


def _named(key: str) -> Markup:
    if re.fullmatch(r"[a-f](,[a-f])*|\d", key):
        return Markup("<b>({})</b>").format(key)
    words = [WORDS.get(word, word) for word in key.split("_")]
    if len(words) > 1 and words[-1] in ("px", "degrees", "mm"):
        words[-1] = f"({words[-1]})"
    return escape(" ".join(words))
