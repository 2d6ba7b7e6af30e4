"""What was cut or edited by hand is told, removed, and so made again."""

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


@pytest.fixture
def work(tmp_path, monkeypatch):
    """A checkout in which one job has left three files, and one a part of the site."""
    monkeypatch.chdir(tmp_path)
    done = "report/build/quick/site.done"
    job("figure/x", lambda: [write_atomic(Path(name), "{}") for name in FILES])
    job("site/sphinx", lambda: mirror({"index.html": "<p>", "a.html": "<b>"}, SITE))
    write_atomic(Path(done), "")
    made = {("figure", "x"): None}
    return SimpleNamespace(
        root=tmp_path, base="figures/quick", site_done=done, producers=made
    )


SITE = Path("report/site-quick")


def job(label, writes):
    """What the job `label` leaves: its files, and its record."""
    before = len(WRITTEN)
    writes()
    record = Path("figures/quick/times", f"{label}.json")
    files = left(WRITTEN[before:])
    write_atomic(record, json.dumps({"processor_seconds": 1, "files": files}))


def there(work):
    return [name for name in FILES if (work.root / name).is_file()]


def test_whole_files_stay_without_a_word(work, capsys):
    drop_damaged(work)
    assert there(work) == list(FILES)
    assert (work.root / work.site_done).is_file()
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("content", ["", "{", "[]", None])
def test_a_file_that_is_cut_edited_or_gone_takes_its_job_along(work, capsys, content):
    damaged = work.root / FILES[2]
    before = damaged.stat()
    damaged.unlink() if content is None else damaged.write_text(content)
    if content == "[]":
        os.utime(damaged, ns=(before.st_atime_ns, before.st_mtime_ns + 1))
    drop_damaged(work)
    assert there(work) == []
    said = f"{FILES[2]} was damaged: it will be made again\n"
    assert capsys.readouterr().err == said
    drop_damaged(work)
    assert capsys.readouterr().err == ""


def test_a_copy_with_new_dates_is_whole_and_looked_into_once(work, capsys, monkeypatch):
    for name in FILES:
        os.utime(work.root / name, ns=(1, 1))
    drop_damaged(work)
    monkeypatch.setattr("repro.workflow.intact.hash_of", None)
    drop_damaged(work)
    assert there(work) == list(FILES)
    assert capsys.readouterr().err == ""


def test_of_the_site_only_its_mark_goes_for_it_mends_itself(work):
    (SITE / "index.html").write_text("")
    drop_damaged(work)
    assert not (work.root / work.site_done).exists()
    assert (SITE / "a.html").is_file()
    assert there(work) == list(FILES)


def test_an_older_record_of_the_same_file_says_nothing(work, capsys):
    job("table/x", lambda: write_atomic(Path(FILES[1]), "1,2"))
    older = work.root / "figures/quick/times/figure/x.json"
    os.utime(older, ns=(1, 1))
    drop_damaged(work)
    assert there(work) == list(FILES)
    assert capsys.readouterr().err == ""


def of_no_job(work, name):
    path = work.root / "figures/quick" / name
    path.parent.mkdir(exist_ok=True)
    path.write_text("{}")
    return path


KNOWN = [2, 1, "0" * 64]


@pytest.mark.parametrize(
    "content",
    [
        None,
        "",
        '{"files": {"figu',
        "[]",
        '"x"',
        "[" * 100_000,
        json.dumps({"files": [FILES[0]]}),
        json.dumps({"files": {FILES[0]: None}}),
        json.dumps({"files": {FILES[0]: KNOWN[:2]}}),
        json.dumps({"files": {FILES[0]: [2.5, 1, "x"]}}),
        json.dumps({"files": {"../../kept.txt": KNOWN}}),
    ],
)
def test_without_a_sound_record_there_is_no_result(work, capsys, content):
    outside = work.root.parent / "kept.txt"
    outside.write_text("x")
    record = work.root / "figures/quick/times/figure/x.json"
    record.unlink() if content is None else record.write_text(content)
    drop_damaged(work)
    assert not record.exists()
    assert there(work) == []
    said = capsys.readouterr().err.splitlines()
    reason = "has no sound record of its job: it will be made again"
    assert said == [f"{name} {reason}" for name in sorted(FILES)]
    assert outside.is_file()


def test_a_record_that_names_files_elsewhere_removes_none(work):
    outside = work.root.parent / "kept.txt"
    outside.write_text("x")
    for name in (str(outside), "../kept.txt"):
        record = work.root / "figures/quick/times/figure/y.json"
        record.write_text(json.dumps({"files": {name: KNOWN}}))
        drop_damaged(work)
        assert outside.is_file()
        assert not record.exists()


@pytest.mark.parametrize(
    "name",
    [
        *("README.md", "lib/raxel/x.py", "figures/README.md", "report/source/conf.py"),
        *("data/synthetic/README.md", "lib", "", ".", "a\0b", "\ud800", "x" * 300),
        *("figures/quick", "figures/quick/../../lib/raxel/x.py", "figures/quick/link"),
    ],
)
def test_a_record_that_names_what_no_job_writes_removes_nothing(work, name):
    source = work.root / "lib/raxel/x.py"
    for path in ("README.md", "figures/README.md", "data/synthetic/README.md"):
        write_atomic(work.root / path, "kept")
    write_atomic(source, "kept")
    write_atomic(work.root / "report/source/conf.py", "kept")
    (work.root / "figures/quick/link").symlink_to(source)
    before = sorted(work.root.rglob("*"))
    record = work.root / "figures/quick/times/figure/y.json"
    record.write_text(json.dumps({"files": {name: KNOWN}}))
    drop_damaged(work)
    assert sorted(work.root.rglob("*")) == before


def test_records_that_are_no_files_do_no_harm(work, capsys):
    records = work.root / "figures/quick/times/figure"
    (records / "folder.json").mkdir()
    (records / "link.json").symlink_to(records / "nowhere.json")
    drop_damaged(work)
    assert there(work) == list(FILES)
    assert capsys.readouterr().err == ""


def test_what_no_job_left_goes_where_only_jobs_write(work):
    """A result that was put there by hand is none; a note beside the figures stays."""
    foreign = [of_no_job(work, name) for name in ("results/y.json", "judged/p.json")]
    kept = [of_no_job(work, name) for name in ("code.json", "notes.json", "logs/x.log")]
    drop_damaged(work)
    assert not any(path.exists() for path in foreign)
    assert all(path.exists() for path in kept)
    assert there(work) == list(FILES)
