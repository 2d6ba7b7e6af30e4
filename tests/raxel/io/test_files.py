"""Results on disk are whole or absent."""

import errno
import os
from pathlib import Path

import numpy as np
import pytest

from raxel.errors import InputError
from raxel.io import files
from raxel.io.files import read_json, together, write_json, write_whole


@pytest.mark.parametrize("content", ["π und mehr\n", b"\x00\xff\r\n", ""])
def test_write_whole_keeps_content(tmp_path, content):
    path = tmp_path / "result.txt"
    path.write_text("the old one")
    write_whole(path, content)
    wanted = content.encode() if isinstance(content, str) else content
    assert path.read_bytes() == wanted
    assert os.listdir(tmp_path) == ["result.txt"]


def test_failed_write_keeps_old_file(tmp_path):
    path = tmp_path / "result.json"
    write_json(path, {"old": 1})
    with pytest.raises(ValueError, match="not JSON compliant"):
        write_json(path, {"new": np.nan})
    with pytest.raises(TypeError):
        write_whole(path, 7)
    assert read_json(path) == {"old": 1}
    assert os.listdir(tmp_path) == ["result.json"]


def test_open_reader_keeps_old_content(tmp_path):
    path = tmp_path / "result.json"
    write_json(path, {"old": "Mičušík", "values": [1.5, None]})
    with path.open(encoding="utf-8") as before:
        write_json(path, {"new": 2})
        old = '{\n "old": "Mičušík",\n "values": [\n  1.5,\n  null\n ]\n}\n'
        assert before.read() == old
    assert read_json(path) == {"new": 2}


def test_written_file_has_default_permissions(tmp_path):
    (tmp_path / "ordinary").write_text("")
    write_whole(tmp_path / "ours", "")
    assert len({path.stat().st_mode for path in tmp_path.iterdir()}) == 1


def test_missing_folder_is_reported(tmp_path):
    with pytest.raises(InputError, match=r"x\.json: no folder .*none; create it first"):
        write_json(tmp_path / "none" / "x.json", {})
    with pytest.raises(InputError, match="is a folder"):
        write_whole(tmp_path, "")


@pytest.mark.parametrize(
    "text", ['{"b": 1, "a": 1, "a": 2}', '[{"c": {"a": 1, "a": 1}}]']
)
def test_json_with_repeated_key_is_rejected(tmp_path, text):
    path = tmp_path / "a.json"
    path.write_text(text)
    with pytest.raises(InputError, match=r"a\.json: .*key 'a' is repeated in one"):
        read_json(path)


def test_json_may_have_byte_order_mark_and_equal_keys_in_other_objects(tmp_path):
    path = tmp_path / "a.json"
    path.write_text('{"a": {"a": 1}, "b": [{"a": 2}, {"a": 3}]}', "utf-8-sig")
    assert read_json(path) == {"a": {"a": 1}, "b": [{"a": 2}, {"a": 3}]}


def write_both(first, one, second, other):
    with together() as move:
        write_json(move(first), one)
        write_json(move(second), other)


def test_results_are_moved_together(tmp_path):
    first, second = tmp_path / "first.json", tmp_path / "second.json"
    write_json(first, {"old": 1})
    with pytest.raises(ValueError, match="not JSON compliant"):
        write_both(first, {"new": 1}, second, {"new": np.inf})
    assert read_json(first) == {"old": 1}
    assert os.listdir(tmp_path) == ["first.json"]
    with together() as move:
        write_json(move(first), {"new": 1})
        write_json(move(second), {"new": 2})
        assert read_json(first) == {"old": 1}
    assert (read_json(first), read_json(second)) == ({"new": 1}, {"new": 2})
    assert sorted(os.listdir(tmp_path)) == ["first.json", "second.json"]


def test_failed_move_names_results(tmp_path, monkeypatch):
    first, second = tmp_path / "first.json", tmp_path / "second.json"
    monkeypatch.setattr(files, "check_can_be_written", lambda path: None)
    second.mkdir()
    with pytest.raises(IsADirectoryError) as caught:
        write_both(first, 1, second, 2)
    assert caught.value.filename == f"{first}, {second}"
    assert sorted(os.listdir(tmp_path)) == ["first.json", "second.json"]


def test_full_disk_names_result(tmp_path, monkeypatch):
    def full(self, data):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(OSError, match="No space left") as caught:
        write_both(tmp_path / "a.json", 1, tmp_path / "b.json", 2)
    assert caught.value.filename == str(tmp_path / "a.json")
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize("name", ["a" * 251 + ".txt", "a." + "b" * 250, "é" * 127])
def test_longest_file_name_is_written(tmp_path, name):
    write_whole(tmp_path / name, "content")
    assert os.listdir(tmp_path) == [name]


def test_non_utf8_name_round_trips_json(tmp_path):
    write_json(tmp_path / "a.json", {"file": "a\udcff.png"})
    assert read_json(tmp_path / "a.json") == {"file": "a\udcff.png"}


def test_json_requires_regular_file(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "pipe", tmp_path):
        with pytest.raises(InputError, match="not a readable file"):
            read_json(path)
