"""The library's reference: pages of what packages export, and docstrings as text."""

import importlib
import re

from repro.site import source_pages
from repro.site.library import as_rst, library_pages, source_of
from tests.small_checkouts import ROOT

SOURCE = """class Line:
    @property
    def length(self):
        pass

    @length.setter
    def length(self, value):
        pass


def plain():
    pass

# 1 < 2
"""


def test_packages_have_reference_pages():
    pages = library_pages(ROOT / "lib" / "raxel")
    listed = re.findall(r"automodule:: (\S+)", "".join(pages.values()))
    assert {"raxel.errors", "raxel.cameras", "raxel.calibration"} <= set(listed)
    # One page for each package with public names: 15, and the errors.
    assert len(listed) == len(set(listed)) == 16
    for name in listed:
        importlib.import_module(name)
    names = re.findall(r"^   (\S+)$", pages["api/index.rst"], re.MULTILINE)
    assert {f"api/{name}.rst" for name in names} == set(pages) - {"api/index.rst"}


def test_docstring_becomes_text_with_code():
    assert as_rst(["a_b *c* `d_e` ``f*g`` |h|"]) == [
        r"a\_b \*c\* \ ``d_e``\  \ ``f*g``\  \|h\|",
        "",
    ]
    aligned = as_rst(["Table:", "  a  one", "  b  *", "", "- x", "  y"])
    assert aligned == [
        "::",
        "",
        "    Table:",
        "      a  one",
        "      b  *",
        "",
        "- x",
        "  y",
        "",
    ]
    given = as_rst(["Parameters", "----------", "x : one", "    more", "y : two"])
    assert given == ["**Parameters**", "", "- x : one", "  more", "- y : two", ""]
    example = as_rst(["Examples", "--------", ">>> 1 * 2", "2"])
    assert example == ["**Examples**", "", "::", "", "    >>> 1 * 2", "    2", ""]


def test_name_links_to_definition():
    def address(name):
        return source_of("py", {"module": "raxel.cameras", "fullname": name})

    importlib.import_module("raxel.cameras")
    own = "../source/raxel/cameras/lenses/perspective.py.html#PerspectiveCamera"
    assert address("PerspectiveCamera") == own
    assert address("PerspectiveCamera.save").endswith(".py.html#Camera.save")
    assert address("no_such_name") is None


def test_source_page_has_anchors(tmp_path):
    path = tmp_path / "lines.py"
    path.write_text(SOURCE)
    page = source_pages.source_page(path, "raxel/rays/lines.py", "../../../")
    ids = re.findall(r'id="([^"]+)"', page)
    assert {"Line", "Line.length", "plain"} <= set(ids)
    assert len(ids) == len(set(ids))
    assert 'href="../../../index.html"' in page
    assert "# 1 &lt; 2" in page
