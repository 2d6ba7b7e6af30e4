"""Copies of the checkout without its builds."""

import shutil
from pathlib import Path

ROOT = Path(__file__).parents[1]


def copy_checkout(to: Path) -> Path:
    """Copy what a container copies: all except the folders of .containerignore."""
    built = {ROOT / name for name in (ROOT / ".containerignore").read_text().split()}
    shutil.copytree(
        ROOT, to, dirs_exist_ok=True,
        ignore=lambda at, names: [n for n in names if Path(at, n) in built],
    )  # fmt: skip
    return to
