"""`make readme`: the pictures of README.md, made small from those of the full report.

    python -m repro.site.readme_pictures

README.md is read where nothing is built, so they are part of the repository.
"""

from __future__ import annotations

import sys
from io import BytesIO
from pathlib import Path

from PIL import Image

from repro.run.results import write_atomic

FOLDER = "report/readme"
SIZE_PX = (560, 360)
COLOURS = 48
FIGURES = ("ext_zoo_room", "fig_3_4", "fig_2_3")


class NotBuilt(Exception):
    """A picture that the full report has not made yet; one line says which."""


def readme_pictures(root: Path) -> list[Path]:
    """Write the pictures; return their files."""
    written = []
    for name in FIGURES:
        picture = root / "figures" / "full" / f"{name}.png"
        if not picture.is_file():
            shown = picture.relative_to(root)
            raise NotBuilt(f"no {shown}; build it first: make {name}")
        small = root / FOLDER / f"{name}.png"
        write_atomic(small, _reduced(picture))
        written.append(small)
    return written


def _reduced(picture: Path) -> bytes:
    """The whole picture within `SIZE_PX`, as a PNG of few colours."""
    with Image.open(picture) as image:
        small = image.convert("RGB")
    small.thumbnail(SIZE_PX, Image.Resampling.LANCZOS)
    buffer = BytesIO()
    small.quantize(COLOURS, dither=Image.Dither.NONE).save(buffer, "PNG", optimize=True)
    return buffer.getvalue()


def main() -> int:
    """Make the pictures of the README; return the exit status."""
    try:
        written = readme_pictures(Path.cwd())
    except NotBuilt as error:
        print(f"make readme: {error}", file=sys.stderr)
        return 1
    for path in written:
        print(f"{path.relative_to(Path.cwd())} ({path.stat().st_size / 1e3:.0f} kB)")
    return 0


if __name__ == "__main__":
    sys.exit(main())
