"""Documents against schemas: every fault one line, in the schema's words or by rule."""

import json
import math
import os
from pathlib import Path

import pytest
import yaml

from raxel.errors import InputError
from raxel.io.documents import faults, read_yaml, validate

ENTRY = {
    "type": "object",
    "required": ["id", "value"],
    "additionalProperties": False,
    "properties": {
        "id": {"type": "string", "minLength": 1},
        "value": {"type": ["number", "null"]},
        "lines": {"type": "array", "minItems": 2, "uniqueItems": True},
        "source": {"enum": ["real", "synthetic"]},
        "unit": {"$ref": "#/$defs/unit"},
        "range": {"anyOf": [{"type": "null"}, {"items": {"minimum": 0}}]},
    },
}
SCHEMA = {
    "type": "object",
    "required": ["entries"],
    "properties": {"entries": {"type": "array", "items": ENTRY}},
    "$defs": {"unit": {"const": "mm", "description": "give mm, the one unit"}},
}


@pytest.fixture(scope="module")
def schema(tmp_path_factory):
    path = tmp_path_factory.mktemp("schemas") / "book.schema.json"
    path.write_text(json.dumps(SCHEMA))
    return path


def book(**change):
    return {"entries": [{"id": "first", "value": 1}, {"id": "b2", "value": 2} | change]}


def test_valid_document_has_no_fault(schema):
    assert faults(book(lines=[1, 2], source="real", unit="mm"), "book", schema) == []
    validate(book(), "book", schema)


@pytest.mark.parametrize(
    ("change", "line"),
    [
        ({"valu": 3}, "entries.b2.valu: unknown key; did you mean value?"),
        (
            {"xyz": 3},
            "entries.b2.xyz: unknown key; known are id, value, lines, source, unit, "
            "range",
        ),
        (
            {"value": "two"},
            "entries.b2.value: found 'two'; give type ['number', 'null']",
        ),
        ({"lines": [3]}, "entries.b2.lines: found a list of 1; give minItems 2"),
        (
            {"lines": [3, 3]},
            "entries.b2.lines: found a list of 2; give uniqueItems True",
        ),
        (
            {"source": "x"},
            "entries.b2.source: found 'x'; give enum ['real', 'synthetic']",
        ),
        ({"unit": "cm"}, "entries.b2.unit: found 'cm'; give mm, the one unit"),
        ({"range": [1, -2]}, "entries.b2.range[1]: found -2; give minimum 0"),
        ({"id": 7}, "entries[1].id: found 7; give type string"),
        (
            {"value": math.nan},
            "entries.b2.value: found nan; give type ['number', 'null']",
        ),
    ],
)
def test_fault_names_entry_and_advice(schema, change, line):
    (found,) = faults(book(**change), "book.yaml", schema)
    assert found.startswith(f"book.yaml: {line}")
    with pytest.raises(InputError) as fault:
        validate(book(**change), "book.yaml", schema)
    assert str(fault.value) == found


def test_missing_key_and_wrong_type_are_reported(schema):
    data = book()
    del data["entries"][0]["id"], data["entries"][0]["value"]
    assert faults(data, "book", schema) == ["book: entries[0].id: key missing; add it"]
    assert faults([], "book", schema) == ["book: found a list of 0; give type object"]


def test_unknown_keys_are_listed_first(schema):
    data = book(lines=[1], valu=3)
    del data["entries"][1]["value"]
    unknown, missing, short = faults(data, "book", schema)
    assert "valu: unknown key" in unknown
    assert "value: key missing" in missing
    assert "give minItems 2" in short


def test_expensive_yaml_is_rejected(tmp_path):
    path = tmp_path / "long.yaml"
    path.write_text("a: b\n" * 1_000_000)
    with pytest.raises(InputError, match=r"long\.yaml: file has 5 MB; .* at most 1 MB"):
        read_yaml(path)
    os.mkfifo(tmp_path / "pipe.yaml")
    with pytest.raises(InputError, match=r"pipe\.yaml: not a readable file"):
        read_yaml(tmp_path / "pipe.yaml")


def test_ambiguous_yaml_is_rejected(tmp_path):
    path = tmp_path / "plain.yaml"
    path.write_text("taken: 2026-01-31\nsizes: [1, 2.5]\n")
    assert read_yaml(path) == {"taken": "2026-01-31", "sizes": [1, 2.5]}
    path.write_text("a: 1\nb: 2\na: 3\n")
    twice = r"plain\.yaml: line 3: key 'a' is repeated, first in line 1; correct"
    with pytest.raises(InputError, match=twice):
        read_yaml(path)


def test_yaml_with_byte_names_is_strict(tmp_path):
    path = tmp_path / "names.yaml"
    path.write_text(yaml.safe_dump({"image": "\udcff.png", "taken": "2026-01-31"}))
    assert read_yaml(path) == {"image": "\udcff.png", "taken": "2026-01-31"}
    path.write_text('image: "\\uDCFF.png"\nimage: b\n')
    with pytest.raises(InputError, match="line 2: key 'image' is repeated"):
        read_yaml(path)


def test_yaml_numbers_are_decimal(tmp_path):
    path = tmp_path / "a.yaml"
    path.write_text('[0, -25, 0.25, .5, 2.5e+1, 1.0e+999, "025"]')
    assert read_yaml(path) == [0, -25, 0.25, 0.5, 25.0, math.inf, "025"]
    texts = ["025", "-017", "1:30", "1:30.5", "01_0", "0x19", ".nan", 30 * "9"]
    path.write_text(f"[{', '.join(texts)}]")
    assert read_yaml(path) == texts


def test_repository_yaml_has_unique_keys():
    root = Path(__file__).resolve().parents[3]
    paths = [
        path
        for folder in ("chapters", "data/published", "data/rigs", "lib", "tests")
        for path in (root / folder).rglob("*.yaml")
    ]
    assert len(paths) > 50
    for path in [*paths, root / "CITATION.cff"]:
        read_yaml(path)
