"""The key of a function changes with what it reaches, and with nothing else."""

from pathlib import Path

import pytest

from repro.run.reach import Reach

FILES = {
    "chapters/__init__.py": "",
    "chapters/one/__init__.py": "",
    "chapters/one/page.py": """
        import numpy as np
        from raxel.shapes import area
        from raxel import shapes
        import raxel.lines as lines
        from repro.run.experiment import figure

        SIDE = 3
        UNUSED = 4

        def trial(condition, rng):
            "Docstring."
            return {"area": area(SIDE), "random": rng.normal()}

        def by_module(x):
            return shapes.area(x)

        def by_submodule(x):
            return lines.length(x)

        def inside(x):
            from raxel.lines import length as measure
            return measure(x)

        @figure("fig_1", needs=("a",), evidence="synthetic")
        def drawn(results):
            return np.sum(results)
        """,
    "lib/raxel/__init__.py": "",
    "lib/raxel/shapes/__init__.py": "from raxel.shapes.flat import area, circle",
    "lib/raxel/shapes/flat.py": """
        from .numbers import square
        TABLE = {}
        TABLE["pi"] = 3

        def area(side):
            # a comment
            return square(side)

        def circle(radius):
            return TABLE["pi"] * square(radius)
        """,
    "lib/raxel/shapes/numbers.py": """
        def square(x):
            return x * x

        def cube(x):
            return x * square(x)
        """,
    "lib/raxel/lines.py": "def length(x):\n    return abs(x)\n",
    "environment.txt": "numpy==2.0.0 \\\n    --hash=sha256:0\nscipy==1.0.0 \\\n",
}
PAGE = "chapters.one.page"


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    from textwrap import dedent

    for name, text in FILES.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(dedent(text))
    return tmp_path


def changed(checkout: Path, name: str, old: str, new: str) -> set[str]:
    """Functions of the page whose key moves when ``old`` becomes ``new``."""
    functions = ("trial", "by_module", "by_submodule", "inside", "drawn")
    before = {f: Reach(checkout).key((PAGE, f)) for f in functions}
    path = checkout / name
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, new))
    return {f for f in functions if Reach(checkout).key((PAGE, f)) != before[f]}


@pytest.mark.parametrize(
    ("name", "old", "new", "moved"),
    [
        ("lib/raxel/shapes/numbers.py", "x * x", "x ** 2", {"trial", "by_module"}),
        ("lib/raxel/shapes/numbers.py", "x * square(x)", "x ** 3", set()),
        ("lib/raxel/lines.py", "abs(x)", "-x", {"by_submodule", "inside"}),
        ("chapters/one/page.py", "SIDE = 3", "SIDE = 5", {"trial"}),
        ("chapters/one/page.py", "UNUSED = 4", "UNUSED = 5", set()),
        ("chapters/one/page.py", "Docstring.", "Another.", set()),
        ("lib/raxel/shapes/flat.py", "# a comment", "# another", set()),
        ("lib/raxel/shapes/flat.py", "area(side)", "area(side: float)", set()),
        ("lib/raxel/shapes/flat.py", '["pi"] = 3', '["pi"] = 4', set()),
        ("chapters/one/page.py", 'evidence="synthetic"', 'evidence="x"', set()),
        ("environment.txt", "numpy==2.0.0", "numpy==2.0.1", {"drawn"}),
        ("environment.txt", "scipy==1.0.0", "scipy==1.0.1", set()),
    ],
)
def test_only_what_reaches_a_change_gets_another_key(checkout, name, old, new, moved):
    assert changed(checkout, name, old, new) == moved


def test_a_table_filled_after_its_definition_belongs_to_it(checkout):
    key = Reach(checkout).key(("raxel.shapes", "circle"))
    path = checkout / "lib/raxel/shapes/flat.py"
    path.write_text(path.read_text().replace('["pi"] = 3', '["pi"] = 4'))
    assert Reach(checkout).key(("raxel.shapes", "circle")) != key


def test_parts_name_the_definition_that_changed(checkout):
    before = Reach(checkout).parts((PAGE, "trial"))
    path = checkout / "lib/raxel/shapes/numbers.py"
    path.write_text(path.read_text().replace("x * x", "x ** 2"))
    after = Reach(checkout).parts((PAGE, "trial"))
    differing = {name for name, _ in before.items() ^ after.items()}
    assert differing == {"raxel.shapes.numbers:square"}


def test_reached_are_definitions_with_their_places_the_nearest_first(checkout):
    reach = Reach(checkout)
    reached = reach.reached((PAGE, "trial"))
    assert reached[0] == (PAGE, "trial")
    assert set(reached[1:3]) == {(PAGE, "SIDE"), ("raxel.shapes.flat", "area")}
    assert reached[3:] == [("raxel.shapes.numbers", "square")]
    path, line = reach.place("raxel.shapes.flat", "area")
    assert path.read_text().splitlines()[line - 1] == "def area(side):"
    with pytest.raises(LookupError, match=r"raxel\.shapes defines no area"):
        reach.place("raxel.shapes", "area")


def test_every_experiment_of_the_checkout_reaches_the_library():
    from repro.run.discover import producers

    root = Path(__file__).resolve().parents[1]
    reach = Reach(root)
    experiments = [p for p in producers(root) if p.kind == "experiment"]
    assert experiments
    for found in experiments:
        parts = reach.parts((found.module, found.function))
        assert any(name.startswith("raxel.") for name in parts), found.id
        assert not any(name.startswith("repro.judge.ledger") for name in parts), (
            found.id
        )
