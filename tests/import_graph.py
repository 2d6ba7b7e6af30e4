"""Which module imports which, read from the sources; nothing is run.

Every import counts, also one inside a function or under TYPE_CHECKING: a name that is
only wanted for a type still says who knows whom.
"""

import ast
import graphlib
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple


class Arrow(NamedTuple):
    """`importer` imports `imported`; `place` is file:line."""

    importer: str
    imported: str
    place: str

    def __str__(self):
        return f"{self.place}: {self.importer} imports {self.imported}"


def modules_below(root, packages):
    """{dotted name: path} of the modules of packages (folders below `root`).

    A package's own name stands for its __init__.py.
    """
    found = {}
    for package in packages:
        folder = root / package
        for path in sorted(folder.rglob("*.py")):
            parts = path.relative_to(folder.parent).with_suffix("").parts
            found[".".join(parts).removesuffix(".__init__")] = path
    return found


def arrows_between(modules, root):
    """The Arrows among these modules, once for each place."""
    found = {}
    for name, path in modules.items():
        package = name if path.name == "__init__.py" else name.rpartition(".")[0]
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            for wanted in _wanted(node, package):
                imported = _nearest(wanted, modules)
                if imported and imported != name:
                    place = f"{path.relative_to(root).as_posix()}:{node.lineno}"
                    found[Arrow(name, imported, place)] = None
    return list(found)


def circle_in(arrows):
    """The Arrows of one circle, in order; [] without one."""
    imports = {}
    for arrow in arrows:
        imports.setdefault(arrow.importer, {}).setdefault(arrow.imported, arrow)
    try:
        graphlib.TopologicalSorter(imports).prepare()
    except graphlib.CycleError as error:
        # graphlib goes round from the imported to the importer.
        circle = error.args[1][::-1]
        return [imports[importer][imported] for importer, imported in pairwise(circle)]
    return []


def inside(name, package):
    """Whether a module is the package or lies in it."""
    return name == package or name.startswith(f"{package}.")


def _wanted(node, package):
    """Dotted names that a statement imports: of `from a import b` that is a.b."""
    if isinstance(node, ast.Import):
        return [alias.name for alias in node.names]
    if not isinstance(node, ast.ImportFrom):
        return []
    source = node.module or ""
    if node.level:
        above = package.split(".")[: len(package.split(".")) - node.level + 1]
        source = ".".join([*above, *filter(None, [source])])
    return [f"{source}.{alias.name}" for alias in node.names]


def _nearest(wanted, modules):
    """The module that holds a dotted name, or None: a.b.c, else a.b, else a."""
    while wanted and wanted not in modules:
        wanted = wanted.rpartition(".")[0]
    return wanted or None


@cache
def checkout():
    """(modules of the checkout, their Arrows)."""
    root = Path(__file__).parents[1]
    modules = modules_below(root, ("lib/raxel", "lib/repro", "chapters"))
    return modules, arrows_between(modules, root)
