"""A class has a name of its own in the whole tree: one name, one meaning."""

import ast
from pathlib import Path

ROOT = Path(__file__).parents[2]
CODE = sorted([*ROOT.glob("lib/**/*.py"), *ROOT.glob("chapters/**/*.py")])


def test_class_names_are_unique():
    places = {}
    for path in CODE:
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.ClassDef):
                place = f"{path.relative_to(ROOT)}:{node.lineno}"
                places.setdefault(node.name, []).append(place)
    assert len(places) > 100
    assert {name: where for name, where in places.items() if len(where) > 1} == {}
