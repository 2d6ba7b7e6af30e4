"""A few of the mutants of `make fuzz`: each is read, or refused in one line."""

import pytest

from tests.fuzz.outcome import READ, REFUSED, outcome
from tests.fuzz.readers import READERS, write_mutant

FEW = {"set.yaml": 40, "images": 60, "camera.npz": 40, "rig": 12}
FEW |= {"corners.json": 15, "reference": 30, "points": 30}


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
