"""Build the site with Sphinx, then replace the old one."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from repro.page.notebook import PageError
from repro.run.results import WRITTEN
from repro.site.assemble import assemble
from repro.site.check import check_site
from repro.site.mirror import Content, files_below, mirror

# Earlier builds wrote logs; they are removed.
DOWNLOADS = (
    *("figures", "results", "notebooks", "source", "sets", "provenance"),
    "logs",
)
GENERATED = {"search", "genindex"}
NOT_PUBLISHED = (".buildinfo", ".buildinfo.bak", "objects.inv")


def build_site(source: Path, out: Path) -> list[str]:
    """Render ``source`` and bring the site at ``out`` up to date; return what changed.

    Sphinx keeps its state next to ``source`` and renders only pages whose source
    changed. A warning is an error. Then the state is removed, too: otherwise a page
    with a warning would count as done, and the next run would pass. The same holds for
    a page that Sphinx was writing when it was killed.
    """
    state, built = source.parent / "doctrees", source.parent / "html"
    begun = source.parent / "sphinx.begun"
    if begun.exists():
        shutil.rmtree(state, ignore_errors=True)
    begun.touch()
    command = [sys.executable, "-m", "sphinx", "-b", "html", "-W", "--keep-going", "-N"]
    command += ["-j", "auto", "-d", str(state), str(source), str(built)]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    print(run.stdout, run.stderr, sep="\n")
    if run.returncode:
        shutil.rmtree(state, ignore_errors=True)
        raise PageError(_first_complaint(run.stderr, source))
    begun.unlink()
    for name in without_source(source, built):
        (built / name).unlink()
    wanted: dict[str, Content] = {
        name: path
        for name, path in files_below(built).items()
        if name not in NOT_PUBLISHED
    }
    changed = mirror(wanted, out)
    WRITTEN.extend(out / name for name in wanted)  # the present state, with valid files
    print(f"{out}: {len(wanted)} files, {len(changed)} changed")
    return changed


def without_source(source: Path, built: Path) -> list[str]:
    """Built files without a source.

    Sphinx does not delete them; a page or an image of an earlier image set must not
    remain in the site.
    """
    sources = files_below(source)
    pages = {str(Path(name).with_suffix("")) for name in sources} | GENERATED
    extra = {
        name.removeprefix("_extra/") for name in sources if name.startswith("_extra/")
    }
    image_names = {Path(name).name for name in sources}
    gone = []
    for name in files_below(built):
        top = name.split("/")[0]
        page = name.endswith(".html") and top not in DOWNLOADS
        if (
            (page and name.removesuffix(".html") not in pages)
            or (top in DOWNLOADS and name not in extra)
            or (top == "_images" and Path(name).name not in image_names)
        ):
            gone.append(name)
    return gone


def _first_complaint(stderr: str, source: Path) -> str:
    lines = [line.strip() for line in stderr.splitlines() if line.strip()]
    marked = [line for line in lines if "WARNING" in line or "ERROR" in line] or lines
    more = f" (and {len(marked) - 1} more)" if len(marked) > 1 else ""
    first = marked[0] if marked else "Sphinx stopped without a message"
    return f"site: {first.replace(f'{source.resolve()}/', '')}{more}"


def make_site(
    root: Path,
    effort: str,
    pages: Sequence[Path],
    rows: Path,
    scoreboard: Path,
    sets: Sequence[str],
    source: Path,
    out: Path,
    model: Mapping,
) -> None:
    """Assemble the source, build the site, and check it."""
    records = list(map(Path, sets))
    assemble(root, effort, pages, scoreboard, rows, source, records, model)
    build_site(source, out)
    problems = check_site(out)
    if problems:
        print("\n".join(problems))
        raise PageError(f"{len(problems)} problem(s) in the site: {problems[0]}")
