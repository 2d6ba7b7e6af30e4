"""A class of the library has a name of its own: one name, one meaning."""

import ast
from pathlib import Path

LIBRARY = Path(__file__).parents[1] / "lib" / "raxel"


def test_no_two_classes_of_the_library_share_a_name():
    places = {}
    for path in sorted(LIBRARY.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.ClassDef):
                place = f"{path.relative_to(LIBRARY)}:{node.lineno}"
                places.setdefault(node.name, []).append(place)
    assert len(places) > 100
    assert {name: where for name, where in places.items() if len(where) > 1} == {}
