"""What was cut or edited by hand is removed with one line, and so made again."""

import json
import os
from pathlib import Path

import pytest

from repro.run import results
from repro.run.jobs import Size
from repro.run.results import WRITTEN, write_atomic, write_json
from repro.site.mirror import mirror
from repro.workflow import records
from repro.workflow.plan import BuildPlan, BuildTask

FILES = ("figures/quick/x.json", "figures/quick/x.csv", "figures/quick/x.npz")
SITE = Path("report/site-quick")


@pytest.fixture
def plan(tmp_path, monkeypatch):
    """A plan of two tasks, of which one has left three files, and one a site."""
    monkeypatch.chdir(tmp_path)

    def drawn():
        for name in FILES:
            write_atomic(Path(name), "{}")

    def site():
        mirror({"index.html": "<p>", "a.html": "<b>"}, SITE)

    figure = BuildTask("figure/x", "pages", drawn, lambda: "1")
    whole = BuildTask("site", "report", site, lambda: "2", ("figure/x",))
    plan = BuildPlan(tmp_path, Size("quick"))
    plan.tasks = {task.name: task for task in (figure, whole)}
    for task in plan.tasks.values():
        before = len(WRITTEN)
        task.make()
        needs = records.digests(plan, task.needs)
        records.write(plan, task, needs, {"seconds": 1}, WRITTEN[before:])
    for job in plan.jobs.values():
        write_json(tmp_path / plan.marker(job), {})
    return plan


def there(plan):
    return [name for name in FILES if (plan.root / name).is_file()]


def state(plan):
    """BuildTask -> whether it is fresh, and whether its job has its marker."""
    return {
        task.name: (
            records.fresh(plan, task),
            (plan.root / plan.marker(plan.job_of[task.name])).is_file(),
        )
        for task in plan.tasks.values()
    }


FRESH = {"figure/x": (True, True), "site": (True, True)}


@pytest.mark.parametrize("dates", [None, (1, 1)])
def test_unchanged_files_are_kept(plan, capsys, dates):
    for name in FILES if dates else ():
        os.utime(plan.root / name, ns=dates)
    records.drop_damaged(plan)
    assert there(plan) == list(FILES)
    assert state(plan) == FRESH
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("content", ["", "{", "[]", None])
def test_changed_file_is_removed_with_its_record(plan, capsys, content):
    damaged = plan.root / FILES[2]
    before = damaged.stat()
    damaged.unlink() if content is None else damaged.write_text(content)
    if content == "[]":  # flipped bits on the disk change neither size nor time
        os.utime(damaged, ns=(before.st_atime_ns, before.st_mtime_ns))
        results._hash.cache_clear()
    assert not records.fresh(plan, plan.tasks["figure/x"])
    records.drop_damaged(plan)
    assert there(plan) == list(FILES[:2])
    assert state(plan) == {"figure/x": (False, False), "site": (False, True)}
    lines = capsys.readouterr().err.splitlines()
    assert [line.split(":")[0] for line in lines] == [FILES[2]][: content is not None]
    records.drop_damaged(plan)
    assert capsys.readouterr().err == ""


def test_changed_key_or_input_is_not_fresh(plan):
    task = plan.tasks["site"]
    changed = BuildTask(task.name, task.stage, task.make, lambda: "3", task.needs)
    assert records.fresh(plan, task)
    assert not records.fresh(plan, changed)
    write_atomic(Path(FILES[1]), "1,2")
    figure = plan.tasks["figure/x"]
    records.write(plan, figure, {}, {}, [Path(name) for name in FILES])
    assert records.fresh(plan, figure)
    assert not records.fresh(plan, task)


@pytest.mark.parametrize(
    "content",
    [
        *("", "[]", '{"files": {"figu'),
        json.dumps({"key": "1", "digest": "1", "files": {"../kept.txt": [2, 1, "0"]}}),
        json.dumps(
            {"key": "1", "digest": "1", "files": {"figures/../README.md": [2, 1, "0"]}}
        ),
    ],
)
def test_damaged_record_removes_only_marker(plan, content):
    write_atomic(plan.root / "README.md", "kept")
    marker = plan.root / plan.marker(plan.job_of["figure/x"])
    before = {*plan.root.rglob("*")} - {marker}
    plan.record("figure/x").write_text(content)
    records.drop_damaged(plan)
    assert {*plan.root.rglob("*")} == before
