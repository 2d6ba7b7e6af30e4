"""The tree of pages loses sections, never pages or titles."""

from docutils import nodes
from sphinx import addnodes

from repro.site.each_page import without_sections


def entry(title, *below):
    link = nodes.reference("", title, refuri=title, anchorname="")
    return nodes.list_item("", addnodes.compact_paragraph("", "", link), *below)


def test_sections_go_and_pages_stay():
    pages = addnodes.toctree(entries=[(None, "a"), (None, "b")])
    section = entry("section", nodes.bullet_list("", entry("inner"), pages))
    contents = nodes.bullet_list("", entry("page", nodes.bullet_list("", section)))
    short = without_sections(contents)
    assert [link.astext() for link in short.findall(nodes.reference)] == ["page"]
    (kept,) = short.findall(addnodes.toctree)
    assert kept["entries"] == pages["entries"]
    assert "inner" in contents.astext()


def test_a_page_without_pages_below_keeps_its_title_alone():
    contents = nodes.bullet_list(
        "", entry("page", nodes.bullet_list("", entry("section"))), entry("other")
    )
    short = without_sections(contents)
    assert [len(one) for one in short] == [1, 1]
    assert short.astext().split() == ["page", "other"]
