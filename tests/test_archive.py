"""The report as one file: the same bytes whenever packed, refused when not built."""

import os
import zipfile

import pytest

from repro.site.archive import main, packed


@pytest.fixture
def built(tmp_path, monkeypatch):
    """A checkout whose quick report is built."""
    site = tmp_path / "report" / "site-quick"
    (site / "ch02_x").mkdir(parents=True)
    (site / "index.html").write_text("<p>start</p>" * 100)
    (site / "ch02_x" / "s1.html").write_text("<p>page</p>")
    (site / "a b.png").write_bytes(b"\x89PNG")
    done = tmp_path / "report" / "build" / "quick" / "site.done"
    done.parent.mkdir(parents=True)
    done.touch()
    monkeypatch.chdir(tmp_path)
    return site


def test_the_archive_holds_the_site_in_a_folder_of_its_own(built, capsys):
    assert main(["--effort", "quick"]) == 0
    assert "report/raxel-report-quick.zip" in capsys.readouterr().out
    with zipfile.ZipFile("report/raxel-report-quick.zip") as bundle:
        assert bundle.testzip() is None
        names = bundle.namelist()
        assert names == sorted(names)
        assert names == [
            f"raxel-report-quick/{name}"
            for name in ("a b.png", "ch02_x/s1.html", "index.html")
        ]
        assert bundle.read(names[2]) == (built / "index.html").read_bytes()
        assert {entry.date_time[0] for entry in bundle.infolist()} == {1980}


def test_the_same_site_gives_the_same_bytes(built):
    before = packed(built, "top")
    os.utime(built / "index.html", (1, 1))
    os.chmod(built / "a b.png", 0o600)
    assert packed(built, "top") == before
    (built / "index.html").write_text("other")
    assert packed(built, "top") != before


@pytest.mark.parametrize(
    ("effort", "gone", "said"),
    [
        ("full", None, "no report/site/index.html; build it first: make report"),
        ("quick", "report/site-quick/index.html", "build it first: make quick"),
        ("quick", "report/build/quick/site.done", "did not finish: make quick"),
    ],
)
def test_what_is_not_built_is_not_packed(built, effort, gone, said, capsys, tmp_path):
    if gone:
        (tmp_path / gone).unlink()
    assert main(["--effort", effort]) == 1
    errors = capsys.readouterr().err
    assert said in errors
    assert errors.count("\n") == 1
    assert not list((tmp_path / "report").glob("*.zip"))
