"""A folder of the site holds what is wanted; what is right already is left alone."""

import os

from repro.site.mirror import mirror


def test_mirror_writes_changed_and_removes_unwanted_files(tmp_path):
    wanted = {"a.txt": "1", "sub/b.txt": "2"}
    assert sorted(mirror(wanted, tmp_path)) == ["a.txt", "sub/b.txt"]
    os.utime(tmp_path / "a.txt", (1, 1))
    assert mirror(wanted | {"sub/b.txt": "3"}, tmp_path) == ["sub/b.txt"]
    assert (tmp_path / "a.txt").stat().st_mtime == 1
    assert mirror({"a.txt": "1"}, tmp_path) == ["sub/b.txt"]
    assert [path.name for path in tmp_path.iterdir()] == ["a.txt"]
