"""Public names of the library: few, importable, and all that pages use."""

import ast
import importlib
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
FACES = [
    ".".join(path.parent.relative_to(ROOT / "lib").parts)
    for path in sorted((ROOT / "lib/raxel").rglob("__init__.pyi"))
]
MAX_NAMES = 400


def imported(path):
    """(module, name) of what a file imports from the library."""
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("raxel"):
            yield from ((node.module, alias.name) for alias in node.names)


def test_public_names_are_limited_and_unique():
    names = [
        f"{face}.{n}" for face in FACES for n in importlib.import_module(face).__all__
    ]
    assert 300 < len(names) == len(set(names)) <= MAX_NAMES


@pytest.mark.parametrize("face", FACES)
def test_public_names_exist(face):
    module = importlib.import_module(face)
    for name in module.__all__:
        assert not name.startswith("_")
        found = getattr(module, name)
        home = getattr(found, "__module__", face)
        assert not callable(found) or home.startswith(face), name


def test_pages_import_only_public_names():
    hidden = {
        f"{path.relative_to(ROOT)}: {module}.{name}"
        for path in (ROOT / "chapters").rglob("*.py")
        for module, name in imported(path)
        if module not in ("raxel.errors", "raxel.cli")
        and name not in getattr(importlib.import_module(module), "__all__", ())
    }
    assert not hidden


def test_import_raxel_is_lazy():
    code = (
        "import sys, raxel.calibration, raxel.cameras\n"
        "assert not {'numpy', 'cv2', 'numba', 'scipy'} & sys.modules.keys()\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=ROOT / "lib")
