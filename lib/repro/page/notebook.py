"""A page file becomes a notebook: percent format in, executed notebook out.

A page is a percent-format Python file. Cells tagged `active-ipynb` are comments in the
file and code in the notebook; cells tagged `active-py` stay in the file alone. The
kernel is the interpreter that runs this module, with every file it may write kept in
the checkout's cache, so it needs neither an installed kernel nor a home directory.
"""

from __future__ import annotations

import os
import re
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

from nbformat import NotebookNode

GLUE = "application/papermill.record/"
GLUED = re.compile(r"\{glue:text\}`([^`:]+)(?::([^`]*))?`")
ANSI = re.compile(r"\x1b\[[0-9;]*m")
LANGUAGE = {"name": "python", "pygments_lexer": "ipython3"}
# What such a cell calls says nothing to a reader of the page beside what it shows.
SHOWS = ("show(", "show_table(", "show_code(", "compared(")
KERNEL = {"name": "python3", "display_name": "Python 3", "language": "python"}


class PageError(Exception):
    """A page that cannot be made; the message is one line: file, cell, what it was."""


def read_page(path: Path) -> NotebookNode:
    """Notebook of a page file: display cells active, `active-py` cells left out."""
    import jupytext

    notebook = jupytext.reads(path.read_text("utf-8"), fmt="py:percent")
    notebook.cells = [
        cell
        for cell in notebook.cells
        if "active-py" not in cell.metadata.get("tags", ()) and cell.source.strip()
    ]
    if not notebook.cells:
        raise PageError(f"{path}: no cells; a page is in percent format (# %%)")
    notebook.nbformat, notebook.nbformat_minor = 4, 5
    notebook.metadata = NotebookNode(_metadata())
    for number, cell in enumerate(notebook.cells, 1):
        cell.id = f"cell-{number:03d}"
        if cell.cell_type == "code" and cell.source.startswith(SHOWS):
            cell.metadata.setdefault("tags", []).append("remove-input")
    return notebook


def _metadata() -> dict:
    return {"kernelspec": dict(KERNEL), "language_info": dict(LANGUAGE)}


def execute(
    notebook: NotebookNode,
    path: Path,
    root: Path,
    variables: Mapping[str, str],
    seconds: int,
) -> None:
    """Run every code cell of ``notebook`` in ``root``; outputs are stored in place.

    Parameters
    ----------
    path : the page's file, for messages.
    variables : environment variables for the kernel, on top of those of this process.
    seconds : time limit for one cell.

    Raises `PageError` at the first cell that fails, or if the kernel dies.
    """
    cache = root / ".cache"
    folders = {
        "IPYTHONDIR": cache / "ipython",
        "JUPYTER_CONFIG_DIR": cache / "jupyter" / "config",
        "JUPYTER_DATA_DIR": cache / "jupyter" / "data",
        "MPLCONFIGDIR": cache / "matplotlib",
    }
    for name, folder in folders.items():
        folder.mkdir(parents=True, exist_ok=True)
        os.environ[name] = str(folder)
    os.environ["JUPYTER_PATH"] = ""
    # Sockets are files here: two pages started at once cannot pick the same port. Their
    # paths have to be short, which the checkout's may not be.
    with tempfile.TemporaryDirectory(prefix="raxel-") as runtime:
        os.environ["JUPYTER_RUNTIME_DIR"] = runtime
        environment = os.environ | dict(variables)
        environment["PYDEVD_DISABLE_FILE_VALIDATION"] = "1"
        _run(notebook, path, root, environment, runtime, seconds)


def _run(
    notebook: NotebookNode,
    path: Path,
    root: Path,
    environment: dict[str, str],
    runtime: str,
    seconds: int,
) -> None:
    from nbclient import NotebookClient
    from nbclient.exceptions import (
        CellExecutionError,
        CellTimeoutError,
        DeadKernelError,
    )

    client = NotebookClient(
        notebook,
        kernel_manager_class=_own_kernel(runtime),
        timeout=seconds,
        record_timing=False,
        coalesce_streams=True,
        resources={"metadata": {"path": str(root)}},
    )
    try:
        client.execute(env=environment)
    except CellExecutionError as error:
        print(ANSI.sub("", str(error)), file=sys.stderr)
        place, what = _failed(notebook, path), f"{error.ename}: {error.evalue}"
    except CellTimeoutError:
        place, what = _failed(notebook, path), f"longer than {seconds} s; stopped"
    except DeadKernelError:
        place, what = (
            _failed(notebook, path),
            "the kernel died (memory? a native crash?)",
        )
    else:
        return
    raise PageError(f"{place}: {' '.join(ANSI.sub('', what).split())}")


def _own_kernel(runtime: str) -> type:
    """A kernel manager that starts this interpreter, whatever kernels are installed."""
    from jupyter_client.kernelspec import KernelSpec, KernelSpecManager
    from jupyter_client.manager import AsyncKernelManager
    from traitlets import default

    class ThisInterpreter(KernelSpecManager):
        def get_kernel_spec(self, kernel_name: str) -> KernelSpec:
            return KernelSpec(
                argv=[
                    sys.executable,
                    "-m",
                    "ipykernel_launcher",
                    "-f",
                    "{connection_file}",
                    "--HistoryManager.enabled=False",
                ],
                **{key: KERNEL[key] for key in ("display_name", "language")},
            )

    class OwnKernel(AsyncKernelManager):
        @default("kernel_spec_manager")
        def _this_interpreter(self) -> KernelSpecManager:
            return ThisInterpreter(parent=self)

        @default("connection_file")
        def _in_runtime(self) -> str:
            return os.path.join(runtime, "kernel.json")

        @default("transport")
        def _socket_files(self) -> str:
            return "ipc"

    return OwnKernel


def _failed(notebook: NotebookNode, path: Path) -> str:
    """Place of the cell that was running: the last one with a number, or the first."""
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    begun = [c for c in code if c.execution_count or c.outputs]
    cell = begun[-1] if begun else code[0]
    first = cell.source.strip().splitlines()[0]
    lines = path.read_text("utf-8").splitlines()
    places = [
        number
        for number, line in enumerate(lines, 1)
        if line.removeprefix("#").strip() == first.strip()
    ]
    where = f"{path}:{places[-1]}" if places else f"{path}"
    return f"{where}: cell {notebook.cells.index(cell) + 1} `{first}`"


def settle(notebook: NotebookNode, path: Path) -> None:
    """Keep in the notebook what is the same in every run, and put values into prose.

    Standard error goes to the log. A `{glue:text}` role in a markdown cell becomes the
    value that a cell glued, so that the notebook reads as the page does. A cell that
    only names values, or a display cell that shows nothing (it opens what others show),
    is left out of the page.
    """
    notebook.metadata = NotebookNode(_metadata())
    glued: dict[str, object] = {}
    for cell in notebook.cells:
        cell.metadata.pop("execution", None)
        if cell.cell_type == "code":
            outputs = cell.outputs
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
            f"{path}: cell {number}: prose asks for the value {name!r}, which no cell "
            f"gives; there are {', '.join(sorted(glued)) or 'none'}"
        )
    try:
        return format(glued[name], form)
    except (TypeError, ValueError) as error:
        raise PageError(
            f"{path}: cell {number}: value {name} = {glued[name]!r}: {error}"
        ) from None
