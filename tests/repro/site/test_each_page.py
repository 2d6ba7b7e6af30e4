"""The tree of pages loses sections alone; a link to a page has its first sentence."""

from docutils import nodes
from docutils.utils import new_document
from sphinx import addnodes

from repro.site.each_page import first_sentence, without_sections


def entry(title, *below):
    link = nodes.reference("", title, refuri=title, anchorname="")
    return nodes.list_item("", addnodes.compact_paragraph("", "", link), *below)


def test_tree_keeps_pages_without_sections():
    pages = addnodes.toctree(entries=[(None, "a"), (None, "b")])
    section = entry("section", nodes.bullet_list("", entry("inner"), pages))
    contents = nodes.bullet_list("", entry("page", nodes.bullet_list("", section)))
    short = without_sections(contents)
    assert [link.astext() for link in short.findall(nodes.reference)] == ["page"]
    (kept,) = short.findall(addnodes.toctree)
    assert kept["entries"] == pages["entries"]
    assert "inner" in contents.astext()


def test_page_without_subpages_keeps_title():
    contents = nodes.bullet_list(
        "", entry("page", nodes.bullet_list("", entry("section"))), entry("other")
    )
    short = without_sections(contents)
    assert [len(one) for one in short] == [1, 1]
    assert short.astext().split() == ["page", "other"]


def docutils_document(*children):
    document = new_document("page")
    document += children
    return document


def test_first_sentence_omits_lead():
    text = "Question. How wide is\nthe lens, 2.5 mm off axis? It has 183 degrees."
    section = nodes.section("", nodes.title("", "Page"), nodes.paragraph("", text))
    document = docutils_document(section)
    assert first_sentence(document) == "How wide is the lens, 2.5 mm off axis?"
    assert first_sentence(docutils_document()) == ""
