"""A few of the mutants of `make fuzz`: each is read, or refused in one line."""

import copy
import json
import struct

import numpy as np
import pytest

from tests.fuzz import outcome as outcomes
from tests.fuzz.grids import HEIGHT, WIDTH
from tests.fuzz.outcome import READ, REFUSED, outcome
from tests.fuzz.readers import READERS, write_mutant

FEW = {"set.yaml": 40, "images": 60, "camera.npz": 40, "rig": 12}
FEW |= {"corners.json": 15, "reference": 30, "points": 30, "grid set": 40}


@pytest.mark.parametrize("name", READERS)
def test_whole_files_are_read(name, tmp_path):
    reader = READERS[name]
    reader.prepare(tmp_path)
    for content, _ in reader.samples():
        (tmp_path / reader.name).write_bytes(content)
        assert outcome(reader, tmp_path, 1) == (READ, "")


@pytest.mark.parametrize("name", READERS)
def test_damaged_ones_are_read_or_refused(name, tmp_path):
    reader = READERS[name]
    reader.prepare(tmp_path)
    samples = reader.samples()
    for number in range(FEW[name]):
        write_mutant(reader, tmp_path, 1, number, samples)
        kind, told = outcome(reader, tmp_path, number)
        assert kind in (READ, REFUSED), f"mutant {number}: {told}"


@pytest.mark.parametrize("kind", [0, 127, 128, 65535])
def test_a_tag_of_a_tiff_may_have_an_unknown_type(kind, tmp_path):
    reader = READERS["images"]
    reader.prepare(tmp_path)
    whole = next(one for one, _ in reader.samples() if one.startswith(b"II*\0"))
    strips = struct.pack("<H", 273)
    at = whole.index(strips, struct.unpack_from("<I", whole, 4)[0]) + 2
    content = whole[:at] + struct.pack("<H", kind) + whole[at + 2 :]
    (tmp_path / reader.name).write_bytes(content)
    assert outcome(reader, tmp_path, 0)[0] == REFUSED


def test_an_sd_beyond_all_numbers(tmp_path):
    reader = READERS["corners.json"]
    reader.prepare(tmp_path)
    found = copy.deepcopy(reader.samples()[0][1])
    found["images"][0]["sd"][3] = 10**400
    (tmp_path / reader.name).write_text(json.dumps(found))
    kind, told = outcome(reader, tmp_path, 0)
    assert kind == REFUSED
    assert "images[0].sd: give one number" in told


STRANGE = (
    "!!bool x\n",
    "? [a]\n: b\n",
    "a: ._\n",
    "a: !!timestamp x\n",
    "<<: {a: 1}\n",
    "= : 1\n",
    "a: =\n",
    "a: " + "9" * 5000 + "\n",
    'name: "\\ud800"\n',
    "a: " + "[" * 500 + "\n",
)


@pytest.mark.parametrize("line", STRANGE)
def test_strange_lines_of_a_description(line, tmp_path):
    reader = READERS["set.yaml"]
    reader.prepare(tmp_path)
    whole = reader.samples()[0][0]
    (tmp_path / reader.name).write_bytes(whole + line.encode())
    assert outcome(reader, tmp_path, 0)[0] == REFUSED


def test_points_beyond_all_monitors(tmp_path):
    reader = READERS["points"]
    reader.prepare(tmp_path)
    far = np.full((HEIGHT, WIDTH, 2), 1e300)
    np.savez(tmp_path / reader.name, points_mm=far)
    kind, told = outcome(reader, tmp_path, 0)
    assert kind == REFUSED
    assert "points_mm: found 1e+300; no monitor is so large" in told


def test_points_of_half_precision(tmp_path):
    reader = READERS["points"]
    reader.prepare(tmp_path)
    half = np.full((HEIGHT, WIDTH, 2), 12.0, np.float16)
    half[0, 0] = np.inf  # as larger ones become
    half[0, 1] = np.nan
    np.savez(tmp_path / reader.name, points_mm=half)
    kind, told = outcome(reader, tmp_path, 0)
    assert kind == REFUSED
    assert "points_mm: found inf; no monitor is so large" in told
    half[0, 0] = np.nan
    np.savez(tmp_path / reader.name, points_mm=half)
    assert outcome(reader, tmp_path, 0)[0] == READ


@pytest.mark.parametrize(
    ("held", "kind"), [((3e9, 3e9), READ), ((1e9, 3e9), "memory"), ((1e9, 2e9), READ)]
)
def test_memory_is_that_of_the_file_and_not_of_what_ran_before(
    held, kind, tmp_path, monkeypatch
):
    reader = READERS["points"]
    reader.prepare(tmp_path)
    (tmp_path / reader.name).write_bytes(reader.samples()[0][0])
    monkeypatch.setattr(outcomes, "_most_memory", iter(held).__next__)
    assert outcome(reader, tmp_path, 1)[0] == kind
