"""A folder that a command makes: it appears when all is in it, or not at all."""

import contextlib
import os
import tempfile
from pathlib import Path

from raxel.errors import InputError
from raxel.io.files import check_can_be_written


@contextlib.contextmanager
def new_folder(out):
    """Yield a folder that becomes `out` when the block ends without a fault.

    Raises InputError where `out` is there already or cannot be made.
    """
    out = Path(out)
    if out.exists() or out.is_symlink():
        raise InputError(f"{out}: exists already; name a new folder")
    check_can_be_written(out)
    with tempfile.TemporaryDirectory(dir=out.parent, prefix=f".{out.name}-") as room:
        folder = Path(room) / "made"
        folder.mkdir()
        yield folder
        os.rename(folder, out)
