"""Codes become links when the pages are assembled: E-2.10, `c2_crossover`.

A Sphinx extension. `site.json` has the target of each code: those of the errata, and
ids of the ledger with an underscore, which are unambiguous. Codes are replaced in
Markdown and in HTML within it, in text and in code that consists of an id only. Links,
headings and longer pieces of code do not change.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from html import escape, unescape
from pathlib import Path

from docutils import nodes

CODE = re.compile(
    r"\bE-[0-9A-Z]+\.[0-9]+\b"
    # An id that is not part of a file's name, a path or a call.
    r"|(?<![\w./-])[A-Za-z][A-Za-z0-9]*_\w+\b(?![/(=]|\.\w)"
)
# Pieces of HTML: a whole element in which nothing is replaced, a tag, or text.
PIECES = re.compile(
    r"(?P<code><code>(?P<id>[\w<>]+)</code>)"
    r"|(?P<kept><(?P<name>a|pre|script|style|h\d|code|select|title)\b.*?</(?P=name)>)"
    r"|(?P<tag><[^>]*>)|(?P<text>[^<]+)",
    re.S,
)
OPENED, CLOSED = re.compile(r"<(?:a|code)\b"), re.compile(r"</(?:a|code)>")
KEPT = (
    nodes.literal, nodes.reference, nodes.title, nodes.literal_block, nodes.math,
    nodes.raw,
)  # fmt: skip


def link_codes(doctree: nodes.document, known: Mapping[str, str], up: str) -> None:
    """Replace the codes of a page by links; ``up`` is the path to the top of the site.

    ``known`` : code -> address from the top.
    """
    for text in list(doctree.findall(nodes.Text)):
        if not CODE.search(text) or _inside(text, *KEPT):
            continue
        # Found by identity: another node may have an equal text.
        place = next(k for k, one in enumerate(text.parent) if one is text)
        if not _in_tag(text.parent[:place]):
            text.parent[place : place + 1] = _linked(text, known, up)
    for code in list(doctree.findall(nodes.literal)):
        address = known.get(code.astext())
        if address and not _inside(code, nodes.reference, nodes.title):
            code.parent.replace(code, _link(up + address, code))
    for raw in doctree.findall(nodes.raw):
        if raw["format"] == "html":
            raw[:] = [nodes.Text(linked_html(raw.astext(), known, up))]


def linked_html(html: str, known: Mapping[str, str], up: str) -> str:
    """The same for a piece of HTML."""

    def anchor(address: str, text: str) -> str:
        return f'<a href="{escape(up + address)}">{text}</a>'

    def replaced(piece: re.Match) -> str:
        whole = piece[0]
        if piece["code"]:
            address = known.get(unescape(piece["id"].replace("<wbr>", "")))
            return anchor(address, whole) if address else whole
        if piece["text"]:
            return CODE.sub(
                lambda m: anchor(known[m[0]], m[0]) if m[0] in known else m[0], whole
            )
        return whole

    return PIECES.sub(replaced, html)


def _inside(node: nodes.Node, *kinds: type) -> bool:
    while node.parent is not None:
        node = node.parent
        if isinstance(node, kinds):
            return True
    return False


def _in_tag(before: list[nodes.Node]) -> bool:
    """Whether a link or code element is open; Markdown has each tag as HTML."""
    tags = "".join(node.astext() for node in before if isinstance(node, nodes.raw))
    return len(OPENED.findall(tags)) > len(CLOSED.findall(tags))


def _linked(text: nodes.Text, known: Mapping[str, str], up: str) -> list[nodes.Node]:
    """Text in pieces, those that are a known code as links."""
    pieces, end = [], 0
    for found in CODE.finditer(text):
        if found[0] in known:
            pieces.append(nodes.Text(text[end : found.start()]))
            pieces.append(_link(up + known[found[0]], nodes.Text(found[0])))
            end = found.end()
    return [*pieces, nodes.Text(text[end:])]


def _link(address: str, content: nodes.Node) -> nodes.reference:
    link = nodes.reference(refuri=address, internal=True)
    link += content.deepcopy()
    return link


def _on_page(app, doctree: nodes.document) -> None:
    up = "../" * app.env.docname.count("/")
    link_codes(doctree, app.config.raxel_codes, up)


def setup(app) -> dict:
    """Read the codes of the site; a page is read again when they or this file
    change."""
    site = json.loads((Path(app.srcdir) / "site.json").read_text("utf-8"))
    app.add_config_value("raxel_codes", site["codes"], "env")
    app.add_config_value("raxel_codes_file", Path(__file__).read_text("utf-8"), "env")
    app.connect("doctree-read", _on_page)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
