"""A report is a folder: there whole, or as it was before."""

import contextlib
import os
import shutil
import tempfile
from pathlib import Path

from raxel.errors import InputError
from raxel.files import check_can_be_written

PAGE = "index.html"
MARK = '<meta name="generator" content="raxel calibrate">'


def check_report(folder, image_set):
    """Raise InputError unless a report of the set can be put at `folder`.

    There may be nothing, an empty folder, or an earlier report, whose place it takes.
    """
    folder = Path(folder)
    place, home = folder.resolve(), image_set.folder.resolve()
    if place == home or place in home.parents or home in place.parents:
        raise InputError(
            f"{folder}: this is in the set, or the set in it, and sets are only read; "
            "give a folder of its own"
        )
    if folder.exists() and not _may_go(folder):
        raise InputError(
            f"{folder}: found other files than a report; give a new folder"
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
    with contextlib.ExitStack() as cleaning:
        cleaning.callback(shutil.rmtree, made, ignore_errors=True)
        new = Path(made, "new")
        new.mkdir()
        yield new
        if folder.exists():
            os.replace(folder, Path(made, "old"))
        os.replace(new, folder)


def _may_go(folder):
    if not folder.is_dir():
        return False
    if not any(folder.iterdir()):
        return True
    page = folder / PAGE
    return page.is_file() and MARK in page.read_text("utf-8", errors="replace")[:2000]
