"""The key of a function changes with what it reaches, and with nothing else."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from repro.run.reach import Reach
from tests.sample_files import write

FILES = {
    "chapters/__init__.py": "",
    "chapters/one/__init__.py": "",
    "chapters/one/page.py": """
        import numpy as np
        from raxel.shapes import area
        from raxel import shapes
        import raxel.lines as lines
        from repro.run.marks import figure

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
    "lib/raxel/shapes/__init__.py": """
        import lazy_loader

        __getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
        """,
    "lib/raxel/shapes/__init__.pyi": "from .flat import area as area, circle as circle",
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
        write(tmp_path / name, dedent(text))
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
def test_key_changes_only_for_reached_code(checkout, name, old, new, moved):
    assert changed(checkout, name, old, new) == moved


MORE = """
    import sys
    from pathlib import Path
    from raxel.shapes import flat
    from raxel.shapes.flat import area, circle
    from raxel.shapes.numbers import cube, square

    LOW, HIGH = 1, 2
    HERE = Path(__file__).parent
    if sys.platform == "linux":
        STEP = 1
    else:
        STEP = 2

    class Box:
        def __init__(self, side):
            self.side = side

        def area(self):
            return area(self.side)

    def boxed(x):
        return Box(x).area()

    def between(x):
        return LOW <= x < HIGH

    def shadowed(x, square):
        return [cube(y) for y in square]

    def hidden(x, circle):
        return flat.circle(x)

    def stepped(x):
        return x + STEP

    def even(x):
        return x == 0 or odd(x - 1)

    def odd(x):
        return x != 0 and even(x - 1)

    def nearby(x):
        return HERE / x

    def called(x):
        return circle.__name__

    def indirect(x):
        import raxel.shapes.flat as shape
        return getattr(shape, "circle")(x)
"""
OF_PROJECT = ("=.chapters.", "=.raxel.", "=.repro.")
OF_MORE = (
    "boxed", "between", "shadowed", "hidden", "stepped",
    "even", "odd", "nearby", "called", "indirect",
)  # fmt: skip


@pytest.fixture
def more(checkout: Path) -> Path:
    """The module `raxel.more` of the checkout."""
    from textwrap import dedent

    path = checkout / "lib/raxel/more.py"
    path.write_text(dedent(MORE))
    return path


def keys_of_more(checkout: Path, module: str = "raxel.more") -> dict[str, str]:
    return {f: Reach(checkout).key((module, f)) for f in OF_MORE}


def differing(before: dict[str, str], after: dict[str, str]) -> set[str]:
    return {name for name in before if before[name] != after[name]}


@pytest.mark.parametrize(
    ("old", "new", "moved"),
    [
        ("area(self.side)", "2 * area(self.side)", {"boxed"}),
        ("class Box", "class Case", {"boxed"}),
        ("LOW, HIGH = 1, 2", "HIGH, LOW = 1, 2", {"between"}),
        ("LOW, HIGH = 1, 2", "LOW, HIGH = 1, 3", {"between"}),
        ("LOW <= x < HIGH", "HIGH <= x < LOW", {"between"}),
        ("cube(y) for", "square(y) for", {"shadowed"}),
        ("cube(y) for y in square", "cube(square) for square in y", {"shadowed"}),
        ("flat.circle(x)", "circle(x)", {"hidden"}),
        ('"linux"', '"win32"', {"stepped"}),
        ("x == 0 or odd", "x <= 0 or odd", {"even", "odd"}),
        ("circle.__name__", "area.__name__", {"called"}),
        ("LOW, HIGH = 1, 2", "LOW, HIGH = 1, 2\nsquare.limit = LOW", set(OF_MORE)),
        ("LOW, HIGH = 1, 2", "LOW, HIGH = 1, 2\nprint(LOW)", set(OF_MORE)),
    ],
)
def test_key_covers_meaning_of_names(checkout, more, old, new, moved):
    before = keys_of_more(checkout)
    text = more.read_text()
    assert old in text
    renamed = text.replace(old, new)
    if old.startswith("class"):
        renamed = renamed.replace("Box", "Case")
    more.write_text(renamed)
    assert differing(before, keys_of_more(checkout)) == moved


def test_keys_distinguish_cycles(checkout, more):
    before = keys_of_more(checkout)
    assert before["even"] != before["odd"]
    more.write_text(more.read_text().replace("even", "straight").replace("odd", "bent"))
    assert Reach(checkout).key(("raxel.more", "straight")) == before["even"]
    assert Reach(checkout).key(("raxel.more", "bent")) == before["odd"]


def test_moving_module_keeps_keys(checkout, more):
    """But for code that asks where it stands, or what a function is called."""
    before = {f: Reach(checkout).key((PAGE, f)) for f in ("trial", "by_module")}
    of_more = keys_of_more(checkout)
    shapes = checkout / "lib/raxel/shapes"
    shapes.rename(checkout / "lib/raxel/figures")
    more.rename(checkout / "lib/raxel/figures/more.py")
    page = checkout / "chapters/two/pages/page.py"
    page.parent.mkdir(parents=True)
    (checkout / "chapters/one/page.py").rename(page)
    for path in checkout.rglob("*.py"):
        text = path.read_text().replace("raxel.shapes", "raxel.figures")
        text = text.replace("import shapes", "import figures as shapes")
        path.write_text(text)
    reach = Reach(checkout)
    after = {f: reach.key(("chapters.two.pages.page", f)) for f in before}
    assert after == before
    moved = keys_of_more(checkout, "raxel.figures.more")
    assert differing(of_more, moved) == {"nearby", "called"}


def test_renaming_keeps_keys(checkout, more):
    before = keys_of_more(checkout)
    flat = checkout / "lib/raxel/shapes/flat.py"
    numbers = flat.with_name("numbers.py")
    numbers.write_text(numbers.read_text().replace("square(", "second_power("))
    flat.write_text(flat.read_text().replace("square", "second_power"))
    text = more.read_text().replace(
        "import cube, square", "import cube as third, second_power as square"
    )
    text = text.replace("cube(y)", "third(y)").replace("LOW", "LEAST")
    more.write_text(text.replace("STEP", "STRIDE").replace("HERE", "HOME"))
    # Code may read the names of a module that is passed as an object.
    assert differing(before, keys_of_more(checkout)) == {"called"}
    flat.write_text(flat.read_text().replace("def area", "def surface"))
    assert "indirect" in differing(before, keys_of_more(checkout))


def test_keys_are_reproducible(checkout, more):
    program = (
        "from pathlib import Path; from repro.run.reach import Reach; "
        f"print([Reach(Path.cwd()).key(('raxel.more', f)) for f in {OF_MORE}])"
    )
    output = set()
    for seed in "01234":
        shutil.rmtree(checkout / ".cache", ignore_errors=True)
        done = subprocess.run(
            [sys.executable, "-c", program],
            env={**os.environ, "PYTHONHASHSEED": seed},
            cwd=checkout, capture_output=True, text=True, check=True,
        )  # fmt: skip
        output.add(done.stdout)
    assert output == {f"{list(keys_of_more(checkout).values())}\n"}


def test_key_covers_later_item_assignment(checkout):
    key = Reach(checkout).key(("raxel.shapes", "circle"))
    path = checkout / "lib/raxel/shapes/flat.py"
    path.write_text(path.read_text().replace('["pi"] = 3', '["pi"] = 4'))
    assert Reach(checkout).key(("raxel.shapes", "circle")) != key


def test_reached_lists_nearest_definitions_first(checkout):
    reach = Reach(checkout)
    reached = reach.reached((PAGE, "trial"))
    assert reached[0] == (PAGE, "trial")
    assert set(reached[1:3]) == {(PAGE, "SIDE"), ("raxel.shapes.flat", "area")}
    assert reached[3:] == [("raxel.shapes.numbers", "square")]
    path, line = reach.place("raxel.shapes.flat", "area")
    assert path.read_text().splitlines()[line - 1] == "def area(side):"
    with pytest.raises(LookupError, match=r"raxel\.shapes: no definition of area"):
        reach.place("raxel.shapes", "area")


def test_reach_finds_all_project_names():
    from repro.run.discover import producers

    root = Path(__file__).resolve().parents[3]
    reach = Reach(root)
    made = [(p.module, p.function) for p in producers(root)]
    reached = reach.reached(*made)
    assert len(reached) > 3 * len(made)
    outside = [w for p in reached for w, to in reach._node(p).links if to is None]
    lost = [word for word in outside if word.startswith(OF_PROJECT)]
    assert not lost
    unpinned = {
        word.split("=.")[1].split(".")[0] for word in outside if " " not in word
    }
    assert unpinned <= sys.stdlib_module_names


def test_experiments_reach_library():
    from repro.run.discover import producers

    root = Path(__file__).resolve().parents[3]
    reach = Reach(root)
    experiments = [p for p in producers(root) if p.kind == "experiment"]
    assert experiments
    for found in experiments:
        modules = {name for name, _ in reach.reached((found.module, found.function))}
        assert any(name.startswith("raxel.") for name in modules), found.id
        assert "repro.judge.ledger" not in modules, found.id
