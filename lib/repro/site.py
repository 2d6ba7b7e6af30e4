"""Build the site with Sphinx, then put it in its place whole."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

from repro.mirror import Content, files_below, mirror
from repro.notebook import PageError

NOT_PUBLISHED = (".buildinfo", ".buildinfo.bak", "objects.inv")


def build_site(source: Path, out: Path) -> list[str]:
    """Render ``source`` and bring the site at ``out`` up to date; return what changed.

    Sphinx keeps its state beside ``source`` and renders only pages whose source
    changed. A warning is an error. Then the state goes too: a page with a warning would
    otherwise count as done, and the next run would pass.
    """
    state, built = source.parent / "doctrees", source.parent / "html"
    command = [sys.executable, "-m", "sphinx", "-b", "html", "-W", "--keep-going", "-N"]
    command += ["-d", str(state), str(source), str(built)]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    print(run.stdout, run.stderr, sep="\n")
    if run.returncode:
        shutil.rmtree(state, ignore_errors=True)
        raise PageError(_first_complaint(run.stderr, source))
    wanted: dict[str, Content] = {
        name: path
        for name, path in files_below(built).items()
        if name not in NOT_PUBLISHED
    }
    # The start page comes last: it stands for the whole site in the workflow.
    wanted["index.html"] = wanted.pop("index.html")
    changed = mirror(wanted, out)
    (out / "index.html").touch()
    print(f"{out}: {len(wanted)} files, {len(changed)} changed")
    return changed


def _first_complaint(stderr: str, source: Path) -> str:
    lines = [line.strip() for line in stderr.splitlines() if line.strip()]
    marked = [line for line in lines if "WARNING" in line or "ERROR" in line] or lines
    more = f" (and {len(marked) - 1} more)" if len(marked) > 1 else ""
    first = marked[0] if marked else "Sphinx stopped without a word"
    return f"site: {first.replace(f'{source.resolve()}/', '')}{more}"
