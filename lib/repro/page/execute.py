"""Execute a page: its file becomes a notebook with outputs, values and furniture.

The id of the page is that of the notebook: its folder and its name. A failure ends with
one line that gives position and cause.
"""

from __future__ import annotations

from pathlib import Path

from repro.page.furniture import Furnisher
from repro.page.notebook import execute, read_page, settle
from repro.page.reader import forget_results
from repro.run.results import write_atomic

CELL_SECONDS = 180


def execute_page(root: Path, page: Path, effort: str, out: Path) -> None:
    """Execute a page file into the notebook ``out``, completely or not at all."""
    import nbformat

    source = "/".join(page.parts[-3:])
    variables = {"RAXEL_EFFORT": effort, "RAXEL_PAGE": f"{out.parent.name}/{out.stem}"}
    notebook = read_page(page)
    forget_results()
    execute(notebook, page, root, variables, CELL_SECONDS)
    names = settle(notebook, page)
    Furnisher(root, effort, variables["RAXEL_PAGE"]).fill(notebook)
    notebook.metadata["raxel"] = {
        "source": source,
        "effort": effort,
        "page": variables["RAXEL_PAGE"],
        "names": names,
    }
    nbformat.validate(notebook)
    write_atomic(out, nbformat.writes(notebook) + "\n")
