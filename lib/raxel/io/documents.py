"""Documents that people write: YAML without surprises, then a JSON schema.

Every fault is one line: file, field, what was found, what to do.
"""

import functools
import json
import math
import re
from pathlib import Path
from typing import ClassVar

import yaml

from raxel.errors import InputError, did_you_mean
from raxel.io.files import file_size

SHOWN_CHARACTERS = 60
MAX_VALUES = 1_000_000
MAX_DEPTH = 100
# Read within two seconds.
MAX_BYTES = 2_000_000


class _Refused(Exception):
    """YAML that may be right, and that is not taken: line, what was found, advice."""


class _Strict:
    """YAML's plain core: no dates, no key given twice, numbers in tens.

    Dates would turn a text such as 2026-01-31 into another type; 025 would be the 21
    that it is in eights, and 1:30 the 90 that it is in sixties.
    """

    yaml_implicit_resolvers: ClassVar = {
        first: [pair for pair in pairs if not pair[0].endswith(":timestamp")]
        for first, pairs in yaml.SafeLoader.yaml_implicit_resolvers.items()
    }

    def construct_mapping(self, node, deep=False):
        lines = {}
        for key_node, _ in node.value:
            key, mark = key_node.value, key_node.start_mark
            if key_node.tag != "tag:yaml.org,2002:str":
                _refuse(mark, "a key must be a word", "put it in quotes")
            if key in lines:
                found = f"key {shown(key)} given twice, first in line {lines[key]}"
                _refuse(mark, found, "keep one of the two")
            lines[key] = mark.line + 1
        return super().construct_mapping(node, deep)

    def construct_object(self, node, deep=False):
        if node.tag in _NUMBERS and _NOT_IN_TENS.match(node.value):
            found = f"{shown(node.value)} is no plain number"
            _refuse(node.start_mark, found, "write 25, not 025 or 1:30; quote a text")
        try:
            return super().construct_object(node, deep)
        except ValueError as fault:
            _refuse(
                node.start_mark, f"{shown(node.value)} is not a number", cause=fault
            )


class _FastLoader(_Strict, getattr(yaml, "CSafeLoader", yaml.SafeLoader)):
    """By libyaml where it is there: the ledger takes a quarter of a second, not one."""


class _Loader(_Strict, yaml.SafeLoader):
    """For what libyaml does not take: halves of characters, as in names of files."""


_NUMBERS = ("tag:yaml.org,2002:int", "tag:yaml.org,2002:float")
# In eights, and in sixties.
_NOT_IN_TENS = re.compile(r"[-+]?(0[0-7_]+$|[0-9_]+:)")
_HALF_CHARACTER = re.compile(r"\\u[dD][89a-fA-F]")


def _refuse(mark, found, advice="correct the YAML", cause=None):
    raise _Refused(f"line {mark.line + 1}: {found}; {advice}") from cause


def _refuse_tags_and_depth(text, loader):
    """What a loader would take as an order, or libyaml's would fall over.

    libyaml nests calls of C as deep as the text does, which nothing there counts.
    """
    depth = 0
    for event in yaml.parse(text, Loader=loader):
        if getattr(event, "tag", None) is not None:
            _refuse(event.start_mark, "a tag (!) is not allowed")
        if isinstance(event, yaml.CollectionStartEvent):
            depth += 1
        elif isinstance(event, yaml.CollectionEndEvent):
            depth -= 1
        if depth > MAX_DEPTH:
            _refuse(event.start_mark, "nested too deeply")


def read_yaml(path):
    """The content of a YAML file, checked for syntax and double keys.

    Raises InputError with file and line.
    """
    text = read_text(path)
    try:
        loader = _Loader if _HALF_CHARACTER.search(text) else _FastLoader
        _refuse_tags_and_depth(text, loader)
        data = yaml.load(text, loader)
    except _Refused as fault:
        raise InputError(f"{path}: {fault}") from fault
    except yaml.MarkedYAMLError as fault:
        mark = fault.problem_mark or fault.context_mark
        line = f"line {mark.line + 1}: " if mark else ""
        problem = fault.problem or fault.context
        raise InputError(
            f"{path}: {line}{one_line(problem)}; correct the YAML"
        ) from fault
    except yaml.YAMLError as fault:
        raise InputError(_no_yaml(path, fault)) from fault
    except RecursionError as fault:
        raise InputError(f"{path}: nested too deeply; use fewer levels") from fault
    if _expanded_size(data, {}) > MAX_VALUES:
        raise InputError(f"{path}: aliases (*) grow without bound; write them out")
    return data


def read_text(path):
    """The text of a file that people write. Raises InputError that names it."""
    path = Path(path)
    size = file_size(path)
    if size > MAX_BYTES:
        raise InputError(
            f"{path}: found {size / 1e6:.4g} MB, which people do not write; give "
            f"{MAX_BYTES / 1e6:g} MB at most"
        )
    try:
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as fault:
        raise InputError(_no_yaml(path, fault)) from fault
    except OSError as fault:
        raise InputError(f"{path}: cannot be read ({fault.strerror})") from fault


def _no_yaml(where, fault):
    return f"{where}: not a YAML text ({one_line(fault)}); save it as UTF-8"


def validate(data, where, schema):
    """Raise InputError for the first of `faults`, which takes the same."""
    for line in faults(data, where, schema):
        raise InputError(line)


def faults(data, where, schema):
    """What is wrong with plain data (dicts, lists, numbers, texts), one line a fault.

    `where` is the file that the lines name, `schema` the path of a JSON schema; where
    that describes a field, its words are the advice. Returns a list, empty where
    nothing is wrong. Unknown keys come first, since a misspelt key also makes the
    right one missing; of several in one place the first is named. A number that is not
    finite is named alone.
    """
    try:
        return _faults(data, where, schema)
    except RecursionError:
        return [f"{where}: nested too deeply; use fewer levels"]


def _faults(data, where, schema):
    for path, number in _not_finite(data):
        advice = "give a finite number" + (", or leave the key out" if path else "")
        return [f"{where}: {field_name(path, data)}: found {number}; {advice}"]
    validator = _validator(schema)
    errors = sorted(validator.iter_errors(data), key=_order)
    lines = [f"{where}: {_sentence(e, data, validator.schema)}" for e in errors]
    return list(dict.fromkeys(lines))


def field_name(path, data=None):
    """('views', 2, 'image') -> 'views[2].image'.

    An entry of a list in `data` that has an `id` goes by it: 'claims.c2_noise.test'.
    """
    name = ""
    for part in path:
        data = None if data is None else data[part]
        known = data.get("id") if isinstance(data, dict) else None
        if isinstance(part, int) and not isinstance(known, str):
            name += f"[{part}]"
        else:
            word = known if isinstance(part, int) else part
            name += ("." if name else "") + one_line(word)
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
def _validator(schema):
    import jsonschema

    return jsonschema.Draft202012Validator(json.loads(schema.read_text("utf-8")))


def _not_finite(data, path=()):
    if isinstance(data, dict):
        for key, value in data.items():
            yield from _not_finite(value, (*path, key))
    elif isinstance(data, list):
        for index, value in enumerate(data):
            yield from _not_finite(value, (*path, index))
    elif isinstance(data, float) and not math.isfinite(data):
        yield path, data


def _order(error):
    kinds = {"additionalProperties": 0, "required": 1}
    path = [(isinstance(p, str), str(p).zfill(9)) for p in error.absolute_path]
    return kinds.get(error.validator, 2), path, str(error.validator)


def _sentence(error, data, root):
    while error.context and not _described(error.schema, root):
        error = max(error.context, key=lambda inner: len(inner.absolute_path))
    path = tuple(error.absolute_path)
    if error.validator == "additionalProperties" and isinstance(error.instance, dict):
        return _unknown_key(error, path, data)
    if error.validator == "required":
        missing = next(
            key for key in error.validator_value if key not in error.instance
        )
        known = error.schema.get("properties", {}).get(missing, {})
        place = ".".join(filter(None, (field_name(path, data), missing)))
        return f"{place}: key missing; {_described(known, root) or 'add it'}"
    field = f"{field_name(path, data)}: " if path else ""
    advice = _described(error.schema, root) or _advice(error)
    return f"{field}found {shown(error.instance)}; {advice}"


def _unknown_key(error, path, data):
    known = list(error.schema.get("properties", {}))
    unknown = next(key for key in error.instance if key not in known)
    place = ".".join(filter(None, (field_name(path, data), one_line(unknown))))
    advice = did_you_mean(unknown, known) or f"known are {', '.join(known)}"
    return f"{place}: unknown key; {advice}"


def _described(schema, root):
    """The schema's own words on what to give, followed through one $ref, or ''."""
    if "description" not in schema and "$ref" in schema:
        name = schema["$ref"].removeprefix("#/$defs/")
        schema = root["$defs"][name]
    return schema.get("description", "")


def _advice(error):
    """What to give where the schema does not say it in words."""
    wanted = error.validator_value
    listed = [str(one) for one in (wanted if isinstance(wanted, list) else [wanted])]
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
    return advice.get(error.validator) or one_line(error.message)
