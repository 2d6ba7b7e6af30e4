"""Check a built site: all links are valid, and nothing is loaded from a host.

A page must work from a folder on a disk without a network. So links are files (a folder
would show a listing), anchors exist, images have alternative texts, and scripts,
styles, fonts and images are part of the site. Links to other sites are allowed.
Addresses and attributes contain no code, which could be injected through names of
images.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from typing import NamedTuple
from urllib.parse import unquote, urlsplit

CSS_URL = re.compile(r"""url\(\s*['"]?([^'")]+)|@import\s+['"]([^'"]+)""")
# Absolute addresses that an inline script fetches.
SCRIPT_LOADS = re.compile(
    r"""(?:fetch\(|import\(?|importScripts\(|\.open\(|\.(?:src|href)\s*=)"""
    r"""\s*["'`]((?:https?:)?//[^"'`]+)"""
)
LOADED = {
    "script": ("src",),
    "img": ("src", "srcset"),
    "source": ("src", "srcset"),
    "iframe": ("src", "data-src"),
    "embed": ("src",),
    "object": ("data",),
    "video": ("src", "poster"),
    "audio": ("src",),
    "track": ("src",),
    "image": ("href", "xlink:href"),
    "use": ("href", "xlink:href"),
    "form": ("action",),
}
CODE = "source"
ID = re.compile(r'\bid="([^"]+)"')
NOT_LOADED = {"canonical", "prev", "next", "author", "license", "index", "search"}


class Reference(NamedTuple):
    """An address in a page: its line, and whether a browser loads it automatically."""

    line: int
    address: str
    loaded: bool


class Problem(NamedTuple):
    """A problem and its position."""

    file: str
    line: int
    text: str

    def __str__(self) -> str:
        return f"{self.file}:{self.line}: {self.text}"


class PageReader(HTMLParser):
    """Ids and references of a page, and its accessibility faults."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.ids: set[str] = set()
        self.references: list[Reference] = []
        self.faults: list[tuple[int, str]] = []
        self._inside = ""
        self._in_figure = False
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = {name: value or "" for name, value in attrs}
        line = self.getpos()[0]
        self.ids |= {given[key] for key in ("id", "name") if given.get(key)}
        self._inside = tag if tag in ("style", "script") else ""
        self._in_figure = self._in_figure or tag == "figure"
        handlers = sorted(name for name in given if name.startswith("on"))
        if handlers:
            self.faults.append((line, f"{tag} with {handlers[0]}: code in a name?"))
        if tag == "img" and "alt" not in given:
            self.faults.append((line, "image without alt text"))
        if tag == "img" and self._in_figure and not given.get("alt", "x").strip():
            self.faults.append((line, "figure with an empty alt text"))
        if tag == "iframe" and not given.get("title", "").strip():
            self.faults.append((line, "frame without a title"))
        if tag in ("a", "area") and "href" in given:
            self.references.append(Reference(line, given["href"], False))
        if tag == "link" and "href" in given:
            loaded = not set(given.get("rel", "").split()) & NOT_LOADED
            self.references.append(Reference(line, given["href"], loaded))
        for key in LOADED.get(tag, ()):
            for address in _addresses(key, given.get(key, "")):
                self.references.append(Reference(line, address, True))
        if "style" in given:
            for address in css_addresses(given["style"]):
                self.references.append(Reference(line, address, True))

    def handle_data(self, data: str) -> None:
        line = self.getpos()[0]
        if self._inside == "style":
            self.references += [Reference(line, a, True) for a in css_addresses(data)]
        elif self._inside == "script":
            found = SCRIPT_LOADS.findall(data)
            self.references += [Reference(line, a, True) for a in found]

    def handle_endtag(self, tag: str) -> None:
        self._inside = ""
        self._in_figure = self._in_figure and tag != "figure"


def _addresses(key: str, value: str) -> list[str]:
    if key != "srcset":
        return [value] if value else []
    return [part.split()[0] for part in value.split(",") if part.strip()]


def css_addresses(text: str) -> list[str]:
    """Addresses that a style sheet loads."""
    return [
        a or b for a, b in CSS_URL.findall(re.sub(r"/\*.*?\*/", "", text, flags=re.S))
    ]


@cache
def led_to(site: Path, folder: Path, address: str) -> tuple[Path, str]:
    """The file that an address in a page of ``folder`` names, and the fault."""
    target = (folder / unquote(address)).resolve()
    if target != site and site not in target.parents:
        return target, "leads out of the site"
    if target.is_dir():
        return target, "is a folder; name the page in it"
    return target, "" if target.is_file() else "no such file"


def check_site(site: Path) -> list[Problem]:
    """Return every problem of the site at ``site``; an empty list if there is none."""
    led_to.cache_clear()
    site = site.resolve()
    pages = {path: _page(path, site) for path in sorted(site.rglob("*.html"))}
    if not pages:
        return [Problem(str(site), 0, "no HTML page here; build the site first")]
    problems: list[Problem] = []
    for path, page in pages.items():
        name = path.relative_to(site).as_posix()
        problems += [Problem(name, line, text) for line, text in page.faults]
        for reference in page.references:
            text = _fault(site, path, reference, pages)
            if text:
                problems.append(Problem(name, reference.line, text))
    return problems + list(_style_sheets(site))


def _page(path: Path, site: Path) -> PageReader:
    text = path.read_text("utf-8")
    if path.relative_to(site).parts[0] != CODE:
        return PageReader(text)
    # A page of code has a long text, and one link from our own template.
    page = PageReader("")
    page.ids = set(ID.findall(text))
    return page


def _style_sheets(site: Path) -> Iterator[Problem]:
    for path in sorted(site.rglob("*.css")):
        for address in css_addresses(path.read_text("utf-8")):
            reference = Reference(0, address, True)
            text = _fault(site, path, reference, {})
            if text:
                yield Problem(path.relative_to(site).as_posix(), 0, text)


def _fault(
    site: Path, path: Path, reference: Reference, pages: dict[Path, PageReader]
) -> str | None:
    parts = urlsplit(reference.address)
    shown = reference.address
    if parts.scheme in ("http", "https") or parts.netloc:
        return f"loads {shown} from a host" if reference.loaded else None
    if (parts.scheme == "data" and reference.loaded) or parts.scheme == "mailto":
        return None
    if parts.scheme in ("data", "javascript"):
        return f"link {shown[:40]}: code or content in an address"
    if parts.scheme:
        return f"link {shown}: unknown scheme"
    if parts.path.startswith("/"):
        return f"link {shown}: starts at the root, which a file has not"
    target, wrong = path, ""
    if parts.path:
        target, wrong = led_to(site, path.parent, parts.path)
    if wrong:
        return f"link {shown}: {wrong}"
    anchor = unquote(parts.fragment)
    # With an equals sign it is not an anchor but the state of a page's filters.
    if (
        anchor
        and "=" not in anchor
        and anchor != "top"
        and target in pages
        and anchor not in pages[target].ids
    ):
        return f"link {shown}: no such anchor in the page"
    return None
