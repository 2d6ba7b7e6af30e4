"""Reads set.yaml strictly: YAML without surprises, then the JSON schema.

Every fault raises `InputError` with one line: file, field, what was found, what to do.
"""

import difflib
import functools
import json
import math
from importlib import resources
from pathlib import Path
from typing import ClassVar

import yaml

from raxel.errors import InputError

SHOWN_CHARACTERS = 60
MOST_VALUES = 1_000_000
SET_SCHEMA = "raxel.sets", "image_set.schema.json"


class _StrictLoader(yaml.SafeLoader):
    """YAML's plain core: no tags, no dates, no key given twice.

    Dates would turn a text such as 2026-01-31 into another type.
    """

    yaml_implicit_resolvers: ClassVar = {
        first: [pair for pair in pairs if not pair[0].endswith(":timestamp")]
        for first, pairs in yaml.SafeLoader.yaml_implicit_resolvers.items()
    }

    def compose_node(self, parent, index):
        event = self.peek_event()
        if getattr(event, "tag", None) is not None:
            self._refuse("a tag (!) is not allowed", event.start_mark)
        return super().compose_node(parent, index)

    def construct_mapping(self, node, deep=False):
        seen = set()
        for key_node, _ in node.value:
            if key_node.tag != "tag:yaml.org,2002:str":
                self._refuse("a key must be a word", key_node.start_mark)
            if key_node.value in seen:
                self._refuse(f"key {key_node.value!r} given twice", key_node.start_mark)
            seen.add(key_node.value)
        return super().construct_mapping(node, deep)

    def construct_object(self, node, deep=False):
        try:
            return super().construct_object(node, deep)
        except ValueError as fault:
            self._refuse(f"{shown(node.value)} is not a number", node.start_mark, fault)

    @staticmethod
    def _refuse(problem, mark, cause=None):
        raise yaml.constructor.ConstructorError(None, None, problem, mark) from cause


def read_yaml(path):
    """The content of a YAML file, checked for syntax and double keys.

    Raises InputError with file and line.
    """
    path = Path(path)
    try:
        data = yaml.load(path.read_text(encoding="utf-8-sig"), _StrictLoader)
    except yaml.MarkedYAMLError as fault:
        mark = fault.problem_mark or fault.context_mark
        line = f"line {mark.line + 1}: " if mark else ""
        problem = fault.problem or fault.context
        raise InputError(f"{path}: {line}{one_line(problem)}; mend the YAML") from fault
    except (yaml.YAMLError, UnicodeDecodeError) as fault:
        raise InputError(
            f"{path}: not a YAML text ({one_line(fault)}); save it as UTF-8"
        ) from fault
    except RecursionError as fault:
        raise InputError(f"{path}: nested too deeply to be a set; mend it") from fault
    except OSError as fault:
        raise InputError(f"{path}: cannot be read ({fault.strerror})") from fault
    if _expanded_size(data, {}) > MOST_VALUES:
        raise InputError(f"{path}: aliases (*) grow without bound; write them out")
    return data


def validate(data, where, schema=SET_SCHEMA):
    """Check plain data (dicts, lists, numbers, texts) against a schema.

    `where` is the file that the message names, `schema` (package, file) of the JSON
    schema. Raises InputError for the first fault; unknown keys come first, since a
    misspelt key also makes the right one missing.
    """
    validator = _validator(*schema)
    for field, number in _not_finite(data):
        raise InputError(
            f"{where}: {field}: found {number}; give a finite number"
            + (", or leave the key out" if field else "")
        )
    errors = sorted(validator.iter_errors(data), key=_order)
    if errors:
        raise InputError(f"{where}: {_sentence(errors[0], validator.schema)}")


def field_name(path):
    """('views', 2, 'image') -> 'views[2].image'"""
    name = ""
    for part in path:
        if isinstance(part, int):
            name += f"[{part}]"
        else:
            name += ("." if name else "") + one_line(part)
    return name


def shown(value):
    """A found value in a few words on one line."""
    if value is None:
        return "null"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, dict):
        return f"a mapping of {len(value)} keys"
    if isinstance(value, list):
        return f"a list of {len(value)}"
    return _short(repr(value))


def one_line(text):
    """Any text without line breaks and control characters, cut to a bearable length."""
    return _short(
        "".join(c if c.isprintable() else " " for c in str(text)), 4 * SHOWN_CHARACTERS
    )


def _short(text, limit=SHOWN_CHARACTERS):
    return text if len(text) <= limit else text[: limit - 3] + "..."


def _expanded_size(data, known):
    """How many values `data` has with its aliases written out; inf if it holds itself.

    A few lines of aliases to aliases can stand for more values than memory holds.
    """
    if not isinstance(data, (dict, list)):
        return 1
    if id(data) not in known:
        known[id(data)] = math.inf
        parts = data.values() if isinstance(data, dict) else data
        known[id(data)] = 1 + sum(_expanded_size(part, known) for part in parts)
    return known[id(data)]


@functools.cache
def _validator(package, name):
    import jsonschema

    schema = resources.files(package).joinpath(name)
    return jsonschema.Draft202012Validator(json.loads(schema.read_text("utf-8")))


def _not_finite(data, path=()):
    if isinstance(data, dict):
        for key, value in data.items():
            yield from _not_finite(value, (*path, key))
    elif isinstance(data, list):
        for index, value in enumerate(data):
            yield from _not_finite(value, (*path, index))
    elif isinstance(data, float) and not math.isfinite(data):
        yield field_name(path), data


def _order(error):
    kinds = {"additionalProperties": 0, "required": 1}
    path = [(isinstance(p, str), str(p).zfill(9)) for p in error.absolute_path]
    return kinds.get(error.validator, 2), path, str(error.validator)


def _sentence(error, root):
    path = tuple(error.absolute_path)
    if error.validator == "additionalProperties":
        return _unknown_key(error, path)
    if error.validator == "required":
        missing = next(
            key for key in error.validator_value if key not in error.instance
        )
        advice = _advice(error.schema.get("properties", {}).get(missing, {}), root)
        return f"{field_name((*path, missing))}: key missing; {advice}"
    field = f"{field_name(path)}: " if path else ""
    return f"{field}found {shown(error.instance)}; {_advice(error.schema, root)}"


def _unknown_key(error, path):
    known = list(error.schema["properties"])
    unknown = next(key for key in error.instance if key not in known)
    near = difflib.get_close_matches(unknown, known, n=1)
    advice = f"did you mean {near[0]}?" if near else f"known are {', '.join(known)}"
    return f"{field_name((*path, unknown))}: unknown key; {advice}"


def _advice(schema, root):
    """The schema's own words on what to give, followed through one $ref."""
    if "description" not in schema and "$ref" in schema:
        name = schema["$ref"].removeprefix("#/$defs/")
        schema = root["$defs"][name]
    return schema.get("description", "see the description of the format")
