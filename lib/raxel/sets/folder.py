"""Image sets of plain folders: the images are found by their names and sizes."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

from raxel.errors import InputError
from raxel.sets.image_files import FORMATS, is_whole, stored_size
from raxel.sets.model import ActiveGrid, Chessboard, ImageSet, View

ENDINGS = frozenset(
    [".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp", ".pgm", ".ppm", ".webp"]
)
# Files of cameras that no reader of ours decodes, and what converts them.
CONVERTERS = {
    **dict.fromkeys([".heic", ".heif"], "heif-convert"),
    **dict.fromkeys(
        [".cr2", ".cr3", ".nef", ".arw", ".dng", ".raf", ".orf", ".rw2"], "dcraw -T"
    ),
}
MAX_NAME = 100  # characters of a set's name
UNKNOWN_BOARD = Chessboard(None, None)
# What `raxel undistort` writes next to its images, and the first lines of the page of
# a report.
SIDECAR = "undistorted.json"
PAGE, MARK = "index.html", '<meta name="generator" content="raxel calibrate">'


def image_names(folder: str | Path, pattern: str | None = None) -> list[str]:
    """Return the images of a folder, numbers in their names in numerical order.

    Without a pattern these are the images in the folder itself or, if it has none,
    those in its subfolders, except folders of results. Hidden files do not count.

    Parameters
    ----------
    folder : str or Path
        The folder.
    pattern : str, optional
        Pattern of file names, relative to the folder, such as ``IMG_*.jpg`` or
        ``*/left*.png``.

    Returns
    -------
    list of str
        Names relative to the folder, with ``/`` between folders.

    Raises
    ------
    InputError
        If there is no image. Files in a format that raxel does not read are named,
        with a program that converts them.
    """
    return _listing(folder, pattern)[0]


def _listing(folder, pattern):
    """`image_names`, and the files of other formats than an image is stored in."""
    folder = Path(folder)
    if not folder.is_dir():
        fault = "is a file" if folder.is_file() else "no such folder"
        raise InputError(f"{folder}: {fault}; give the folder of an image set")
    for each in (pattern,) if pattern else ("*", "**/*"):
        try:
            paths = [path.relative_to(folder) for path in folder.glob(each)]
        except (ValueError, NotImplementedError) as fault:
            raise InputError(
                f"{folder}: images: found pattern {each!r}; give one such as '*.jpg'"
            ) from fault
        paths = sorted(filter(_is_visible, paths), key=_natural)
        if not pattern:
            made = {path.parent for path in paths if _is_of_results(folder / path)}
            paths = [path for path in paths if not made & set(path.parents[:-1])]
        found = [path for path in paths if path.suffix.lower() in ENDINGS]
        stems = {path.with_suffix("") for path in found}
        others = [
            (path.as_posix(), f"{path.suffix} is not read, convert it by {converter}")
            for path in paths
            if (converter := CONVERTERS.get(path.suffix.lower()))
            and path.with_suffix("") not in stems
        ]
        if found:
            return [path.as_posix() for path in found], others
        if others:
            name, reason = others[0]
            raise InputError(f"{folder / name}: {reason}; give TIFF or PNG")
    what = f"no image matches {pattern!r}" if pattern else "no image"
    raise InputError(f"{folder}: {what}; give a folder with {', '.join(FORMATS)}")


def _is_of_results(path):
    """Whether a file is one of those that mark a folder of new images."""
    return path.name == SIDECAR or (path.name == PAGE and is_report(path))


def is_report(page: Path) -> bool:
    """Return whether a file is the page of a report."""
    return page.is_file() and MARK in page.read_text("utf-8", errors="replace")[:2000]


def _is_visible(path):
    return not any(part.startswith(".") for part in path.parts)


def _natural(path):
    """Sorting key: texts and numbers in turn."""
    name = path.as_posix()
    parts = re.split(r"(\d+)", name.casefold())
    return [int(part) if part.isdecimal() else part for part in parts], name


def folder_set(
    folder: str | Path,
    target: Chessboard | ActiveGrid = UNKNOWN_BOARD,
    pattern: str | None = None,
) -> ImageSet:
    """Return the set of the images in a folder without set.yaml.

    The resolution is that of most images. Other files are in `unused`.

    Parameters
    ----------
    folder : str or Path
        The folder.
    target : Chessboard, optional
        What the images show; by default a chessboard of unknown size.
    pattern : str, optional
        As of `image_names`.

    Returns
    -------
    ImageSet
        The set, with all images for calibration.

    Raises
    ------
    InputError
        As `image_names`, or if no file is an image.
    """
    folder = Path(folder)
    names, others = _listing(folder, pattern)
    sizes = {name: stored_size(folder / name) for name in names}
    for name in [n for n, size in sizes.items() if size and not is_whole(folder / n)]:
        sizes[name] = None
    counts = Counter(size for size in sizes.values() if size)
    if not counts:
        raise InputError(f"{folder}: no file can be read as an image; copy them again")
    ((width, height), count), *_ = counts.most_common(1)
    unused = [
        (name, _reason(size, (width, height), count))
        for name, size in sizes.items()
        if size != (width, height)
    ] + others
    views = tuple(View(n) for n, size in sizes.items() if size == (width, height))
    return ImageSet(
        set_name(folder), width, height, target, views, folder,
        described_in=folder, unused=tuple(unused),
    )  # fmt: skip


def _reason(size, right, count):
    if size is None:
        return "not an image, or damaged"
    sizes = f"{size[0]} x {size[1]} px, {count} others have {right[0]} x {right[1]}"
    return f"{sizes}: another camera or setting"


def set_name(folder: str | Path) -> str:
    """Return the name of a folder as the name of a set, which allows fewer characters.

    Parameters
    ----------
    folder : str or Path
        The folder.

    Returns
    -------
    str
        The name, such as ``my-camera`` for ``My camera``'s folder.
    """
    name = re.sub(r"[^A-Za-z0-9._-]+", "-", Path(folder).resolve().name)
    return name.lstrip("-._")[:MAX_NAME] or "images"
