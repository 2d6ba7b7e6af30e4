"""The executed pages as notebooks to work in, anywhere in a checkout."""

from __future__ import annotations

import hashlib
import inspect
import json
import re
from pathlib import Path

import nbformat
from nbformat.v4 import new_code_cell

from raxel.io.files import write_json, write_whole
from repro.site import first_cell

WRITTEN = ".written.json"
CITED = re.compile(r"\{cite\}`([^`]+)`")
FOLDED = {"hide-cell", "hide-input", "remove-cell", "remove-input"}


def notebooks(pages: list[Path], folder: Path) -> None:
    """Write the executed pages to ``folder``, one sub-folder per chapter.

    Files of an earlier build are removed. An edited notebook is kept as
    `NAME-yours.ipynb` next to the new one. So the files are not in the record of the
    job (`repro.run.results`), which would take an edited one for damaged.
    """
    _clear(folder)
    hashes = {}
    for page in pages:
        name = f"{page.parent.name}/{page.name}"
        text = workable(page)
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        if (folder / name).is_file():
            (folder / name).rename(_free(folder / name))
        write_whole(folder / name, text)
        hashes[name] = _hash(text.encode())
    write_json(folder / WRITTEN, hashes)


def workable(page: Path) -> str:
    """An executed page as a notebook that runs in its folder: with a first cell.

    Code that is folded or hidden on the page is folded.
    """
    notebook = nbformat.read(page, as_version=4)
    about = notebook.metadata["raxel"]
    call = f"begin({about['effort']!r}, {about['page']!r})"
    cell = new_code_cell(
        f"{inspect.getsource(first_cell).rstrip()}\n\n\n{call}",
        id="first-cell",
        metadata={"tags": ["hide-input"]},
    )
    notebook.cells.insert(0, cell)
    for cell in notebook.cells:
        if cell.cell_type == "markdown":
            cell.source = CITED.sub(r"[\1]", cell.source)
        if FOLDED & set(cell.metadata.get("tags", ())):
            cell.metadata["jupyter"] = {"source_hidden": True}
    return nbformat.writes(notebook) + "\n"


def _clear(folder: Path) -> None:
    """Remove the unedited notebooks."""
    record = folder / WRITTEN
    if not record.is_file():
        return
    for name, written in json.loads(record.read_text("utf-8")).items():
        path = folder / name
        if path.is_file() and _hash(path.read_bytes()) == written:
            path.unlink()


def _free(path: Path) -> Path:
    """An unused name next to ``path``."""
    count, kept = 1, path.with_stem(f"{path.stem}-yours")
    while kept.exists():
        count += 1
        kept = path.with_stem(f"{path.stem}-yours-{count}")
    return kept


def _hash(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()
