"""A report is a folder: there whole, or as it was before."""

import contextlib
import os
import re
import shutil
import tempfile
from pathlib import Path

from raxel.errors import InputError
from raxel.io.files import check_can_be_written

PAGE = "index.html"
MARK = '<meta name="generator" content="raxel calibrate">'
FILES = re.compile(
    r"index\.html|(corners|points|residuals|shape)-\d+\.jpg|"
    r"(residuals|coverage|stability|profiles)\.png"
)


def check_report(folder, image_set, others=()):
    """Raise InputError unless a report of the set can be put at `folder`.

    There may be nothing, an empty folder, or an earlier report, whose place it takes.
    others: names of files that are read or written as well, None among them; none of
    them may lie there.
    """
    folder = Path(folder)
    place, home = folder.resolve(), image_set.folder.resolve()
    if place.is_relative_to(home) or home.is_relative_to(place):
        raise InputError(
            f"{folder}: this is in the set, or the set in it, and sets are only read; "
            "give a folder of its own"
        )
    for name in filter(None, others):
        if Path(name).resolve().is_relative_to(place):
            raise InputError(
                f"{name}: found in {folder}, whose place the report takes; choose "
                "another name"
            )
    if folder.exists() and not _may_go(folder):
        raise InputError(
            f"{folder}: found other files than a report's; give a new folder"
        )
    # The folder beside which the new one is made is to be written to.
    check_can_be_written(folder.parent / PAGE)


@contextlib.contextmanager
def new_report(folder):
    """Give a temporary folder beside `folder`; put it in its place on success.

    If the block raises, what was at `folder` stays as it was and nothing is left.
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
    return MARK in page.read_text("utf-8", errors="replace")[:2000]
