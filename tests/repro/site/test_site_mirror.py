"""A folder of the site holds what is wanted; what is right already is left alone."""

from repro.run.kept import Kept
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


def test_unwanted_files_are_removed(tmp_path):
    (tmp_path / "old").mkdir()
    (tmp_path / "old" / "page.html").write_text("x")
    assert sorted(mirror({"page.html": "new"}, tmp_path)) == [
        "old/page.html", "page.html",
    ]  # fmt: skip
    assert not (tmp_path / "old").exists()
