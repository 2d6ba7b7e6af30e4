"""Build the site with Sphinx, then put it in its place whole.

python -m repro.site.sphinx --source SOURCE --out SITE
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sys
from pathlib import Path

from repro.page.notebook import PageError
from repro.run.results import WRITTEN
from repro.site.mirror import Content, files_below, mirror

DOWNLOADS = ("figures", "results", "notebooks", "source", "logs")
GENERATED = {"search", "genindex"}
NOT_PUBLISHED = (".buildinfo", ".buildinfo.bak", "objects.inv")


def build_site(source: Path, out: Path) -> list[str]:
    """Render ``source`` and bring the site at ``out`` up to date; return what changed.

    Sphinx keeps its state beside ``source`` and renders only pages whose source
    changed. A warning is an error. Then the state goes too: a page with a warning would
    otherwise count as done, and the next run would pass. So would a page that Sphinx
    was writing when it was killed.
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
    WRITTEN.extend(out / name for name in wanted)  # as it is now, with what was right
    print(f"{out}: {len(wanted)} files, {len(changed)} changed")
    return changed


def without_source(source: Path, built: Path) -> list[str]:
    """Built files that nothing in the source stands for any more.

    Sphinx leaves them where they are; a page or a picture of an image set that was
    asked for once must not stay in the site for ever.
    """
    sources = files_below(source)
    pages = {str(Path(name).with_suffix("")) for name in sources} | GENERATED
    extra = {
        name.removeprefix("_extra/") for name in sources if name.startswith("_extra/")
    }
    pictures = {Path(name).name for name in sources}
    gone = []
    for name in files_below(built):
        top = name.split("/")[0]
        page = name.endswith(".html") and top not in DOWNLOADS
        if (
            (page and name.removesuffix(".html") not in pages)
            or (top in DOWNLOADS and name not in extra)
            or (top == "_images" and Path(name).name not in pictures)
        ):
            gone.append(name)
    return gone


def _first_complaint(stderr: str, source: Path) -> str:
    lines = [line.strip() for line in stderr.splitlines() if line.strip()]
    marked = [line for line in lines if "WARNING" in line or "ERROR" in line] or lines
    more = f" (and {len(marked) - 1} more)" if len(marked) > 1 else ""
    first = marked[0] if marked else "Sphinx stopped without a word"
    return f"site: {first.replace(f'{source.resolve()}/', '')}{more}"


def main(argv: list[str] | None = None) -> int:
    """Build the site; return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m repro.site.sphinx")
    parser.add_argument("--source", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    a = parser.parse_args(argv)
    try:
        build_site(a.source, a.out)
    except PageError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
