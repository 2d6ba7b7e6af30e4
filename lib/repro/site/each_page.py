"""What Sphinx works out anew for each page of the site, worked out once.

A Sphinx extension. The tree of all pages stands beside each of them: for it Sphinx
copies all their sections, to leave them out then. Here they are left out before. And
words that pages share are stemmed once for the search. The site is the same.
"""

from __future__ import annotations

from functools import cache

from docutils import nodes
from sphinx import addnodes

BEFORE_FURO = 400
"""A priority: the theme asks for the tree at the usual one, 500."""


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


def _on_page(app, name: str, template: str, context: dict, doctree) -> None:
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


@cache
def _titles(environment) -> dict[str, nodes.bullet_list]:
    """Of every page; once all are read, none of them changes any more."""
    return {n: without_sections(c) for n, c in environment.tocs.items()}


def setup(app) -> dict:
    """Connect the handler."""
    app.connect("html-page-context", _on_page, priority=BEFORE_FURO)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
