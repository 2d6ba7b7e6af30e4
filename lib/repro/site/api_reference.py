"""The library's reference for the site: one page per package, from its docstrings.

The source is parsed, never imported: that takes a second, runs nothing, and shows
signatures as they are written. Docstrings are plain text with names in backquotes, so
everything else in them is escaped.
"""

from __future__ import annotations

import ast
import re
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from jinja2 import Environment

from repro.page.templates import environment

TEMPLATES = Path(__file__).with_name("templates")
CODE = re.compile(r"``(.+?)``|`(.+?)`", re.S)
SPECIAL = re.compile(r"([\\*_\[\]<>$#|{}~^])")
LIST_ITEM = re.compile(r"(-|\d+\.|\(\w\)) ")
SUPERSCRIPTS = dict(zip("0123456789T", "⁰¹²³⁴⁵⁶⁷⁸⁹ᵀ", strict=True))
PROGRAM = "cli"  # a command, not a library: its modules are for nobody to call
Documented = ast.FunctionDef | ast.ClassDef


@dataclass(frozen=True)
class DocumentedModule:
    """A parsed module: dotted name, path below lib, syntax."""

    name: str
    path: str
    tree: ast.Module


def api_pages(library: Path) -> dict[str, str]:
    """Pages of the reference by name (`api/cameras.md`) for the package ``library``."""
    packages = sorted(
        path.parent
        for path in library.rglob("__init__.py")
        if path.parent != library and _is_public(path.parent)
    )
    pages = {
        f"api/{_page_name(library, p)}.md": _page(library, p, "*.py") for p in packages
    }
    pages["api/index.md"] = _index(library, packages)
    return pages


def _page_name(library: Path, package: Path) -> str:
    """Name of the page of a package: a package within another has both names."""
    return "-".join(package.relative_to(library).parts)


def _index(library: Path, packages: list[Path]) -> str:
    inside = {
        _page_name(library, p): _module(library, p / "__init__.py") for p in packages
    }
    cards = [
        f"[{module.name}]({name}.md)\n: {prose(_summary(module.tree))}"
        for name, module in inside.items()
    ]
    toctree = "\n".join(inside)
    own = _module(library, library / "__init__.py")
    modules = [_module(library, path) for path in _files(library, "*.py")]
    return "\n\n".join(
        [
            "# The library",
            prose(ast.get_docstring(own.tree) or ""),
            "Install it alone with `pip install .`; it needs NumPy, SciPy, OpenCV, "
            "PyYAML and jsonschema. [Conventions and notation](../conventions.md) hold "
            "in every function: frames, units, pixel centres, names of poses.",
            *cards,
            *_sections(modules),
            f"```{{toctree}}\n:hidden:\n\n{toctree}\n```\n",
        ]
    )


def _page(library: Path, package: Path, pattern: str) -> str:
    own = _module(library, package / "__init__.py")
    modules = [_module(library, path) for path in _files(package, pattern)]
    parts = [f"# {own.name}", prose(ast.get_docstring(own.tree) or "")]
    homes = [(name, _home(library, own, name)) for name in _exported(own.tree)]
    names = [
        (f"{_page_of(library, home, package)}#{_anchor(home.name, name)}", name)
        for name, home in homes
        if home
    ]
    if names:
        parts.append(f"From `{own.name}`: {_html('exported', names)}.")
    entries = list(_documented(own, own.tree.body))
    if entries:
        parts += ["## The package itself", *entries]
    sections = [] if package.name == PROGRAM else _sections(modules)
    return "\n\n".join([*parts, *sections]) + "\n"


def _home(
    library: Path, module: DocumentedModule, name: str
) -> DocumentedModule | None:
    """The module that documents a name which another one defines or imports."""
    if any(node.name == name for node in _public(module.tree.body)):
        return module
    for node in module.tree.body:
        if isinstance(node, ast.ImportFrom) and name in [a.name for a in node.names]:
            path = library.parent.joinpath(*(node.module or "").split("."))
            if library not in path.parents:
                return None
            path = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
            return _home(library, _module(library, path), name)
    return None


def _page_of(library: Path, module: DocumentedModule, package: Path) -> str:
    """Address of the page of a module's package, empty if that is ``package``."""
    path = library.parent / module.path
    page = _page_name(library, path.parent) or "index"
    return "" if path.parent == package else f"{page}.html"


def _files(package: Path, pattern: str) -> list[Path]:
    return [path for path in sorted(package.glob(pattern)) if _is_public(path)]


def _is_public(path: Path) -> bool:
    return not path.name.startswith("_")


def _module(library: Path, path: Path) -> DocumentedModule:
    below = path.relative_to(library.parent)
    name = ".".join(below.with_suffix("").parts).removesuffix(".__init__")
    return DocumentedModule(name, below.as_posix(), _parsed(path.read_text("utf-8")))


@cache
def _parsed(text: str) -> ast.Module:
    """Syntax of a module's text, which several packages ask for."""
    return ast.parse(text)


def _sections(modules: list[DocumentedModule]) -> Iterator[str]:
    """Modules with something public in them, each under a heading."""
    for module in modules:
        entries = list(_documented(module, module.tree.body))
        if entries:
            yield f"## {module.name}"
            yield prose(ast.get_docstring(module.tree) or "")
            yield from entries


def _documented(module: DocumentedModule, body: list[ast.stmt]) -> Iterator[str]:
    for node in _public(body):
        yield _html("anchor", _anchor(module.name, node.name)) + "\n"
        yield f"### {prose(node.name)}"
        yield _signature(node, "")
        yield prose(ast.get_docstring(node) or "")
        if isinstance(node, ast.ClassDef):
            for method in _public(node.body):
                yield _signature(method, f"{node.name}.")
                yield prose(ast.get_docstring(method) or "")
        address = f"../source/{module.path}.html#{node.name}"
        yield _html("source", address)


def _public(body: list[ast.stmt]) -> list[Documented]:
    """Functions and classes without an underscore; a setter repeats its property."""
    return [
        node
        for node in body
        if isinstance(node, ast.FunctionDef | ast.ClassDef)
        and not node.name.startswith("_")
        and not any(ast.unparse(d).endswith(".setter") for d in node.decorator_list)
    ]


def _exported(tree: ast.Module) -> list[str]:
    for node in tree.body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__":
            return list(ast.literal_eval(node.value))
    return []


def _signature(node: Documented, owner: str) -> str:
    """The first lines of a definition as code; of a class its bases and its fields."""
    marks = [ast.unparse(mark) for mark in node.decorator_list]
    name = f"{owner}{node.name}"
    if isinstance(node, ast.ClassDef):
        bases = ", ".join(ast.unparse(base) for base in node.bases)
        fields = [
            f"    {ast.unparse(field)}"
            for field in node.body
            if isinstance(field, ast.AnnAssign) and not _hidden(field.target)
        ]
        lines = [f"class {name}({bases})" if bases else f"class {name}", *fields]
        lines += [
            _call(made, name)
            for made in node.body
            if isinstance(made, ast.FunctionDef) and made.name == "__init__"
        ]
    elif {"property", "cached_property", "functools.cached_property"} & set(marks):
        returns = f" -> {ast.unparse(node.returns)}" if node.returns else ""
        lines = [f"{name}{returns}  # property"]
    else:
        kept = [f"@{m}" for m in marks if m in ("classmethod", "staticmethod")]
        lines = [*kept, _call(node, name)]
    return "````python\n" + "\n".join(lines) + "\n````"


def _hidden(target: ast.expr) -> bool:
    return ast.unparse(target).startswith("_")


def _call(node: ast.FunctionDef, name: str) -> str:
    bare = ast.arguments(**{key: getattr(node.args, key) for key in node.args._fields})
    if bare.args and bare.args[0].arg in ("self", "cls"):
        bare.args = bare.args[1:]
    returns = f" -> {ast.unparse(node.returns)}" if node.returns else ""
    line = f"{name}({ast.unparse(bare)}){returns}"
    if len(line) <= 84:
        return line
    parts = _arguments(bare)
    return f"{name}(\n" + "".join(f"    {p},\n" for p in parts) + f"){returns}"


def _arguments(arguments: ast.arguments) -> list[str]:
    """Arguments one by one, for a signature that needs several lines."""
    call = ast.parse(f"def f({ast.unparse(arguments)}): pass").body[0].args
    plain = [*call.posonlyargs, *call.args]
    defaults = [None] * (len(plain) - len(call.defaults)) + list(call.defaults)
    parts = [_one(a, d) for a, d in zip(plain, defaults, strict=True)]
    if call.vararg:
        parts.append(f"*{ast.unparse(call.vararg)}")
    elif call.kwonlyargs:
        parts.append("*")
    parts += [
        _one(a, d) for a, d in zip(call.kwonlyargs, call.kw_defaults, strict=True)
    ]
    if call.kwarg:
        parts.append(f"**{ast.unparse(call.kwarg)}")
    return parts


def _one(argument: ast.arg, default: ast.expr | None) -> str:
    text = ast.unparse(argument)
    if default is None:
        return text
    return f"{text}{' = ' if argument.annotation else '='}{ast.unparse(default)}"


@cache
def _templates() -> Environment:
    return environment(TEMPLATES)


def _html(name: str, *values: object) -> str:
    """A piece of HTML, by the name of its macro."""
    macros = _templates().get_template("reference.html.jinja").module
    return str(getattr(macros, name)(*values))


def _anchor(module: str, name: str) -> str:
    return f"{module}.{name}"


def _summary(tree: ast.Module) -> str:
    return (ast.get_docstring(tree) or "").split("\n\n")[0]


def prose(docstring: str) -> str:
    """A docstring as MyST: paragraphs and lists as they are, the rest as text."""
    blocks = []
    for block in re.split(r"\n\s*\n", docstring.strip("\n")):
        lines = block.splitlines()
        if lines and all(line.startswith("    ") for line in lines):
            blocks.append(f"````text\n{textwrap.dedent(block)}\n````")
        elif not LIST_ITEM.match(block) and re.search(r"(?m)^  ", block):
            # Aligned by hand: only a fixed-width setting keeps it readable.
            blocks.append(f"````text\n{block}\n````")
        else:
            blocks.append(escaped(block))
    return "\n\n".join(block for block in blocks if block)


def escaped(text: str) -> str:
    """Text in which nothing but code in backquotes has a meaning to Markdown."""
    parts, last = [], 0
    for found in CODE.finditer(text):
        parts.append(_plain(text[last : found.start()]))
        code = " ".join((found[1] or found[2]).split())
        parts.append(f"`{code}`")
        last = found.end()
    return "".join([*parts, _plain(text[last:])])


def _plain(text: str) -> str:
    text = re.sub(r"\^([0-9T])(?![0-9A-Za-z])", lambda m: SUPERSCRIPTS[m[1]], text)
    text = SPECIAL.sub(r"\\\1", text).replace("`", r"\`")
    # A line that begins like a list or a heading, but is the middle of a sentence.
    return re.sub(r"(?m)^(\s*)([+=:]|-(?!\s))", r"\1\\\2", text)
