"""A folder of the site holds what is wanted; what is right already is left alone."""

import os

from repro.judge.kept import Kept
from repro.site.mirror import made, mirror


def test_text_is_made_only_if_needed(tmp_path):
    source, folder, times = tmp_path / "a.py", tmp_path / "site", []

    def text():
        times.append(1)
        return source.read_text() * 2

    def build():
        kept = Kept(tmp_path, "made", (__file__,))
        touched = mirror({"a.html": made(kept, source, text)}, folder)
        kept.keep()
        return touched

    source.write_text("x")
    assert (build(), len(times)) == (["a.html"], 1)
    assert (build(), len(times)) == ([], 1)
    (folder / "a.html").write_text("damaged")
    assert (build(), len(times)) == (["a.html"], 2)
    source.write_text("y")
    assert (build(), len(times)) == (["a.html"], 3)
    assert (folder / "a.html").read_text() == "yy"


def test_mirror_writes_changed_and_removes_unwanted_files(tmp_path):
    wanted = {"a.txt": "1", "sub/b.txt": "2"}
    assert sorted(mirror(wanted, tmp_path)) == ["a.txt", "sub/b.txt"]
    os.utime(tmp_path / "a.txt", (1, 1))
    assert mirror(wanted | {"sub/b.txt": "3"}, tmp_path) == ["sub/b.txt"]
    assert (tmp_path / "a.txt").stat().st_mtime == 1
    assert mirror({"a.txt": "1"}, tmp_path) == ["sub/b.txt"]
    assert [path.name for path in tmp_path.iterdir()] == ["a.txt"]
