"""The rooms of the book-keeping: imports go down, and none goes in a circle."""

import ast
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

from repro.run.source_index import import_aliases

LIB = Path(__file__).resolve().parents[1] / "lib"
# From low to high: a room imports itself and the rooms before it.
ROOMS = ("judge", "run", "page", "site", "workflow")
FILES = {
    ".".join(path.relative_to(LIB).with_suffix("").parts): path
    for path in sorted((LIB / "repro").glob("*/*.py"))
    if path.name != "__init__.py"
}


def imported(name: str, path: Path) -> set[str]:
    """Modules of the rooms that a file imports, inside functions too.

    What stands under TYPE_CHECKING only names types, and is not imported.
    """
    package = name.rpartition(".")[0]
    found, todo = set(), [ast.parse(path.read_text("utf-8"))]
    while todo:
        node = todo.pop()
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            continue
        if isinstance(node, ast.Import | ast.ImportFrom):
            for module, attribute in import_aliases(node, package).values():
                found |= {module, f"{module}.{attribute}"} & set(FILES)
        todo += ast.iter_child_nodes(node)
    return found - {name}


EDGES = {name: imported(name, path) for name, path in FILES.items()}


def room(name: str) -> int:
    return ROOMS.index(name.split(".")[1])


def test_every_folder_is_a_room_and_modules_import_each_other():
    assert {name.split(".")[1] for name in FILES} == set(ROOMS)
    assert sum(map(len, EDGES.values())) > 50


@pytest.mark.parametrize("name", FILES)
def test_no_import_goes_up(name):
    up = [other for other in EDGES[name] if room(other) > room(name)]
    assert not up, f"{name} imports {', '.join(up)}, of a higher room"


def test_no_imports_go_in_a_circle():
    TopologicalSorter(EDGES).prepare()


def test_nothing_imports_the_command_line():
    assert not [n for n, path in FILES.items() if "repro.__main__" in path.read_text()]
