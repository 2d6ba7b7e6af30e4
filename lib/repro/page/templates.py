"""HTML from templates in files beside the code; every value in them is escaped."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

FOLDER = Path(__file__).with_name("templates")


def environment(*folders: Path) -> Environment:
    """Templates of the given folders and of this room; an unknown name is an error."""
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
    """A template of this room, filled."""
    return _own().get_template(f"{name}.html.jinja").render(**values)


def part(name: str, *values: object) -> str:
    """A piece of HTML for a shown figure or table, by the name of its macro."""
    return str(getattr(_own().get_template("shown.html.jinja").module, name)(*values))
