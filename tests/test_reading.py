"""What becomes of a page when it has been read: entries of the search, imports last."""

from docutils import nodes
from docutils.utils import new_document
from sphinx import addnodes

from repro.page.folding import IMPORTS_TAG
from repro.site.reading import add_entries, imports_last


def a_page():
    """A document: title, imports, a paragraph, and a section with a cell."""
    page, top, below = new_document("page"), nodes.section(), nodes.section()
    imports = nodes.container(classes=["cell", f"tag_{IMPORTS_TAG}"])
    top += [nodes.title(text="Page"), imports, nodes.paragraph(), below]
    below += nodes.container(classes=["cell"])
    page += top
    return page, imports


def test_imports_stand_last_on_the_page():
    page, imports = a_page()
    imports_last(page)
    assert page[0][-1] is imports
    kinds = [type(node).__name__ for node in page[0]]
    assert kinds == ["title", "paragraph", "section", "container"]


def test_the_search_finds_an_artefact_by_its_number_as_people_type_it():
    page, _ = a_page()
    add_entries(page, ["fig_4_6", "table_4_3"])
    (index,) = page.findall(addnodes.index)
    found = {entry[1]: entry[2:4] for entry in index["entries"]}
    assert found["Table 4.3"] == ("table_4_3", "main")
    assert {"Fig. 4.6", "Fig 4.6", "Figure 4.6"} < found.keys()
    page, _ = a_page()
    add_entries(page, [])
    assert not list(page.findall(addnodes.index))
