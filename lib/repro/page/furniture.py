"""What stands below an artefact: its files in one line, and what to know about it.

A page's cell leaves a mark (`repro.page.reader.show`), and the book-keeping puts the
block in its place when the page has run: the thesis's section and the original's axes
come from `data/published`, which no chapter reads.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from functools import cached_property
from html import escape
from pathlib import Path

from nbformat import NotebookNode

from repro.judge import ledger
from repro.page.reader import mark
from repro.page.wording import label
from repro.run.discover import result_ids

MARK = re.compile(re.escape(mark("NAME")).replace("NAME", '([^"]+)'))
WORDS = {"px": "px", "deg": "degrees", "mm": "mm", "fov": "field of view"}


class Furnisher:
    """Fills the marks of one page; ``up`` leads from the page to the site's top."""

    def __init__(self, root: Path, effort: str, page: str) -> None:
        self.root = root
        self.base = root / "figures" / effort
        self.up = "../" * page.count("/")

    @cached_property
    def citation(self) -> dict:
        """Content of CITATION.cff."""
        return ledger.read_yaml(self.root / "CITATION.cff")

    @cached_property
    def artefacts(self) -> Mapping[str, dict]:
        """Artefacts of the thesis by id."""
        return ledger.load(self.root).artefacts

    @cached_property
    def sections(self) -> Mapping[str, dict]:
        """Sections of the thesis by number: title and first page."""
        contents = self.root / ledger.FOLDER / "contents.yaml"
        return ledger.read_yaml(contents)["sections"]

    def fill(self, notebook: NotebookNode) -> None:
        """Put the blocks into the Markdown that the cells have shown."""
        for cell in notebook.cells:
            for output in cell.get("outputs", ()):
                data = output.get("data", {})
                text = data.get("text/markdown", "")
                if MARK.search(text):
                    data["text/markdown"] = MARK.sub(lambda m: self.block(m[1]), text)

    def block(self, name: str) -> str:
        """The folded block of one artefact, HTML without an empty line."""
        about = json.loads((self.base / f"{name}.json").read_text("utf-8"))
        identifier = name.partition("@")[0]
        entry = self.artefacts.get(identifier)
        rows = self._original(identifier, entry) if entry else []
        rows += [
            ("Made by", self._source(about)),
            ("Computed", self._runs(name, about)),
        ]
        rows.append(("Cite", self._cite(identifier, entry)))
        listed = "".join(f"<dt>{key}</dt><dd>{said}</dd>" for key, said in rows if said)
        return (
            '<details class="raxel-about tex2jax_ignore mathjax_ignore">'
            f"<summary>About {escape(label(identifier) or 'this')}: "
            f"{'the original, ' if entry else ''}source, log, how to cite</summary>"
            f"<dl>{listed}</dl></details>"
        )

    def _original(self, identifier: str, entry: Mapping) -> list[tuple[str, str]]:
        """Where it stands in the thesis, and its axes and conditions in words."""
        place = f"{escape(label(identifier))}, {self._section(entry)}: "
        return [
            ("In the thesis", f"{place}<em>{escape(entry['title'])}</em>"),
            ("Its panels", in_words(entry.get("panels"))),
            ("Its axes", in_words(entry.get("plot"))),
            ("Its conditions", in_words(entry.get("conditions"))),
        ]

    def _section(self, entry: Mapping) -> str:
        number = str(entry["section"])
        kind = "section" if number[0].isdigit() else "appendix"
        known = self.sections.get(number)
        if not known:
            return f"{kind} {number}"
        title = escape(known["title"])
        return f"{kind} {number} ({title}, from p. {known['page']})"

    def _source(self, about: Mapping) -> str:
        path, function = about["source"]
        address = f"{self.up}source/{path}.html#{function}"
        return (
            f'<a href="{escape(address)}"><code>{escape(function)}</code> in '
            f"{escape(path)}</a>"
        )

    def _runs(self, name: str, about: Mapping) -> str:
        """The run records of the experiments that were read."""
        links = []
        for result in result_ids(about["results"]):
            if (self.base / f"results/{result}.run.json").is_file():
                said = result.removesuffix(f"@{name.partition('@')[2]}")
                links.append(
                    f'<a href="{self.up}logs/{escape(result)}.json">log of '
                    f"{escape(said.replace('@', ' of '))}</a> (time taken, versions)"
                )
        return ", ".join(links)

    def _cite(self, identifier: str, entry: Mapping | None) -> str:
        software, thesis = self.citation, self.citation["preferred-citation"]
        who = software["authors"][0]["name"]
        first = thesis["authors"][0]
        person = f"{first['family-names']}, {first['given-names']}"
        school, year = thesis["institution"]["name"], thesis["year"]
        what = label(identifier) or identifier
        line = f"{software['title']}, version {software['version']}, {what}"
        if entry:
            line += f"; after {person} ({year}), {self._section(entry)}"
        lines = [
            "@software{raxel,",
            f"  author = {{{{{who}}}}},",
            f"  title = {{{software['title']}}},",
            f"  version = {{{software['version']}}},",
            f"  note = {{{what}}}",
            "}",
            "@phdthesis{dunne2009,",
            f"  author = {{{person}}},",
            f"  title = {{{thesis['title']}}},",
            f"  school = {{{school}}},",
            f"  year = {{{year}}}",
            "}",
        ]
        return f"{line}.<pre>{escape(chr(10).join(lines), quote=False)}</pre>"


def in_words(value: object) -> str:
    """A value of the ledger as a phrase, HTML-escaped; empty for nothing."""
    if value is None:
        return ""
    if isinstance(value, Mapping):
        parts = [f"{_named(key)}: {in_words(v)}" for key, v in value.items()]
        return "; ".join(parts)
    if isinstance(value, list):
        return ", ".join(in_words(part) for part in value)
    if isinstance(value, bool):
        return "yes" if value else "no"
    return escape(str(value))


def _named(key: str) -> str:
    if re.fullmatch(r"[a-f](,[a-f])*|\d", str(key)):
        return f"<b>({escape(str(key))})</b>"
    words = [WORDS.get(word, word) for word in str(key).split("_")]
    if len(words) > 1 and words[-1] in ("px", "degrees", "mm"):
        words[-1] = f"({words[-1]})"
    return escape(" ".join(words))
