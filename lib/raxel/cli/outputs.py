"""What a command writes takes the place of no device and of no file that it reads."""

from pathlib import Path

from raxel.errors import InputError


def check_written(written, image_sets, read=()):
    """Raise InputError where a file to be written is a device or read by the command.

    `written`: names of files; `image_sets`: the ImageSets that are read, none of whose
    files may be among them; `read`: names of other files. None stands for an option
    that was not given.
    """
    inputs = {Path(name).resolve() for name in read if name}
    for name in filter(None, written):
        path = Path(name).resolve()
        if Path(name).exists() and not path.is_file():
            raise InputError(
                f"{name}: found no ordinary file, and results are moved into place; "
                "give the name of a file"
            )
        for image_set in image_sets:
            if _belongs(path, image_set):
                raise InputError(
                    f"{name}: found a file of the set {image_set.folder}, which is "
                    "only read; choose another name"
                )
        if path in inputs:
            raise InputError(
                f"{name}: the command reads this file; choose another name to write"
            )


def _belongs(path, image_set):
    names = [name for view in image_set.views for name in view.files]
    if image_set.reference is not None:
        names.append(image_set.reference)
    files = [image_set.description, *(image_set.folder / name for name in names)]
    if path in {file.resolve() for file in files}:
        return True
    truth = image_set.truth
    return truth is not None and path.is_relative_to(
        (image_set.folder / truth).resolve()
    )
