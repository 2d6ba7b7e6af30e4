"""Checks of the files that a command writes, and folders that appear complete."""

import contextlib
import os
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import click

from raxel.cameras.core.base import Camera
from raxel.errors import InputError
from raxel.evaluation.diagnoses import STRICT
from raxel.io.files import check_can_be_written, together, write_json
from raxel.report import check_report, new_report
from raxel.sets import ImageSet, MirrorSet

STRICT_STATUS = 3


def check_writable(*paths: str | None) -> None:
    """Raise InputError unless files can be written at all paths that are given."""
    for path in filter(None, paths):
        check_can_be_written(path)


def check_outputs(
    options: SimpleNamespace,
    source: ImageSet | MirrorSet,
    cameras: Sequence[str] = (),
    read: Iterable[str | None] = (),
) -> None:
    """Raise InputError unless the results of a command on a set can be written.

    Parameters
    ----------
    options : SimpleNamespace
        Options of the command, with `json` and possibly `report`.
    source : ImageSet or MirrorSet
        The set.
    cameras : sequence of str
        Files of cameras that the command writes.
    read : iterable of str or None
        Files that the command reads in addition to those of the set.
    """
    written = [*cameras, *filter(None, [options.json])]
    check_writable(*written)
    if len({Path(path).resolve() for path in written}) < len(written):
        raise InputError(
            f"{options.json}: --json names the file of another result; give another "
            "name"
            if cameras[1:]
            else f"{options.json}: --json and --out name the same file; give two names"
        )
    inputs: list[str | Path] = [source.description, *filter(None, read)]
    if isinstance(source, MirrorSet) and isinstance(source.viewer, Path):
        inputs.append(source.viewer)
    own = {"": source} if isinstance(source, ImageSet) else source.image_sets
    check_written(written, own.values(), inputs)
    if getattr(options, "report", None):
        for one in (source, *own.values()):
            check_report(options.report, one, [*written, *inputs])


def write_results(
    options: SimpleNamespace,
    result: dict[str, Any],
    cameras: dict[str, Camera] | None = None,
    draw: Callable[[Path], None] | None = None,
) -> None:
    """Write --json, cameras by file name and --report: all or none.

    `draw` writes the report into a folder. This takes its place after the other files.
    """
    with contextlib.ExitStack() as stack:
        if draw and options.report:
            draw(stack.enter_context(new_report(options.report)))
        place = stack.enter_context(together())
        for path, camera in (cameras or {}).items():
            camera.save(place(path))
        if options.json:
            write_json(place(options.json), result)


def exit_if_strict(options: SimpleNamespace, result: dict[str, Any]) -> None:
    """Raise Exit with --strict if the result has one of the STRICT diagnoses."""
    codes = {one["code"] for one in result["diagnoses"]} & set(STRICT)
    if options.strict and codes:
        problem = f"raxel: --strict: {', '.join(sorted(codes))}; results are saved"
        print(problem, file=sys.stderr)
        raise click.exceptions.Exit(STRICT_STATUS)


def check_written(
    written: Iterable[str | Path | None],
    image_sets: Iterable[ImageSet],
    read: Iterable[str | Path | None] = (),
) -> None:
    """Raise InputError if an output is a device or an input of the command.

    A file is identified by its device and inode, so that other spellings, links and
    other capitals (where the file system ignores them) are recognised.

    Parameters
    ----------
    written : iterable of path or None
        Files that the command writes. None stands for an option that is not given.
    image_sets : iterable of ImageSet
        Image sets that the command reads. Outputs must not replace any of their files.
    read : iterable of path or None
        Other files that the command reads, and folders with such files.
    """
    inputs = {_identity(name) for name in read if name}
    owners = {
        _identity(file): image_set
        for image_set in image_sets
        for file in _files(image_set)
    }
    owners.pop(None, None)
    for path in [Path(name) for name in written if name]:
        if path.exists() and not path.is_file():
            raise InputError(f"{path}: not a regular file; give the name of a file")
        paths = path, *path.resolve().parents
        owner = next(filter(None, (owners.get(_identity(one)) for one in paths)), None)
        if owner is not None:
            raise InputError(
                f"{path}: belongs to the image set {owner.folder}; choose another name"
            )
        if path.exists() and inputs & set(map(_identity, paths)):
            raise InputError(
                f"{path}: is an input of this command; choose another name"
            )


def _files(image_set: ImageSet) -> list[Path]:
    """Return all files that a set reads; its truth is a folder."""
    names = [name for view in image_set.views for name in view.files]
    names += filter(None, (image_set.reference, image_set.truth))
    return [image_set.description, *(image_set.folder / name for name in names)]


def _identity(path: str | Path) -> tuple[int, int] | None:
    """Return what all names of one file have in common; None if there is no file."""
    try:
        found = os.stat(path)
    except (OSError, ValueError):  # no such file, or not a possible name
        return None
    return found.st_dev, found.st_ino


@contextlib.contextmanager
def new_folder(out: str | Path) -> Iterator[Path]:
    """Yield a folder that is renamed to `out` if the block ends without an error.

    Raises InputError if `out` exists or cannot be created.
    """
    out = Path(out)
    if out.exists() or out.is_symlink():
        raise InputError(f"{out}: already exists; give the name of a new folder")
    check_can_be_written(out)
    with tempfile.TemporaryDirectory(dir=out.parent, prefix=f".{out.name}-") as room:
        folder = Path(room) / "made"
        folder.mkdir()
        yield folder
        os.rename(folder, out)
