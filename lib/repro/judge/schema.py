"""Check the book-keeping's own files against their schemas, one line per fault."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from difflib import get_close_matches
from functools import cache
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).parent / "schemas"


def faults(content: object, schema: str, name: str) -> list[str]:
    """Faults of a file's content, one line each: file, entry, field, found, what to do.

    Parameters
    ----------
    content : what the file holds, as plain Python.
    schema : name of the schema in `lib/repro/judge/schemas`.
    name : the file's name, for the line.
    """
    errors = sorted(_validator(schema).iter_errors(content), key=lambda e: str(e.path))
    return [f"{name}: {_line(content, error)}" for error in errors]


def hint(name: str, known: Sequence[str]) -> str:
    """'; did you mean x?' where one of the known names is close."""
    close = get_close_matches(name, known, 1)
    return f"; did you mean {close[0]}?" if close else ""


@cache
def _validator(schema: str) -> Any:
    from jsonschema import Draft202012Validator

    text = (FOLDER / f"{schema}.schema.json").read_text("utf-8")
    return Draft202012Validator(json.loads(text))


def _line(content: object, error: Any) -> str:
    while error.context:
        error = max(error.context, key=lambda inner: len(inner.absolute_path))
    place = ".".join(_named(content, list(error.absolute_path)))
    return f"{place or 'the file'}: {_complaint(error)}"


def _named(content: Any, path: list) -> Iterator[str]:
    """Path in words: an entry of a list goes by its id."""
    for key in path:
        content = content[key]
        named = isinstance(content, dict) and isinstance(content.get("id"), str)
        yield content["id"] if named else str(key)


def _complaint(error: Any) -> str:
    rule, wanted, found = error.validator, error.validator_value, error.instance
    if rule == "required":
        missing = [name for name in wanted if name not in found]
        return f"{missing[0]} is missing; add it"
    if rule == "additionalProperties" and isinstance(found, dict):
        known = list(error.schema.get("properties", {}))
        extra = next(name for name in found if name not in known)
        return f"unknown field {extra}{hint(str(extra), known) or '; remove it'}"
    listed = [str(w) for w in (wanted if isinstance(wanted, list) else [wanted])]
    advice = {
        "enum": f"give one of {', '.join(listed)}",
        "type": f"give {' or '.join(listed)}",
        "pattern": f"write it as {wanted}",
        "minItems": f"give at least {wanted}",
        "maxItems": f"give at most {wanted}",
        "uniqueItems": "give each once",
        "minLength": "write some text",
        "minProperties": "name at least one",
        "minimum": f"give {wanted} or more",
    }
    return f"found {_short(found)}; {advice.get(rule, error.message)}"


def _short(found: object) -> str:
    text = " ".join(repr(found).split())
    return text if len(text) <= 60 else text[:57] + "..."
