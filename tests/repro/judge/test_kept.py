"""What was read stays known until something that was read for it changes."""

from repro.judge.kept import Kept


def test_cache_is_invalidated_by_read_files(tmp_path):
    first, second = tmp_path / "a.py", tmp_path / "b.py"
    first.write_text("a")
    times = []

    def read(path):
        times.append(1)
        files = [one for one in (first, second) if one.is_file()]
        return [one.read_text() for one in files], [first, second]

    def known():
        kept = Kept(tmp_path, "names", (__file__,))
        says = kept.of(first, read)
        kept.keep()
        return says, len(times)

    assert known() == (["a"], 1)
    assert known() == (["a"], 1)
    second.write_text("b")
    assert known() == (["a", "b"], 2)
    second.unlink()
    assert known() == (["a"], 3)
