"""Execute a page: its file becomes a notebook with outputs, values and furniture.

    python -m repro.page.execute PAGE.py --effort full --out NB.ipynb [--set FOLDER]

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
from repro.run.sets_of_report import name_of

CELL_SECONDS = 180


def execute_page(
    root: Path, page: Path, effort: str, out: Path, image_set: str | None = None
) -> None:
    """Execute a page file into the notebook ``out``, completely or not at all."""
    import nbformat

    source = "/".join(page.parts[-3:])
    variables = {
        "RAXEL_EFFORT": effort,
        "RAXEL_PAGE": f"{out.parent.name}/{out.stem}",
        "RAXEL_SET": image_set or "",
    }
    notebook = read_page(page)
    execute(notebook, page, root, variables, CELL_SECONDS)
    names = settle(notebook, page)
    Furnisher(root, effort, variables["RAXEL_PAGE"]).fill(notebook)
    notebook.metadata["raxel"] = {
        "source": source,
        "effort": effort,
        "page": variables["RAXEL_PAGE"],
        # By its name: the user's folder is private.
        "set": name_of(Path(image_set)) if image_set else "",
        "names": names,
    }
    nbformat.validate(notebook)
    write_atomic(out, nbformat.writes(notebook) + "\n")


def main(argv: list[str] | None = None) -> int:
    """Execute one page; return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m repro.page.execute")
    parser.add_argument("page", type=Path)
    parser.add_argument("--effort", choices=("quick", "full"), required=True)
    parser.add_argument("--set", dest="image_set", help="folder of the page's set")
    parser.add_argument("--out", type=Path, required=True)
    a = parser.parse_args(argv)
    try:
        execute_page(Path.cwd(), a.page, a.effort, a.out, a.image_set)
    except PageError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
