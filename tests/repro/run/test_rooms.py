"""Every file of the chapters has a place, and imports what its place may import."""

import ast
import re
from dataclasses import dataclass, field
from pathlib import Path

from repro.run.discover import MARKS
from repro.run.source_index import import_aliases

ROOT = Path(__file__).resolve().parents[3]
# File of a page's folder -> files of the same folder that it may import.
MAY_IMPORT = {
    "page": {"scenes", "experiment", "report", "claims", "exercises"},
    "scenes": set(),
    "experiment": {"scenes"},
    "report": {"scenes", "experiment"},
    "claims": {"scenes", "experiment", "report"},
    "exercises": {"scenes", "experiment", "report"},
}
WORDS = ", ".join(MAY_IMPORT)
SHARED = "shared"
GENERATED = re.compile(r"/__pycache__/|/\.ruff_cache/")


@dataclass
class Chapters:
    """The modules below chapters/ of a checkout, and what they import there."""

    root: Path
    edges: dict[str, set[str]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        files = {
            path.relative_to(self.root / "chapters").as_posix(): path
            for path in sorted((self.root / "chapters").rglob("*"))
            if path.is_file() and not GENERATED.search(path.as_posix())
        }
        self.files = files
        self.modules = {self._module(n): n for n in files if n.endswith(".py")}
        for module, name in self.modules.items():
            self.edges[module] = self._imported(module, files[name]) - {module}

    @staticmethod
    def _module(name: str) -> str:
        parts = name.removesuffix(".py").removesuffix("/__init__").split("/")
        return ".".join(["chapters", *parts])

    def _imported(self, module: str, path: Path) -> set[str]:
        package = module if path.name == "__init__.py" else module.rpartition(".")[0]
        found = set()
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.Import):
                found |= {alias.name for alias in node.names} & set(self.modules)
            elif isinstance(node, ast.ImportFrom):
                for home, name in import_aliases(node, package).values():
                    inner = f"{home}.{name}"
                    target = inner if inner in self.modules else home
                    found |= {target} & set(self.modules)
        return found


def refusals(root: Path) -> list[str]:
    """One line for each file without a place, and each import that goes astray."""
    chapters = Chapters(root)
    lines = []
    for name in chapters.files:
        lines += [f"chapters/{name}: {fault}" for fault in misplaced(name)]
    for name in sorted({n.rpartition("/")[0] for n in chapters.files}):
        parts = name.split("/")
        if (
            len(parts) == 2
            and SHARED not in parts
            and f"{name}/page.py" not in (chapters.files)
        ):
            lines.append(f"chapters/{name}: no page.py; every package here is a page")
    for module, targets in chapters.edges.items():
        lines += [
            f"chapters/{chapters.modules[module]}: imports {target}; {fault}"
            for target in sorted(targets)
            for fault in astray(module.split(".")[1:], target.split(".")[1:])
        ]
    return lines + shared_faults(chapters)


def misplaced(name: str) -> list[str]:
    """Why a file, named below chapters/, has no place there."""
    chapter, *rest = name.split("/")
    if not rest or chapter == SHARED:
        return []
    if len(rest) == 1:
        if rest == ["__init__.py"]:
            return []
        return ["a chapter holds packages of pages only; move it into its page's"]
    place = rest[1].removesuffix(".py")
    if rest[-1] == "__init__.py":
        return ["a page's package needs no __init__.py; delete it"]
    if place not in MAY_IMPORT or not rest[-1].endswith(".py"):
        return [f"{place} is not a file of a page; they are {WORDS}"]
    if len(rest) > 2:
        return ["a page's folder has no folders; move it into one of its files"]
    return []


def astray(source: list[str], target: list[str]) -> list[str]:
    """Why a module may not import another one; both are paths below chapters."""
    if len(target) < 2:
        return []
    if target[0] == SHARED:
        return []
    if source[0] == SHARED:
        return ["what is shared knows no page; move what it needs into chapters/shared"]
    if source[:2] != target[:2]:
        return ["pages do not import each other; move it into chapters/shared"]
    mine, other = source[2], target[2]
    if other == "page":
        return [
            "nothing imports a page; move what others need into experiment or report"
        ]
    known = mine in MAY_IMPORT and other in MAY_IMPORT
    if known and mine != other and other not in MAY_IMPORT[mine]:
        allowed = ", ".join(sorted(MAY_IMPORT[mine])) or "no other file"
        return [f"{mine} may import {allowed}; move what both need into one of these"]
    return []


def shared_faults(chapters: Chapters) -> list[str]:
    """Shared modules that hold a producer, or that fewer than two pages use."""
    users: dict[str, set[str]] = {}
    for module in chapters.edges:
        parts = module.split(".")
        if len(parts) < 4 or parts[1] == SHARED:
            continue
        seen, todo = set(), [module]
        while todo:
            for other in chapters.edges[todo.pop()] - seen:
                if other.startswith(f"chapters.{SHARED}."):
                    seen.add(other)
                    todo.append(other)
        for other in seen:
            users.setdefault(other, set()).add("/".join(parts[1:3]))
    lines = []
    for module, name in chapters.modules.items():
        if not module.startswith(f"chapters.{SHARED}."):
            continue
        used = sorted(users.get(module, ()))
        if not used and not name.endswith("__init__.py"):
            lines.append(f"chapters/{name}: used by no page; delete it")
        if len(used) == 1:
            lines.append(f"chapters/{name}: used by {used[0]} alone; move it there")
        lines += [
            f"chapters/{name}:{line}: marks a producer; producers stand in pages"
            for line in marks(chapters.files[name])
        ]
    return lines


def marks(path: Path) -> list[int]:
    """Lines of the decorators in a file that mark a producer."""
    return [
        call.lineno
        for node in ast.walk(ast.parse(path.read_text("utf-8")))
        if isinstance(node, ast.FunctionDef)
        for call in node.decorator_list
        if isinstance(call, ast.Call) and getattr(call.func, "id", "") in MARKS
    ]


def test_chapter_files_and_imports_are_valid():
    found = refusals(ROOT)
    assert not found, "\n" + "\n".join(found)
