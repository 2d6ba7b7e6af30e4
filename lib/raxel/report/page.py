"""The folder of a report, complete or as it was before, and its page of HTML."""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from raxel.errors import InputError
from raxel.evaluation.diagnoses import number
from raxel.io.files import check_can_be_written
from raxel.sets.folder import PAGE, is_report
from raxel.sets.mirror_set import MirrorSet
from raxel.sets.model import ImageSet

FILES = re.compile(
    r"index\.html|(view|corners|points|residuals|shape)-\d+\.jpg|"
    r"(residuals|coverage|stability|profiles|uncertainty)\.png"
)


def check_report(
    folder: str | Path,
    image_set: ImageSet | MirrorSet,
    others: Iterable[str | Path | None] = (),
) -> None:
    """Raise InputError unless a report of the set can be put at `folder`.

    There may be nothing, an empty folder, or an earlier report, which the new one
    replaces.

    Parameters
    ----------
    folder : str or Path
        Folder of the report.
    image_set : ImageSet or MirrorSet
        The set.
    others : iterable of str, Path or None
        Names of files that are read or written as well. None of them may be located in
        `folder`.

    Raises
    ------
    InputError
        If the folder is in the set, or the set in it; if one of `others` or another
        file is there; or if the folder cannot be written.
    """
    folder = Path(folder)
    place, home = folder.resolve(), image_set.folder.resolve()
    if place.is_relative_to(home) or home.is_relative_to(place):
        raise InputError(
            f"{folder}: this is in the set, or the set in it, and sets are only read; "
            "give a folder of its own"
        )
    for name in filter(None, others):
        if Path(name).resolve().is_relative_to(place):  # type: ignore[arg-type]
            raise InputError(
                f"{name}: found in {folder}, whose place the report takes; choose "
                "another name"
            )
    if folder.exists() and not _may_go(folder):
        raise InputError(
            f"{folder}: found other files than a report's; give a new folder"
        )
    # The new one is made in the folder that contains it.
    check_can_be_written(folder.parent / PAGE)


@contextlib.contextmanager
def new_report(folder: str | Path) -> Iterator[Path]:
    """Yield a temporary folder next to `folder`; put it in its place on success.

    If the block raises, what was at `folder` stays as it was and nothing is left.

    Parameters
    ----------
    folder : str or Path
        Folder of the report.

    Yields
    ------
    Path
        The temporary folder.
    """
    folder = Path(folder)
    made = tempfile.mkdtemp(prefix=f".{folder.name}-", dir=folder.parent)
    new, old = Path(made, "new"), Path(made, "old")
    try:
        new.mkdir()
        yield new
        if folder.exists():
            os.replace(folder, old)
        os.replace(new, folder)
    finally:
        if old.exists() and not folder.exists():
            os.replace(old, folder)
        shutil.rmtree(made, ignore_errors=True)


def _may_go(folder):
    """Whether all that is there is a report, so that nothing else is lost."""
    if not folder.is_dir():
        return False
    names = [path.name for path in folder.iterdir()]
    if not all(FILES.fullmatch(name) for name in names):
        return False
    page = folder / PAGE
    if not page.is_file():
        return not names
    return is_report(page)


def html(template: str, **values: Any) -> str:
    """Return a page by the name of its template; values are text unless marked."""
    templates = Environment(
        loader=FileSystemLoader(Path(__file__).with_name("templates")),
        autoescape=True, undefined=StrictUndefined, trim_blocks=True,
        lstrip_blocks=True,
    )  # fmt: skip
    templates.filters["form"] = number
    return templates.get_template(f"{template}.html.jinja").render(**values)
