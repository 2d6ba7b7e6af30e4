"""Results on disk are whole or absent."""

import os

import numpy as np
import pytest

from raxel.errors import InputError
from raxel.files import read_json, write_json, write_whole


@pytest.mark.parametrize("content", ["π und mehr\n", b"\x00\xff\r\n", ""])
def test_content_arrives_as_it_is(tmp_path, content):
    path = tmp_path / "result.txt"
    path.write_text("the old one")
    write_whole(path, content)
    wanted = content.encode() if isinstance(content, str) else content
    assert path.read_bytes() == wanted
    assert os.listdir(tmp_path) == ["result.txt"]


def test_a_failure_leaves_the_old_file_and_nothing_beside_it(tmp_path):
    path = tmp_path / "result.json"
    write_json(path, {"old": 1})
    with pytest.raises(ValueError, match="not JSON compliant"):
        write_json(path, {"new": np.nan})
    with pytest.raises(TypeError):
        write_whole(path, 7)
    assert read_json(path) == {"old": 1}
    assert os.listdir(tmp_path) == ["result.json"]


def test_json_is_written_for_people(tmp_path):
    path = tmp_path / "names.json"
    write_json(path, {"name": "Mičušík", "values": [1.5, None]})
    assert path.read_text("utf-8") == (
        '{\n "name": "Mičušík",\n "values": [\n  1.5,\n  null\n ]\n}\n'
    )


def test_permissions_are_those_of_an_ordinary_file(tmp_path):
    (tmp_path / "ordinary").write_text("")
    write_whole(tmp_path / "ours", "")
    modes = {path.stat().st_mode for path in tmp_path.iterdir()}
    assert len(modes) == 1


def test_a_folder_that_is_not_there_is_named(tmp_path):
    with pytest.raises(InputError, match=r"x\.json: no folder .*none; make it first"):
        write_json(tmp_path / "none" / "x.json", {})
    with pytest.raises(InputError, match="this is a folder"):
        write_whole(tmp_path, "")
