"""Pages and site: execute a page, assemble the site's source, build the site.

    python -m repro.site.make execute PAGE.py --effort full --out NB.ipynb [--set FOLDER]
    python -m repro.site.make assemble --effort full --pages NB... --scoreboard F.md --json F
                                  --out SOURCE
    python -m repro.site.make site --source SOURCE --out SITE

Each prints what it did; a failure ends with one line that says where and why.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from repro.page.furniture import Furnisher
from repro.page.notebook import PageError, execute, read_page, settle
from repro.run.results import write_atomic

CELL_SECONDS = 180


def execute_page(
    root: Path, page: Path, effort: str, out: Path, image_set: str | None = None
) -> None:
    """Execute a page file into the notebook ``out``, whole or not at all."""
    import nbformat

    source = "/".join(page.parts[-3:])
    variables = {
        "RAXEL_EFFORT": effort,
        "RAXEL_PAGE": f"{out.parent.name}/{out.stem}",
        "RAXEL_SET": image_set or "",
    }
    notebook = read_page(page)
    execute(notebook, page, root, variables, CELL_SECONDS)
    settle(notebook, page)
    Furnisher(root, effort, variables["RAXEL_PAGE"]).fill(notebook)
    notebook.metadata["raxel"] = {"source": source}
    nbformat.validate(notebook)
    write_atomic(out, nbformat.writes(notebook) + "\n")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m repro.site.make", description=__doc__
    )
    commands = parser.add_subparsers(dest="command", required=True)
    run = commands.add_parser("execute")
    run.add_argument("page", type=Path)
    run.add_argument("--effort", choices=("quick", "full"), required=True)
    run.add_argument("--set", dest="image_set", help="folder of the page's image set")
    run.add_argument("--out", type=Path, required=True)
    gather = commands.add_parser("assemble")
    gather.add_argument("--effort", choices=("quick", "full"), required=True)
    gather.add_argument("--pages", nargs="*", type=Path, default=[])
    gather.add_argument("--scoreboard", type=Path, required=True)
    gather.add_argument("--json", type=Path, required=True)
    gather.add_argument("--out", type=Path, required=True)
    site = commands.add_parser("site")
    site.add_argument("--source", type=Path, required=True)
    site.add_argument("--out", type=Path, required=True)
    return parser


def main(argv: list[str] | None = None) -> int:
    """Run one command; return its exit status."""
    a = _parser().parse_args(argv)
    root = Path.cwd()
    try:
        if a.command == "execute":
            execute_page(root, a.page, a.effort, a.out, a.image_set)
        elif a.command == "assemble":
            from repro.site.assemble import assemble

            assemble(root, a.effort, a.pages, a.scoreboard, a.json, a.out)
        else:
            from repro.site.sphinx import build_site

            build_site(a.source, a.out)
    except PageError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
