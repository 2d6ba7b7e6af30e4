"""The library's reference: what is public stands in it, as it is written."""

import ast
import re
from pathlib import Path

from repro.site import source_pages
from repro.site.api_reference import api_pages, escaped, prose

ROOT = Path(__file__).resolve().parents[1]
LIBRARY = ROOT / "lib" / "raxel"
SAMPLE = '''"""Lines."""

LIMIT = 3


class Line(Base):
    """A line through *two* points."""

    places: int
    _kept: int

    def __init__(self, a, b=None):
        self._a = a

    @property
    def length(self) -> float:
        """Its length, mm."""

    @length.setter
    def length(self, value):
        """Set it."""

    @classmethod
    def through(
        cls, first, second, *, tolerance_of_the_fit=1e-9, largest_number_of_points=None
    ):
        """A line through points."""

    def _hidden(self):
        """Nobody reads this."""


def plain(x, *rest, **more):
    """Plain."""


def _private():
    """Nobody reads this."""
'''


def sample(tmp_path) -> str:
    """The page of a package with one module."""
    package = tmp_path / "raxel" / "rays"
    package.mkdir(parents=True)
    (tmp_path / "raxel" / "__init__.py").write_text('"""A library."""\n')
    (package / "__init__.py").write_text(
        '"""Rays."""\nfrom raxel.rays.lines import Line\n__all__ = ["Line"]\n'
    )
    (package / "lines.py").write_text(SAMPLE)
    (package / "_inner.py").write_text('def inner():\n    """Nobody reads this."""\n')
    pages = api_pages(tmp_path / "raxel")
    assert sorted(pages) == ["api/index.md", "api/rays.md"]
    return pages["api/rays.md"]


def test_a_page_shows_signatures_as_they_are_written(tmp_path):
    page = sample(tmp_path)
    assert "class Line(Base)\n    places: int\nLine(a, b=None)\n" in page
    assert "Line.length -> float  # property\n" in page
    assert "plain(x, *rest, **more)\n" in page
    long = (
        "@classmethod\nLine.through(\n    first,\n    second,\n    *,\n"
        "    tolerance_of_the_fit=1e-09,\n    largest_number_of_points=None,\n)\n"
    )
    assert long in page
    assert r"through \*two\* points" in page
    assert '<a href="#raxel.rays.lines.Line"><code>Line</code></a>' in page
    assert '<span id="raxel.rays.lines.Line"></span>' in page
    assert "../source/raxel/rays/lines.py.html#Line" in page
    assert "Nobody reads this" not in page
    assert "Set it" not in page


def test_a_name_is_linked_to_the_room_that_defines_it(tmp_path):
    room = tmp_path / "raxel" / "rays" / "straight"
    room.mkdir(parents=True)
    (tmp_path / "raxel" / "__init__.py").write_text('"""A library."""\n')
    (room.parent / "__init__.py").write_text(
        "from math import pi\nfrom raxel.rays.straight import Line\n"
        '__all__ = ["Line", "pi"]\n'
    )
    (room / "__init__.py").write_text("from raxel.rays.straight.lines import Line\n")
    (room / "lines.py").write_text(SAMPLE)
    (room / "another.py").write_text('class Line:\n    """Not this one."""\n')
    page = api_pages(tmp_path / "raxel")["api/rays.md"]
    (address,) = re.findall(r'<a href="(.*)"><code>', page)
    assert address == "rays-straight.html#raxel.rays.straight.lines.Line"


def test_a_docstring_is_text_with_code_in_it():
    assert escaped("a_b `c_d` ``e*f`` [g](h) $1 | <i>") == (
        r"a\_b `c_d` `e*f` \[g\](h) \$1 \| \<i\>"
    )
    assert escaped("r^2 + J^T, Q^1_j, x^10") == r"r² + Jᵀ, Q¹\_j, x\^10"
    assert prose("One.\n\n    code = 1\n\n- a\n- b") == (
        "One.\n\n````text\ncode = 1\n````\n\n- a\n- b"
    )
    assert prose("Table:\n  a  one\n  b  two").startswith("````text\nTable:")


def test_everything_public_of_the_library_is_in_the_reference():
    by_name = api_pages(LIBRARY)
    for name, page in by_name.items():
        for address in re.findall(r'<a href="([^"#]*)#[^"]*"><code>', page):
            named = address.replace(".html", ".md") or name.removeprefix("api/")
            assert f"api/{named}" in by_name, (name, address)
    pages = "\n".join(by_name.values())
    listed = set(re.findall(r'<span id="(raxel\.[\w.]+)">', pages))
    linked = re.findall(r'<a href="[^"]*#(raxel\.[\w.]+)"><code>', pages)
    assert set(linked) <= listed
    assert len(listed) > 60
    for path in LIBRARY.rglob("*.py"):
        name = ".".join(path.relative_to(LIBRARY.parent).with_suffix("").parts)
        name = name.removesuffix(".__init__")
        command = path.parent.name == "cli" and path.name != "__init__.py"
        if path.name == "__main__.py" or command:
            assert f"{name}." not in pages
            continue
        for node in ast.parse(path.read_text("utf-8")).body:
            if isinstance(node, ast.FunctionDef | ast.ClassDef):
                public = not node.name.startswith("_")
                assert (f"{name}.{node.name}" in listed) is public, node.name


def test_a_source_page_has_an_anchor_for_every_name(tmp_path):
    path = tmp_path / "lines.py"
    path.write_text(SAMPLE + "\n# 1 < 2\n")
    page = source_pages.source_page(path, "raxel/rays/lines.py", "../../../")
    names = ("Line", "Line.length", "Line._hidden", "plain", "_private")
    for name in names:
        assert page.count(f'id="{name}"') == 1, name
    assert 'href="../../../index.html"' in page
    assert "# 1 &lt; 2" in page
    ids = re.findall(r'id="([^"]+)"', page)
    assert len(ids) == len(set(ids))
