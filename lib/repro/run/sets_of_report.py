"""Image sets with a page: those of the workflow, and those of the user."""

from __future__ import annotations

import re
from pathlib import Path

from raxel.errors import InputError
from raxel.io.documents import read_yaml
from raxel.sets import load_set
from raxel.sets.mirror_set import is_mirror_set

# Names of files that a chapter of pages already has.
TAKEN = ("index", "set")


def sets_of_report(root: Path, recorded: str) -> dict[str, str]:
    """Return set name -> folder: data/recorded/* with images, and ``recorded``.

    ``recorded`` names one set or a folder of sets. A set whose images are missing (no
    network yet) has no page, nor has an invalid one (`faulty_sets`).
    """
    found = {
        name: folder.relative_to(root).as_posix()
        for name, folder, fault in _looked_at(root)
        if not fault
    }
    if not recorded:
        return found
    given = Path(recorded)
    for folder in folders_of_sets(given):
        name = name_of(folder)
        if name in found and Path(found[name]).resolve() != folder.resolve():
            raise ValueError(
                f"RECORDED={recorded}: a set named {name} already has a page "
                f"({found[name]}); rename the folder {folder}"
            )
        found[name] = folder.as_posix()
    return found


def folders_of_sets(given: Path) -> list[Path]:
    """Return the folder of an image set, or those of the sets in it; empty for
    neither."""
    if is_mirror_set(given):
        return []
    if (given / "set.yaml").is_file():
        return [given]
    return sorted(path.parent for path in given.glob("*/set.yaml"))


def mirror_sets_without_page(given: Path) -> dict[Path, str]:
    """Return folder -> message, for ``given`` or the mirror sets in it."""
    return {
        folder: f"{folder}: mirror set: no page in the report; use raxel calibrate "
        f"{folder} --out mirror.npz --report FOLDER"
        for folder in (given, *sorted(given.glob("*")))
        if is_mirror_set(folder)
    }


def target_kind(folder: Path) -> str:
    """Return the kind of target in set.yaml; empty if there is none."""
    try:
        return str(read_yaml(folder / "set.yaml")["target"]["kind"])
    except (InputError, KeyError, TypeError):
        return ""


def faulty_sets(root: Path) -> dict[Path, str]:
    """Return folder -> one line, for invalid sets below data/recorded, and mirror
    sets."""
    faults = {folder: fault for _, folder, fault in _looked_at(root) if fault}
    return faults | mirror_sets_without_page(root / "data" / "recorded")


def _looked_at(root: Path) -> list[tuple[str, Path, str]]:
    """Name, folder and fault (empty for none) of the sets that are there."""
    found: list[tuple[str, Path, str]] = []
    folders: dict[str, Path] = {}
    for folder in folders_of_sets(root / "data" / "recorded"):
        name = name_of(folder)
        try:
            load_set(folder)
            fault = ""
        except InputError as error:
            if _not_arrived(folder):
                continue
            fault = str(error)
        first = folders.setdefault(name, folder)
        if first != folder:
            fault = f"{folder}: page name {name} is also that of {first}; rename one"
        found.append((name, folder, fault))
    return found


def _not_arrived(folder: Path) -> bool:
    """Whether set.yaml lists images of which none is in the folder."""
    try:
        views = read_yaml(folder / "set.yaml")["views"]
        images = [str(view["image"]) for view in views]
    except (InputError, KeyError, TypeError):
        return False
    return bool(images) and not any((folder / name).is_file() for name in images)


def name_of(folder: Path) -> str:
    """Return the page name of a set: its folder's name, letters, digits and hyphens
    only."""
    name = re.sub(r"[^A-Za-z0-9]+", "-", folder.resolve().name).strip("-")
    return f"photographs-{name}".strip("-") if not name or name in TAKEN else name


def set_files(folder: Path) -> dict[str, Path]:
    """Return name in the folder -> path, for set.yaml and all files of the set.

    A named folder (the truth of a rendered set) stands for all its files.
    """
    image_set = load_set(folder)
    named = {name for view in image_set.views for name in view.files}
    named |= {image_set.description.name, image_set.reference, image_set.truth} - {None}
    files: set[Path] = set()
    for path in (folder / name for name in named):
        files |= {p for p in [path, *path.rglob("*")] if p.is_file()}
    return {path.relative_to(folder).as_posix(): path for path in sorted(files)}
