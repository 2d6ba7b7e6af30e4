"""What a command writes takes the place of no device and of no file that it reads."""

import os
from pathlib import Path

from raxel.errors import InputError


def check_written(written, image_sets, read=()):
    """Raise InputError where a file to be written is a device or read by the command.

    `written`: names of files; `image_sets`: the ImageSets that are read, none of whose
    files may be among them; `read`: names of other files, and of folders whose files
    are read. None stands for an option that was not given. A file is known by what it
    is on the disk, whatever it is called: by another spelling, through a link, in
    capitals where these are the same.
    """
    inputs = {_identity(name) for name in read if name}
    owners = {
        _identity(file): image_set
        for image_set in image_sets
        for file in _files(image_set)
    }
    owners.pop(None, None)
    for name in filter(None, written):
        path = Path(name)
        if path.exists() and not path.is_file():
            raise InputError(
                f"{name}: found no ordinary file, and results are moved into place; "
                "give the name of a file"
            )
        places = path, *path.resolve().parents
        owner = next(filter(None, (owners.get(_identity(one)) for one in places)), None)
        if owner is not None:
            raise InputError(
                f"{name}: found a file of the set {owner.folder}, which is only read; "
                "choose another name"
            )
        if path.exists() and inputs & set(map(_identity, places)):
            raise InputError(
                f"{name}: the command reads this file; choose another name to write"
            )


def _files(image_set):
    """All that a set reads; the folder of its truth stands for what is in it."""
    names = [name for view in image_set.views for name in view.files]
    names += filter(None, (image_set.reference, image_set.truth))
    return [image_set.description, *(image_set.folder / name for name in names)]


def _identity(path):
    """What tells a file from all others, the same for all its names."""
    try:
        found = os.stat(path)
    except (OSError, ValueError):  # it is not there, or can have no such name
        return None
    return found.st_dev, found.st_ino
