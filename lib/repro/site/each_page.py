"""Cache what Sphinx computes again for each page of the site.

A Sphinx extension. Each page shows the tree of all pages, for which Sphinx copies all
sections and then removes them. Here they are removed before. Words that pages share are
stemmed once for the search, and each name in signatures is looked up once. Links to the
previous and the next page get the first sentence of that page.
"""

from __future__ import annotations

import html
import re
from functools import cache

from docutils import nodes
from sphinx import addnodes

BEFORE_FURO = 400
"""A priority: the theme requests the tree at the default one, 500."""


def without_sections(contents: nodes.bullet_list) -> nodes.bullet_list:
    """A page's table of contents with its title, and the trees of pages below it."""
    short = contents.deepcopy()
    for entry in short.children:
        if len(entry) > 1:
            below = list(entry.findall(addnodes.toctree))
            if below:
                entry[1][:] = below
            else:
                entry.pop(1)
    return short


def first_sentence(document: nodes.document) -> str:
    """The first sentence of a page below its title, without a lead such as Question."""
    paragraphs = (
        node
        for section in document.findall(nodes.section)
        for node in section.children
        if isinstance(node, nodes.paragraph)
    )
    text = next((node.astext() for node in paragraphs), "")
    found = re.match(r"(?:Question\.)?\s*(.+?[.?!])(?=\s|$)", text, re.S)
    return " ".join(found[1].split()) if found else ""


def _on_read(app, document: nodes.document) -> None:
    known = app.env.metadata[app.env.current_document.docname]
    known["first_sentence"] = first_sentence(document)


def _next_to(app, env, added: set, changed: set, removed: set) -> set[str]:
    """Pages that show the first sentence of a changed one."""
    known = env.collect_relations()
    pages = (page for name in changed for page in known.get(name, (None,))[1:])
    return {page for page in pages if page}


def _on_page(app, name: str, template: str, context: dict, doctree) -> None:
    _, *neighbours = app.builder.relations.get(name, (None, None, None))
    for side, other in zip(("prev", "next"), neighbours, strict=True):
        sentence = app.env.metadata[other].get("first_sentence") if other else ""
        if sentence and context.get(side):
            title = context[side]["title"]
            more = f"<small>{html.escape(sentence)}</small>"
            context[side] = context[side] | {"title": f"{title} {more}"}
    whole = context["toctree"]

    def toctree(**asked: object) -> str:
        if not asked.get("titles_only"):
            return whole(**asked)
        contents = app.env.tocs
        app.env.tocs = _titles(app.env)
        try:
            return whole(**asked)
        finally:
            app.env.tocs = contents

    context["toctree"] = toctree
    words = app.builder.indexer.lang
    if "stem" not in vars(words):
        words.stem = cache(words.stem)
        names = app.env.domains.python_domain
        names.find_obj = cache(names.find_obj)


@cache
def _titles(environment) -> dict[str, nodes.bullet_list]:
    """Data of every page; they do not change after all pages are read."""
    return {n: without_sections(c) for n, c in environment.tocs.items()}


def setup(app) -> dict:
    """Connect the handlers."""
    app.connect("doctree-read", _on_read)
    app.connect("env-get-outdated", _next_to)
    app.connect("html-page-context", _on_page, priority=BEFORE_FURO)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
