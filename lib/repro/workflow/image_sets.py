"""The image sets of the report, and the task that calibrates one of them.

The calibration is the library's command, `raxel calibrate FOLDER`. A set that it
rejects leaves its message.
"""

from __future__ import annotations

import hashlib
import json
import re
import shutil
import sys
from collections.abc import Mapping
from contextlib import redirect_stderr
from functools import cached_property
from io import StringIO
from pathlib import Path

from raxel.sets.folder import ENDINGS
from repro.run.reach import Reach
from repro.run.results import WRITTEN, hash_of, write_json

RESULTS = "report/build/sets"
DESCRIPTIONS = ("set.yaml", "mirror.yaml")
PUBLISHED = ("*.npz", "*.json", "report/*")  # set.yaml names the user's folder
CODE = (
    ("raxel.cli.sets", "result_folder"),
    ("raxel.cli.calibrate", "calibrate"),
    ("raxel.cli.mirror", "calibrate_mirror_set"),
)
READ = (("lib/raxel/report/templates", "*"), ("lib/raxel/sets", "*.schema.json"))


class ImageSets:
    """Image sets by their names in the site, and the key of each."""

    def __init__(self, root: Path, reach: Reach, folders: Mapping[str, str]) -> None:
        self.root = root
        self.reach = reach
        self.folders = folders

    def results(self) -> list[str]:
        """Return the records of all calibrations."""
        return [f"{RESULTS}/{name}.json" for name in self.folders]

    def messages(self) -> list[str]:
        """Return why sets have no camera, one line each."""
        records = [json.loads((self.root / p).read_text()) for p in self.results()]
        return [f"not calibrated: {r['message']}" for r in records if r["message"]]

    def key(self, name: str) -> str:
        """Return the key over the code, what it reads, and all files of a set."""
        return self._keys[name]

    @cached_property
    def _keys(self) -> dict[str, str]:
        read = (_hashes(self.root / f, p) for f, p in READ)
        code = [self.reach.key(*CODE), *read]
        keys = {}
        for name, folder in self.folders.items():
            text = json.dumps([*code, _hashes(self.root / folder)])
            keys[name] = hashlib.sha256(text.encode()).hexdigest()[:16]
        return keys


def _hashes(folder: Path, pattern: str = "*") -> dict[str, str]:
    files = sorted(path for path in folder.rglob(pattern) if path.is_file())
    return {path.relative_to(folder).as_posix(): hash_of(path) for path in files}


def image_sets(root: Path, recorded: str) -> dict[str, str]:
    """Return name in the site -> folder: sets of data/recorded with images, and
    ``recorded``."""
    own = sets_in(root / "data" / "recorded")
    folders = [path.relative_to(root) for path in own if _has_images(path)]
    if recorded:
        folders += sets_in(Path(recorded))
    found: dict[str, str] = {}
    for folder in folders:
        name = name_of(folder)
        first = root / found.setdefault(name, folder.as_posix())
        if first.resolve() != (root / folder).resolve():
            raise ValueError(
                f"{folder}: the name {name} is also that of {first}; rename the folder"
            )
    return found


def sets_in(folder: Path) -> list[Path]:
    """Return the folder if it is an image set or mirror set, or the sets in it.

    Without any, a folder of images is a set.
    """
    for candidates in ([folder], sorted(folder.glob("*"))):
        found = [f for f in candidates if any((f / d).is_file() for d in DESCRIPTIONS)]
        if found:
            return found
    return [folder] if _has_images(folder) else []


def _has_images(folder: Path) -> bool:
    return any(path.suffix.lower() in ENDINGS for path in folder.rglob("*"))


def name_of(folder: Path) -> str:
    """Return the name of a set in the site: its folder's name, letters, digits and
    hyphens only."""
    name = re.sub(r"[^A-Za-z0-9]+", "-", folder.resolve().name).strip("-")
    return name or "set"


def calibrate_set(folder: str, name: str) -> None:
    """Calibrate one set; write a record with the names of the results or the
    message."""
    from raxel import cli

    out = Path(RESULTS) / name
    shutil.rmtree(out, ignore_errors=True)  # of earlier images
    out.parent.mkdir(parents=True, exist_ok=True)
    lines = StringIO()
    with redirect_stderr(lines):
        status = cli.main(["calibrate", folder, "--out", str(out)])
    print(lines.getvalue(), file=sys.stderr)
    files = sorted(path for pattern in PUBLISHED for path in out.glob(pattern))
    message = lines.getvalue().strip().splitlines()[-1] if status else ""
    WRITTEN.extend(files)
    write_json(
        Path(RESULTS) / f"{name}.json",
        {
            "name": name,
            "message": message.removeprefix("raxel: ").replace(folder, name),
            "files": [path.relative_to(out).as_posix() for path in files],
        },
    )
