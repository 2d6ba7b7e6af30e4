"""Files from outside are looked at before they are opened."""

import os
import stat

from raxel.errors import InputError


def file_size(path, what="file"):
    """Bytes of the regular file at `path`; `what` is its name in messages.

    Raises InputError for one that is missing, may not be read, or is a folder, a pipe
    or a device: to open a pipe may take for ever, and a device may have no end.
    """
    try:
        status = os.stat(path)
    except FileNotFoundError as fault:
        raise InputError(f"{path}: no such {what}; check the name") from fault
    except (OSError, ValueError) as fault:
        told = getattr(fault, "strerror", None) or fault
        raise InputError(f"{path}: cannot be read ({told})") from fault
    if not stat.S_ISREG(status.st_mode):
        found = "a folder" if stat.S_ISDIR(status.st_mode) else "a pipe or a device"
        raise InputError(f"{path}: not a {what}: found {found}; give a plain file")
    if not os.access(path, os.R_OK):
        raise InputError(f"{path}: cannot be read (Permission denied)")
    return status.st_size


def check_size(path, most, what="file"):
    """Raise InputError for a file of more than `most` bytes, and as `file_size`."""
    size = file_size(path, what)
    if size > most:
        raise InputError(
            f"{path}: found {size / 1e6:.4g} MB, more than is read; is it the right "
            f"{what}? Give {most / 1e6:g} MB at most"
        )
