"""What was cut or edited by hand is removed with one line, and so made again."""

import json
import os
from pathlib import Path
from types import SimpleNamespace

import pytest

from repro.run.results import WRITTEN, write_atomic
from repro.site.mirror import mirror
from repro.workflow.intact import drop_damaged
from repro.workflow.job import left

FILES = ("figures/quick/x.json", "figures/quick/x.csv", "figures/quick/x.npz")
SITE = Path("report/site-quick")


@pytest.fixture
def work(tmp_path, monkeypatch):
    """A checkout in which one job has left three files, and one a part of the site."""
    monkeypatch.chdir(tmp_path)
    done = "report/build/quick/site.done"
    job("figure/x", lambda: [write_atomic(Path(name), "{}") for name in FILES])
    job("site/sphinx", lambda: mirror({"index.html": "<p>", "a.html": "<b>"}, SITE))
    write_atomic(Path(done), "")
    return SimpleNamespace(root=tmp_path, base="figures/quick", site_done=done)


def job(label, writes):
    """What the job `label` leaves: its files, and its record."""
    before = len(WRITTEN)
    writes()
    record = Path("figures/quick/times", f"{label}.json")
    files = left(WRITTEN[before:])
    write_atomic(record, json.dumps({"processor_seconds": 1, "files": files}))


def there(work):
    return [name for name in FILES if (work.root / name).is_file()]


@pytest.mark.parametrize("dates", [None, (1, 1)])
def test_unchanged_files_are_kept(work, capsys, dates):
    for name in FILES if dates else ():
        os.utime(work.root / name, ns=dates)
    drop_damaged(work)
    assert there(work) == list(FILES)
    assert (work.root / work.site_done).is_file()
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("content", ["", "{", "[]", None])
def test_changed_file_removes_outputs_of_job(work, capsys, content):
    damaged = work.root / FILES[2]
    before = damaged.stat()
    damaged.unlink() if content is None else damaged.write_text(content)
    if content == "[]":
        os.utime(damaged, ns=(before.st_atime_ns, before.st_mtime_ns + 1))
    drop_damaged(work)
    assert there(work) == []
    (output,) = capsys.readouterr().err.splitlines()
    assert output.startswith(FILES[2])
    drop_damaged(work)
    assert capsys.readouterr().err == ""


def test_damaged_site_removes_only_marker(work):
    (SITE / "index.html").write_text("")
    drop_damaged(work)
    assert not (work.root / work.site_done).exists()
    assert (SITE / "a.html").is_file()
    assert there(work) == list(FILES)


def test_newest_record_decides(work):
    job("table/x", lambda: write_atomic(Path(FILES[1]), "1,2"))
    older = work.root / "figures/quick/times/figure/x.json"
    os.utime(older, ns=(1, 1))
    drop_damaged(work)
    assert there(work) == list(FILES)


@pytest.mark.parametrize(
    "content",
    [
        *("", "[]", '{"files": {"figu'),
        json.dumps({"files": {"../kept.txt": [2, 1, "0" * 64]}}),
        json.dumps({"files": {"figures/../README.md": [2, 1, "0" * 64]}}),
    ],
)
def test_damaged_record_removes_nothing(work, content):
    write_atomic(work.root / "README.md", "kept")
    before = sorted(work.root.rglob("*"))
    (work.root / "figures/quick/times/figure/x.json").write_text(content)
    drop_damaged(work)
    assert sorted(work.root.rglob("*")) == before
