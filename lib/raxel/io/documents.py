"""Documents that people write: YAML without surprises, then a JSON schema.

Every fault is one line: file, field, what was found, what to do.
"""

import functools
import itertools
import json
import math
import re
from typing import ClassVar

import yaml

from raxel.errors import InputError, did_you_mean
from raxel.io.files import read_text

SHOWN_CHARACTERS = 60
# Read within some seconds.
MAX_BYTES = 1_000_000
MAX_VALUES = 1_000_000
TAG = "tag:yaml.org,2002:"


class _Loader(yaml.SafeLoader):
    """Load the plain core of YAML: no tags, no repeated keys, decimal numbers.

    Dates stay the texts that they are, as do 025 (not 21 in eights), 1:30 (not 90 in
    sixties) and numbers of more than 18 digits.
    """

    yaml_implicit_resolvers: ClassVar = {
        first: [pair for pair in pairs if pair[0] in (f"{TAG}bool", f"{TAG}null")]
        for first, pairs in yaml.SafeLoader.yaml_implicit_resolvers.items()
    }

    def compose_node(self, parent, index):
        event = self.peek_event()
        if getattr(event, "tag", None) is not None:
            raise _fault("tags (!) are not allowed", event)
        return super().compose_node(parent, index)

    def construct_mapping(self, node, deep=False):
        lines = {}
        for key, _ in node.value:
            if key.tag != f"{TAG}str":
                raise _fault("a key must be a quoted word", key)
            if key.value in lines:
                first = lines[key.value]
                problem = f"key {shown(key.value)} is repeated, first in line {first}"
                raise _fault(problem, key)
            lines[key.value] = key.start_mark.line + 1
        return super().construct_mapping(node, deep)


def _fault(problem, place):
    return yaml.MarkedYAMLError(problem=problem, problem_mark=place.start_mark)


_FLOAT = r"([-+]?[0-9]+\.[0-9]*|\.[0-9]+)([eE][-+][0-9]+)?$"
for _kind, _pattern in (("int", r"[-+]?(0|[1-9][0-9]{0,17})$"), ("float", _FLOAT)):
    _Loader.add_implicit_resolver(TAG + _kind, re.compile(_pattern), "-+.0123456789")


def read_yaml(path):
    """Return the content of a YAML file, checked for syntax and double keys.

    Raises InputError with file and line.
    """
    text = read_text(path, MAX_BYTES)
    try:
        data = yaml.load(text, _Loader)
        # A few lines of nested aliases can expand to more than memory holds.
        values = itertools.islice(json.JSONEncoder().iterencode(data), MAX_VALUES)
        if sum(1 for _ in values) == MAX_VALUES:
            raise ValueError("aliases (*) expand without bound")
        return data
    except (yaml.YAMLError, ValueError, RecursionError) as fault:
        mark = getattr(fault, "problem_mark", None)
        line = f"line {mark.line + 1}: " if mark else ""
        problem = one_line(getattr(fault, "problem", None) or fault)
        raise InputError(f"{path}: {line}{problem}; correct the YAML") from fault


def validate(data, where, schema):
    """Raise InputError for the first of `faults`; same arguments."""
    for line in faults(data, where, schema):
        raise InputError(line)


def faults(data, where, schema):
    """Return the faults of plain data (dicts, lists, numbers, texts) as lines.

    `where` is the file that the lines name, `schema` the path of a JSON schema; where
    that describes a field, its words are the advice. Unknown keys come first, since a
    misspelt key also makes the right one missing. Numbers must be finite.
    """
    validator = _validator(schema)
    order = {"additionalProperties": 0, "required": 1}
    try:
        errors = list(validator.iter_errors(data))
    except RecursionError:
        return [f"{where}: nested too deeply; use fewer levels"]
    errors.sort(key=lambda error: order.get(error.validator, 2))
    lines = [f"{where}: {_sentence(e, data, validator.schema)}" for e in errors]
    return list(dict.fromkeys(lines))


def field_name(path, data=None):
    """('views', 2, 'image') -> 'views[2].image'.

    An entry of a list in `data` that has an `id` goes by it: 'claims.c2_noise.test'.
    """
    name = ""
    for part in path:
        data = data and data[part]
        known = data.get("id") if isinstance(data, dict) else None
        if isinstance(part, int) and isinstance(known, str):
            part = known
        name += f"[{part}]" if isinstance(part, int) else f".{one_line(part)}"
    return name.removeprefix(".")


def shown(value):
    """Return a short description of a value on one line."""
    if isinstance(value, dict):
        return f"a mapping of {len(value)} keys"
    if isinstance(value, list):
        return f"a list of {len(value)}"
    words = {"None": "null", "True": "true", "False": "false"}
    return words.get(repr(value)) or _short(repr(value))


def one_line(text):
    """Return any text on one line of limited length."""
    return _short(
        "".join(c if c.isprintable() else " " for c in str(text)), 4 * SHOWN_CHARACTERS
    )


def _short(text, limit=SHOWN_CHARACTERS):
    return text if len(text) <= limit else text[: limit - 3] + "..."


@functools.cache
def _validator(schema):
    import jsonschema

    plain = jsonschema.Draft202012Validator
    types = plain.TYPE_CHECKER.redefine("number", _is_finite_number)
    finite = jsonschema.validators.extend(plain, type_checker=types)
    return finite(json.loads(schema.read_text("utf-8")))


def _is_finite_number(_, value):
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return number and abs(value) < math.inf


def _sentence(error, data, root):
    while error.context and not _described(error.schema, root):
        error = max(error.context, key=lambda inner: len(inner.absolute_path))
    field = field_name(error.absolute_path, data)
    known = error.schema.get("properties", {})
    if error.validator == "additionalProperties":
        unknown = next(key for key in error.instance if key not in known)
        place = f"{field}.{one_line(unknown)}".removeprefix(".")
        advice = did_you_mean(unknown, known) or f"known are {', '.join(known)}"
        return f"{place}: unknown key; {advice}"
    if error.validator == "required":
        missing = next(k for k in error.validator_value if k not in error.instance)
        advice = _described(known.get(missing, {}), root) or "add it"
        return f"{f'{field}.{missing}'.removeprefix('.')}: key missing; {advice}"
    wanted = one_line(f"{error.validator} {error.validator_value}")
    advice = _described(error.schema, root) or f"give {wanted}"
    return f"{field}: found {shown(error.instance)}; {advice}".removeprefix(": ")


def _described(schema, root):
    """Return the schema's description of valid values, through one $ref, or ''."""
    if "description" not in schema and "$ref" in schema:
        name = schema["$ref"].removeprefix("#/$defs/")
        schema = root["$defs"][name]
    return schema.get("description", "")
