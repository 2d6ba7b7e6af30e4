"""HTML from template files next to the code; every value in them is escaped."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

FOLDER = Path(__file__).with_name("templates")


def environment(*folders: Path) -> Environment:
    """Return the templates of the given folders and of this package; unknown names
    raise."""
    return Environment(
        loader=FileSystemLoader([*folders, FOLDER]),
        undefined=StrictUndefined,
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
    )


@cache
def _own() -> Environment:
    return environment()


def render(name: str, **values: object) -> str:
    """Return a filled template of this package."""
    return _own().get_template(f"{name}.html.jinja").render(**values)


def part(name: str, *values: object) -> str:
    """Return a piece of HTML for a figure or table, by the name of its macro."""
    return str(getattr(_own().get_template("shown.html.jinja").module, name)(*values))
