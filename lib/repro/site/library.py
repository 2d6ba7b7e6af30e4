"""The reference of the library: exports of its packages, by Sphinx's autodoc.

A Sphinx extension and its pages. Docstrings are plain text with code in backquotes, so
everything else in them is escaped.
"""

from __future__ import annotations

import inspect
import re
import sys
from pathlib import Path

CODE = re.compile(r"``.+?``|`[^`]+?`", re.S)
SPECIAL = re.compile(r"([\\*_|])")
LIST_ITEM = re.compile(r"(-|\d+\.|\(\w\)) ")
RULE = re.compile(r"-{3,}$")


def library_pages(library: Path) -> dict[str, str]:
    """Pages of the reference (`api/cameras.rst`): packages with their public names."""
    pages: dict[str, str] = {}
    for path in sorted(library.rglob("*.py")):
        inside = path.relative_to(library).with_suffix("").as_posix()
        name = inside.removesuffix("/__init__").replace("/", ".")
        title, options = f"raxel.{name}", "   :members:\n"
        if path.with_suffix(".pyi").is_file():
            options += "   :imported-members:\n"
        elif inside != "errors":
            continue
        page = f"{title}\n{'=' * len(title)}\n\n.. automodule:: {title}\n{options}"
        pages[f"api/{name}.rst"] = page
    names = "".join(f"   {Path(page).stem}\n" for page in pages)
    index = (
        "The library\n===========\n\n"
        "Install it alone with ``pip install .``. `Conventions and notation "
        "<../conventions.html>`_ apply to every function: frames, units, pixel "
        f"centres, names of poses.\n\n.. toctree::\n   :maxdepth: 1\n\n{names}"
    )
    return pages | {"api/index.rst": index}


def as_rst(lines: list[str]) -> list[str]:
    """A docstring as reStructuredText: paragraphs and lists, the rest unchanged."""
    written: list[str] = []
    for block in re.split(r"\n\s*\n", inspect.cleandoc("\n".join(lines))):
        own = block.splitlines()
        headed = len(own) > 1 and RULE.match(own[1])  # a heading of numpydoc
        if headed:
            written += [f"**{own[0]}**", ""]
            own = own[2:]
        aligned = any(line[:1] == " " for line in own) and not LIST_ITEM.match(block)
        if own[0].startswith(">>>") or (aligned and not headed):
            # An example or aligned text: readable only with a fixed-width font.
            written += ["::", "", *(f"    {line}" for line in own), ""]
            continue
        if headed:
            own = [f"  {li.lstrip()}" if li[:1] == " " else f"- {li}" for li in own]
        written += [*escaped("\n".join(own)).splitlines(), ""]
    return written


def escaped(text: str) -> str:
    """Text in which only code in backquotes is markup."""
    parts, last = [], 0
    for found in CODE.finditer(text):
        code = " ".join(found[0].strip("`").split())
        parts += [SPECIAL.sub(r"\\\1", text[last : found.start()]), rf"\ ``{code}``\ "]
        last = found.end()
    rest = SPECIAL.sub(r"\\\1", text[last:]).replace("`", r"\`")
    return "".join([*parts, rest])


def source_of(domain: str, info: dict) -> str | None:
    """Address of the page of code with the definition of an entry."""
    found = sys.modules[info["module"]]
    for name in info["fullname"].split("."):
        found = getattr(found, name, None)
    found = inspect.unwrap(getattr(found, "fget", None) or found)
    code = getattr(found, "__code__", None)
    if not (inspect.isclass(found) or code) or not found.__module__.startswith("raxel"):
        return None
    module = sys.modules[found.__module__]
    path = Path(module.__file__)
    place = path.as_posix().rpartition("/raxel/")[2]
    return f"../source/raxel/{place}.html#{found.__qualname__}"


def setup(app) -> dict:
    """Fill the pages from the docstrings."""
    for name in ("sphinx.ext.autodoc", "sphinx.ext.linkcode"):
        app.setup_extension(name)
    app.config.linkcode_resolve = source_of
    app.config.autodoc_member_order = "bysource"
    app.config.nitpick_ignore_regex = [("py:.*", ".*")]

    def written(app, what, name, obj, options, lines) -> None:
        lines[:] = as_rst(lines)

    def is_field(app, what, name, obj, skip, options) -> bool | None:
        return True if type(obj).__name__ == "_tuplegetter" else None

    app.connect("autodoc-process-docstring", written)
    app.connect("autodoc-skip-member", is_field)
    return {"parallel_read_safe": True}
