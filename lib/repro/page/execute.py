"""Execute a page: its file becomes a notebook with outputs, values and furniture.

    python -m repro.page.execute PAGE.py --effort full --out NB.ipynb

The id of the page is that of the notebook: its folder and its name. A failure ends with
one line that gives position and cause.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from repro.page.furniture import Furnisher
from repro.page.notebook import PageError, execute, read_page, settle
from repro.run.results import write_atomic

CELL_SECONDS = 180


def execute_page(root: Path, page: Path, effort: str, out: Path) -> None:
    """Execute a page file into the notebook ``out``, completely or not at all."""
    import nbformat

    source = "/".join(page.parts[-3:])
    variables = {"RAXEL_EFFORT": effort, "RAXEL_PAGE": f"{out.parent.name}/{out.stem}"}
    notebook = read_page(page)
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


def main(argv: list[str] | None = None) -> int:
    """Execute one page; return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m repro.page.execute")
    parser.add_argument("page", type=Path)
    parser.add_argument("--effort", choices=("quick", "full"), required=True)
    parser.add_argument("--out", type=Path, required=True)
    a = parser.parse_args(argv)
    try:
        execute_page(Path.cwd(), a.page, a.effort, a.out)
    except PageError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
