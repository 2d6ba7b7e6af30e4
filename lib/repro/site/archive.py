"""`make archive`: the built report as one file to hand on.

    python -m repro.site.archive --effort full

Unzipped, the report opens from the disk: report/index.html. The same site gives the
same bytes, whenever and wherever it is packed.
"""

from __future__ import annotations

import argparse
import sys
import zipfile
from io import BytesIO
from pathlib import Path

from repro.run.results import write_atomic
from repro.site.mirror import files_below

# Of what is packed already, packing again saves nothing and costs seconds.
PACKED = {".png", ".jpg", ".webp", ".npz", ".zip", ".woff2"}


class ArchiveError(Exception):
    """A report that cannot be packed; one line says why and what to do."""


def archive(root: Path, effort: str) -> Path:
    """Pack the site of ``effort`` into ``report/raxel-report-<effort>.zip``."""
    site = root / "report" / ("site" if effort == "full" else f"site-{effort}")
    command = "make report" if effort == "full" else f"make {effort}"
    shown = site.relative_to(root)
    if not (site / "index.html").is_file():
        raise ArchiveError(f"no {shown}/index.html; build it first: {command}")
    if not (root / "report" / "build" / effort / "site.done").is_file():
        raise ArchiveError(f"the last build of {shown} did not finish: {command}")
    out = root / "report" / f"raxel-report-{effort}.zip"
    write_atomic(out, packed(site, f"raxel-report-{effort}"))
    return out


def packed(site: Path, top: str) -> bytes:
    """A zip of the files below ``site`` in a folder ``top``: by name, without dates."""
    buffer = BytesIO()
    with zipfile.ZipFile(buffer, "w") as bundle:
        for name, path in sorted(files_below(site).items()):
            entry = zipfile.ZipInfo(f"{top}/{name}")
            entry.create_system, entry.external_attr = 3, 0o644 << 16
            packs = path.suffix not in PACKED
            entry.compress_type = zipfile.ZIP_DEFLATED if packs else zipfile.ZIP_STORED
            bundle.writestr(entry, path.read_bytes())
    return buffer.getvalue()


def main(argv: list[str] | None = None) -> int:
    """Pack the report; return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m repro.site.archive")
    parser.add_argument("--effort", choices=("quick", "full"), default="full")
    effort = parser.parse_args(argv).effort
    try:
        out = archive(Path.cwd(), effort)
    except ArchiveError as error:
        print(f"make archive: {error}", file=sys.stderr)
        return 1
    size = out.stat().st_size / 1e6
    print(f"{out.relative_to(Path.cwd())} ({size:.1f} MB): unzip it, open index.html")
    return 0


if __name__ == "__main__":
    sys.exit(main())
