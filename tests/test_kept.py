"""What was read stays known until something that was read for it changes."""

from repro.run.kept import Kept


def test_a_folder_is_read_again_when_a_name_in_it_comes_or_goes(tmp_path):
    folder = tmp_path / "library"
    folder.mkdir()
    (folder / "a.py").write_text("a")
    times = []

    def read(path):
        times.append(1)
        files = list(path.glob("*.py"))
        return sorted(file.name for file in files), [path, *files]

    def known():
        kept = Kept(tmp_path, "names", (__file__,))
        says = kept.of(folder, read)
        kept.keep()
        return says, len(times)

    assert known() == (["a.py"], 1)
    (folder / "__pycache__").mkdir()
    assert known() == (["a.py"], 1)
    (folder / "b.py").write_text("b")
    assert known() == (["a.py", "b.py"], 2)
    (folder / "b.py").write_text("c")
    assert known()[1] == 3
    (folder / "b.py").unlink()
    assert known() == (["a.py"], 4)
