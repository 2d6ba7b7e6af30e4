"""Which image sets get a page: the workflow's photographs, and what people bring."""

from __future__ import annotations

import re
from pathlib import Path

import yaml


def sets_of_report(root: Path, recorded: str) -> dict[str, str]:
    """Set name -> folder: data/recorded/* with images there, and ``recorded``.

    ``recorded`` names one set or a folder of sets. A set whose photographs have not
    arrived (no network yet) has no page.
    """
    folders = sorted(path.parent for path in root.glob("data/recorded/*/set.yaml"))
    found = {
        name_of(folder): folder.relative_to(root).as_posix()
        for folder in folders
        if has_images(folder)
    }
    if not recorded:
        return found
    given = Path(recorded)
    folders = [given] if (given / "set.yaml").is_file() else []
    for folder in folders or sorted(path.parent for path in given.glob("*/set.yaml")):
        name = name_of(folder)
        if name in found and Path(found[name]).resolve() != folder.resolve():
            raise ValueError(
                f"RECORDED={recorded}: a set named {name} has a page already "
                f"({found[name]}); rename the folder {folder}"
            )
        found[name] = folder.as_posix()
    return found


def name_of(folder: Path) -> str:
    """Page name of a set: its folder's name, letters, digits and hyphens only."""
    return re.sub(r"[^A-Za-z0-9]+", "-", folder.resolve().name).strip("-") or "set"


def reference_of(folder: Path) -> Path | None:
    """The file of reference corners that set.yaml names, if it is there."""
    content = yaml.safe_load((folder / "set.yaml").read_text("utf-8")) or {}
    path = folder / str(content.get("reference") or "")
    return path if path.is_file() else None


def has_images(folder: Path) -> bool:
    """Whether at least one image that set.yaml lists lies in the folder."""
    content = yaml.safe_load((folder / "set.yaml").read_text("utf-8")) or {}
    views = content.get("views") or []
    return any(
        isinstance(view, dict) and (folder / str(view.get("image", ""))).is_file()
        for view in views
    )
