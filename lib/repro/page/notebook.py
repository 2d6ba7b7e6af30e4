"""A page file becomes a notebook: percent format in, executed notebook out.

A page is a Python file in percent format, the `page.py` of its package. Cells tagged
`active-ipynb` are comments in the file and code in the notebook; cells tagged
`active-py` are in the file only. Cells run in an IPython shell in this process, because
a separate kernel would repeat all imports for each page.
"""

from __future__ import annotations

import os
import re
import signal
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from nbformat import NotebookNode
from nbformat.v4 import new_output

from raxel.errors import InputError
from repro.page.folding import folded

GLUED = re.compile(r"\{glue:text\}`([^`:]+)(?::([^`]*))?`")
ANSI = re.compile(r"\x1b\[[0-9;]*m")
LANGUAGE = {"name": "python", "pygments_lexer": "ipython3"}
# The code of such a cell tells a reader no more than its output.
SHOWS = ("show(", "show_table(", "show_code(", "compared(")
KERNEL = {"name": "python3", "display_name": "Python 3", "language": "python"}


class PageError(InputError):
    """A page that cannot be made; the message is one line: file, cell, cause."""


def read_page(path: Path) -> NotebookNode:
    """Return the notebook of a page file: display cells active, `active-py` cells
    omitted.

    Code that only prepares is folded (`repro.page.folding`).
    """
    import jupytext

    notebook = jupytext.reads(path.read_text("utf-8"), fmt="py:percent")
    notebook.cells = [
        cell
        for cell in notebook.cells
        if "active-py" not in _tags(cell) and cell.source.strip()
    ]
    if not notebook.cells:
        raise PageError(f"{path}: no cells; a page is in percent format (# %%)")
    notebook.nbformat, notebook.nbformat_minor = 4, 5
    notebook.metadata = NotebookNode(_metadata())
    notebook.cells = [part for cell in notebook.cells for part in _prepared(cell)]
    for number, cell in enumerate(notebook.cells, 1):
        cell.id = f"cell-{number:03d}"
    return notebook


def _prepared(cell: NotebookNode) -> list[NotebookNode]:
    """A cell as on the page: calls of display functions omitted, code folded."""
    if cell.cell_type != "code":
        return [cell]
    if cell.source.startswith(SHOWS):
        cell.metadata.setdefault("tags", []).append("remove-input")
        return [cell]
    return [cell] if "active-ipynb" in _tags(cell) else folded(cell)


def _tags(cell: NotebookNode) -> list[str]:
    return cell.metadata.get("tags", [])


def _metadata() -> dict:
    return {"kernelspec": dict(KERNEL), "language_info": dict(LANGUAGE)}


def execute(
    notebook: NotebookNode,
    path: Path,
    root: Path,
    variables: Mapping[str, str],
    seconds: int,
) -> None:
    """Run every code cell of ``notebook``; outputs are stored in place.

    Parameters
    ----------
    path : the page's file, for messages.
    root : the checkout, which keeps IPython's files; it is the current folder.
    variables : environment variables for the cells, on top of those of this process.
    seconds : time limit for one cell.

    Raises `PageError` at the first cell that fails.
    """
    own = root / ".cache" / "ipython"
    own.mkdir(parents=True, exist_ok=True)
    with _environment({**variables, "IPYTHONDIR": str(own)}), _shell() as shell:
        code = [cell for cell in notebook.cells if cell.cell_type == "code"]
        for count, cell in enumerate(code, 1):
            cell.execution_count = count
            fault = _run(shell, cell, seconds)
            if fault:
                number = notebook.cells.index(cell) + 1
                first = cell.source.strip().splitlines()[0].strip()
                place = f"{path}:{_line_of(first, path)}: cell {number}"
                raise PageError(f"{place} `{first}`: {fault}")


@contextmanager
def _environment(variables: Mapping[str, str]) -> Iterator[None]:
    before = dict(os.environ)
    os.environ.update(variables)
    try:
        yield
    finally:
        os.environ.clear()
        os.environ.update(before)


@contextmanager
def _shell() -> Iterator:
    """A new IPython shell without history; the main module is restored afterwards."""
    from IPython.core.interactiveshell import InteractiveShell
    from traitlets.config import Config

    main = sys.modules["__main__"]
    InteractiveShell.clear_instance()
    shell = InteractiveShell.instance(
        config=Config({"HistoryManager": {"enabled": False}})
    )
    try:
        yield shell
    finally:
        shell.reset(new_session=False)
        InteractiveShell.clear_instance()
        sys.modules["__main__"] = main


def _run(shell, cell: NotebookNode, seconds: int) -> str:
    """Run one cell and store its outputs; return the error, or nothing."""
    from IPython.utils.capture import capture_output

    with capture_output() as kept:
        # The value of the last line is an output like displayed objects.
        shell.display_trap.hook = sys.displayhook
        signal.signal(signal.SIGALRM, _too_long)
        signal.alarm(seconds)
        try:
            done = shell.run_cell(cell.source, store_history=False)
        finally:
            signal.alarm(0)
    streams = [("stdout", kept.stdout), ("stderr", kept.stderr)]
    cell.outputs = [
        *(new_output("stream", name=name, text=text) for name, text in streams if text),
        *(
            new_output("display_data", data=shown.data, metadata=shown.metadata)
            for shown in kept.outputs
        ),
    ]
    error = done.error_before_exec or done.error_in_exec
    if error is None:
        return ""
    print(ANSI.sub("", kept.stdout), file=sys.stderr)
    if isinstance(error, _TooLong):
        return f"longer than {seconds} s; stopped"
    return " ".join(f"{type(error).__name__}: {ANSI.sub('', str(error))}".split())


class _TooLong(Exception):
    """A cell exceeded the time limit."""


def _too_long(number: int, frame: object) -> None:
    raise _TooLong


def _line_of(text: str, path: Path) -> int:
    """Number of the page's last line with this text, as code or as a display line."""
    lines = path.read_text("utf-8").splitlines()
    same = (n for n, li in enumerate(lines, 1) if li.removeprefix("#").strip() == text)
    return max(same, default=1)


def settle(notebook: NotebookNode, path: Path) -> dict[str, dict]:
    """Keep only reproducible outputs, and insert values into the prose.

    Returns the value of each name and where it was made: path, function, and available
    results. Standard error goes to the log. A `{glue:text}` role in a markdown cell is
    replaced by the value, so that the notebook reads like the page. A cell that only
    names values, or a display cell without output, is omitted from the page.
    """
    notebook.metadata = NotebookNode(_metadata())
    glued: dict[str, object] = {}
    names: dict[str, dict] = {}
    for cell in notebook.cells:
        cell.metadata.pop("execution", None)
        if cell.cell_type == "code":
            outputs = cell.outputs
            names |= _made_by(cell, path)
            cell.outputs = [o for o in outputs if _kept(o, glued)]
            tags = cell.metadata.setdefault("tags", [])
            silent = "active-ipynb" in tags or any(_glue_name(o) for o in outputs)
            if silent and not cell.outputs and "remove-input" not in tags:
                tags.append("remove-input")
    for number, cell in enumerate(notebook.cells, 1):
        if cell.cell_type == "markdown":
            cell.source = GLUED.sub(
                lambda match, number=number: _pasted(match, glued, path, number),
                cell.source,
            )
    return names


def _made_by(cell: NotebookNode, path: Path) -> dict[str, dict]:
    """Values of the names of a cell and where they were made."""
    glued = [o.metadata["scrapbook"] for o in cell.outputs if _glue_name(o)]
    names = {
        one["name"]: {**one["made"], "value": one["value"]}
        for one in glued
        if "made" in one
    }
    for made in names.values():
        if not made["path"]:
            made["path"] = "/".join(("chapters", *path.parts[-3:]))
    return names


def _glue_name(output: NotebookNode) -> str | None:
    return output.get("metadata", {}).get("scrapbook", {}).get("name")


def _kept(output: NotebookNode, glued: dict[str, object]) -> bool:
    if output.output_type == "stream" and output.name == "stderr":
        print(ANSI.sub("", output.text), file=sys.stderr)
        return False
    name = _glue_name(output)
    if name is None:
        return True
    glued[name] = output.metadata["scrapbook"]["value"]
    return False


def _pasted(
    match: re.Match, glued: Mapping[str, object], path: Path, number: int
) -> str:
    name, form = match.group(1), match.group(2) or ""
    if name not in glued:
        raise PageError(
            f"{path}: cell {number}: value {name!r} is not defined; known are "
            f"{', '.join(sorted(glued)) or 'none'}"
        )
    try:
        return format(glued[name], form)
    except (TypeError, ValueError) as error:
        raise PageError(
            f"{path}: cell {number}: value {name} = {glued[name]!r}: {error}"
        ) from None
