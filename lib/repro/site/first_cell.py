"""The first cell of a notebook: it finds the checkout that the notebook belongs to.

The functions of this file are the cell, and a last line calls `begin`. They use only
the standard library and stop with one line if the page cannot run.
"""

import importlib.util
import os
import sys
from pathlib import Path

NEEDED = ("numpy", "scipy", "cv2", "numba", "matplotlib", "yaml", "jinja2")


class CannotRun(Exception):
    """Reason why no cell can run, shown as one line without a traceback."""

    def _render_traceback_(self):
        return [str(self)]


def begin(effort, page):
    """Change to the checkout, use only its code, and select the build to read."""
    root = find_checkout()
    lacking = [name for name in NEEDED if importlib.util.find_spec(name) is None]
    if lacking:
        raise CannotRun(
            f"This kernel's Python ({sys.executable}) lacks {', '.join(lacking)}: "
            f"run `make lab` in {root}, or take {root}/.venv/bin/python as the kernel."
        )
    if not (root / "figures" / effort / "results").is_dir():
        raise CannotRun(
            f"There are no results to read in {root}/figures/{effort}: "
            f"run `make notebooks EFFORT={effort}` there."
        )
    os.chdir(root)
    for folder in (root, root / "lib"):
        sys.path[:] = [str(folder), *(p for p in sys.path if p != str(folder))]
    os.environ.update(RAXEL_EFFORT=effort, RAXEL_PAGE=page)


def find_checkout():
    """The checkout around this notebook, or else the one whose raxel is installed."""
    # JupyterLab and VS Code provide the notebook's path; its folder may differ.
    named = os.environ.get("JPY_SESSION_NAME") or globals().get("__vsc_ipynb_file__")
    installed = importlib.util.find_spec("raxel")
    for start in (named, os.getcwd(), installed and installed.origin):
        path = Path(start or "").absolute()
        for folder in (path, *path.parents):
            if all((folder / part).is_dir() for part in ("chapters", "data/published")):
                return folder
    raise CannotRun(
        "No checkout of Raxel around this notebook, which needs its code and results; "
        "move it into a checkout and run `make lab` there (see README.md)."
    )
