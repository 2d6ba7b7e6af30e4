"""The chapters of the site and their pages, from the executed notebooks."""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from repro.judge.scoreboard import natural
from repro.page.notebook import PageError
from repro.page.wording import literal, plain
from repro.site import numbered

GUIDES = "guides"


@dataclass(frozen=True)
class Document:
    """A page of a chapter: its name in the site, its title, its artefacts.

    ``entry`` is its name in the navigation, ``held`` the ids of its numbered artefacts.
    """

    name: str
    title: str
    summary: str
    entry: str
    held: tuple[str, ...] = ()


@dataclass(frozen=True)
class Chapter:
    """A package of `chapters/` that has pages: title and text from its docstring."""

    folder: str
    title: str
    intro: str
    pages: tuple[Document, ...]

    @property
    def number(self) -> str:
        """Return the thesis's number or letter of the chapter; empty for other
        pages."""
        found = re.match(r"ch0*(\d+)_|appendix_([a-z])", self.folder)
        return (found[1] or found[2].upper()) if found else ""

    @property
    def guides(self) -> bool:
        """Return whether each of its pages has an entry on the start page."""
        return self.folder == GUIDES


def chapters_of(
    root: Path, pages: Iterable[Path], held: Mapping[str, Sequence[str]]
) -> list[Chapter]:
    """Return chapters of the given notebooks, in the order of the thesis, others last.

    ``held`` : page -> ids of the artefacts of the thesis that it has.
    """
    found: dict[str, list[Document]] = {}
    for path in pages:
        name, title = f"{path.parent.name}/{path.stem}", title_of(path)
        own = tuple(held.get(name, ()))
        entry = numbered.entry(title, own)
        document = Document(name, title, summary_of(path), entry, own)
        found.setdefault(path.parent.name, []).append(document)
    return [
        _chapter(root, folder, found[folder]) for folder in sorted(found, key=_order)
    ]


def _place(page: Document) -> tuple:
    """Sort key in a chapter: by the section that the title begins with.

    Pages of one section are sorted by the numbers of their artefacts; pages without
    artefacts follow by name. Pages without a section follow all of them.
    """
    section = re.match(r"[0-9A-Z](\.[0-9]+)+", page.title)
    number = natural(section[0]) if section else []
    first = natural(page.held[0]) if page.held else []
    return not section, number, not first, first, natural(page.name)


def _order(folder: str) -> tuple:
    kinds = ("ch", "appendix_")
    rank = next((i for i, kind in enumerate(kinds) if folder.startswith(kind)), 2)
    return rank, natural(folder)


def _chapter(root: Path, folder: str, pages: list[Document]) -> Chapter:
    path = root / "chapters" / folder / "__init__.py"
    code = path.read_text("utf-8") if path.is_file() else ""
    text = ast.get_docstring(ast.parse(code))
    if not text:
        raise PageError(
            f"{path}: no docstring; give the chapter's title in its first line"
        )
    title, _, intro = text.partition("\n")
    documents = sorted(pages, key=_place)
    return Chapter(folder, title.strip().rstrip("."), intro.strip(), tuple(documents))


def title_of(path: Path) -> str:
    """First heading of a notebook or Markdown page, unchanged."""
    found = re.search(r"^# +(.+)$", _markdown(path), flags=re.M)
    if not found:
        raise PageError(f"{path}: no heading; begin the page with a line '# Title'")
    return found[1].strip()


def summary_of(path: Path) -> str:
    """First paragraph below the first heading, without markup; empty without one."""
    _, _, rest = re.split(r"^(# +.+)$", _markdown(path), maxsplit=1, flags=re.M)
    first = next((part for part in rest.split("\n\n") if part.strip()), "").strip()
    return "" if re.match(r"[#|:`$<-]", first) else literal(plain(first))


def _markdown(path: Path) -> str:
    if path.suffix != ".ipynb":
        return path.read_text("utf-8")
    cells = _notebook(path)["cells"]
    return "\n\n".join(
        "".join(c["source"]) for c in cells if c["cell_type"] == "markdown"
    )


def _notebook(path: Path) -> dict:
    return _read_notebook(path, path.stat().st_mtime_ns)


@cache
def _read_notebook(path: Path, changed: int) -> dict:
    """A notebook with this modification time: an unchanged one is read once."""
    return json.loads(path.read_text("utf-8"))


def documents(chapters: Iterable[Chapter]) -> list[Document]:
    """All pages of chapters."""
    return [page for chapter in chapters for page in chapter.pages]


def source_of(notebook: Path) -> str:
    """The page's file that the notebook was made from, below chapters/."""
    return _notebook(notebook)["metadata"]["raxel"]["source"]
