"""The executed pages as notebooks to work in."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path


def notebooks(pages: list[Path], folder: Path) -> None:
    """Copy the executed pages to ``folder``, one sub-folder per chapter."""
    with tempfile.TemporaryDirectory(dir=_made(folder.parent)) as scratch:
        for page in pages:
            target = Path(scratch) / "notebooks" / page.parent.name / page.name
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(page, target)
        shutil.rmtree(folder, ignore_errors=True)
        shutil.move(Path(scratch) / "notebooks", folder)


def _made(folder: Path) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    return folder
