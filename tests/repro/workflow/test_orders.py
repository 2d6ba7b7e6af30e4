"""Plans of commands such as `make ch02`, and their jobs."""

import csv
from pathlib import Path

import pytest

from repro.run import discover
from repro.run.jobs import Size
from repro.workflow import costs
from repro.workflow.build import OrderError, _build, _checked_scale, _parser, main
from repro.workflow.plan import SCALED_S, STAGES, BuildPlan, planned
from tests.sample_files import write

ROOT = Path(__file__).resolve().parents[3]
MOST_JOBS = {"quick": 80, "full": 250}


@pytest.fixture(scope="module", params=["quick", "full"])
def plan(request):
    return BuildPlan(ROOT, Size(request.param))


@pytest.mark.parametrize("chapter", ["ch02", "appendix_a"])
def test_chapter_target_has_pages(chapter):
    final = BuildPlan(ROOT, Size("quick"), target=chapter).final
    assert final
    assert all(name.startswith(f"notebook/{chapter}") for name in final)


@pytest.mark.parametrize(
    ("order", "reason"),
    [
        ("ch77", "no page of chapter 77"),
        ("ch2", "ch2: no such chapter; give ch02"),
        ("appendix_z", "no page of appendix Z"),
        ("chapter", "chapter: no such figure or table"),
        ("ch02 --trials 5", "TRIALS: only for one artefact"),
        (
            "ch02 --profile pbs",
            "PROFILE=pbs: no such profile; give slurm, slurm-plugin",
        ),
        ("fig_2_3 --trials 5 --scale 2", "SCALE: not together with TRIALS"),
        ("fig_2_3 --trials ²", "TRIALS=²: not a whole number above 0"),
        ("ch02 --cores 0", "CORES=0: not a whole number above 0"),
        ("ch02 --cores -2", "CORES=-2: not a whole number above 0"),
        ("ch02 --cores 1.5", r"CORES=1\.5: not a whole number above 0"),
    ],
)
def test_unknown_target_is_rejected(order, reason):
    with pytest.raises(OrderError, match=reason):
        _build(ROOT, _parser().parse_args(order.split()))


@pytest.mark.parametrize(
    ("file", "line"),
    [
        (
            "data/published/artefacts.yaml",
            "artefacts.yaml: line 1: expected the node content, but found ']'; "
            "correct the YAML",
        ),
        (
            "chapters/ch02/s1/page.py",
            "{}/chapters/ch02/s1/page.py:1: not Python; correct it",
        ),
    ],
)
def test_damaged_source_is_named_in_one_line(tmp_path, monkeypatch, capsys, file, line):
    write(tmp_path / "chapters/ch02/s1/page.py", "")
    write(tmp_path / file, "a: ]")
    monkeypatch.chdir(tmp_path)
    assert main(["ch02", "--cores", "1"]) == 1
    assert capsys.readouterr().err == f"make ch02: {line.format(tmp_path)}\n"


def test_profile_needs_slurm(monkeypatch):
    monkeypatch.setenv("PATH", "")
    with pytest.raises(OrderError, match="PROFILE=slurm: no sbatch; use a login node"):
        _build(ROOT, _parser().parse_args(["ch02", "--profile", "slurm"]))


@pytest.mark.parametrize("given", ["0", "-1", "1.5", "x"])
def test_scale_is_a_whole_number(given):
    with pytest.raises(OrderError, match=f"SCALE={given}: not a whole number"):
        _checked_scale(given, None)


def test_plan_lists_chapters_once(monkeypatch):
    listings = []
    producers = discover.producers
    monkeypatch.setattr(
        discover, "producers", lambda root: listings.append(root) or producers(root)
    )
    plan = BuildPlan(ROOT, Size("quick"))
    assert plan.jobs
    assert all(plan.key(job) for job in list(plan.jobs.values())[-3:])
    assert listings == [ROOT]


def test_site_follows_stubs(plan):
    assert "lib/raxel/cameras/__init__.pyi" in plan.site_sources()


def test_rules_share_plan_of_command():
    planned.cache_clear()
    given = (ROOT, Size("quick"), "", "report", "open")
    assert planned(*given) is planned(*given)


def test_jobs_are_few_and_run_each_task_once(plan):
    assert len(plan.jobs) <= MOST_JOBS[plan.size.effort]
    tasks = [task.name for job in plan.jobs.values() for task in job.tasks]
    assert sorted(tasks) == sorted(set(plan.tasks) - {"notebooks"})
    place = {name: i for i, name in enumerate(plan.tasks)}
    for job in plan.jobs.values():
        assert [place[t.name] for t in job.tasks] == sorted(
            place[t.name] for t in job.tasks
        )


def test_jobs_wait_for_all_that_they_read(plan):
    """Every need of a task is made earlier in its job, or in a job of an earlier
    wave."""
    done: set[str] = set()
    waiting = list(plan.jobs.values())
    while waiting:
        ready = [job for job in waiting if all_there(job, done)]
        assert ready, [job.title for job in waiting]
        done |= {task.name for job in ready for task in job.tasks}
        waiting = [job for job in waiting if job not in ready]
    for job in plan.jobs.values():
        markers = set(plan.before(job))
        for need in (need for task in job.tasks for need in task.needs):
            other = plan.job_of[need]
            assert other is job or plan.marker(other) in markers


def all_there(job, done):
    have = set(done)
    for task in job.tasks:
        if not set(task.needs) <= have:
            return False
        have.add(task.name)
    return True


def test_stages_are_those_of_the_rules(plan):
    assert {job.stage for job in plan.jobs.values()} <= set(STAGES)


def test_scaled_jobs_take_minutes_and_names_do_not_collide():
    plan, scaled = (
        BuildPlan(ROOT, Size("full")),
        BuildPlan(ROOT, Size("full", None, 100)),
    )
    assert scaled.base == "figures/what-if/full-scale-100"
    for found in scaled.made:
        cost = scaled.costs.get(f"experiment/{found.id}")
        if found.kind != "experiment" or cost is None:
            continue
        if scaled.size.trials_of(found, cost.trials) == cost.trials:
            continue
        parts = scaled.parts(found)
        assert parts >= plan.parts(found)
        seconds = cost.seconds * scaled.size.trials_of(found, cost.trials) / cost.trials
        pairs = cost.pairs * scaled.size.trials_of(found, cost.trials) / cost.trials
        assert seconds / parts <= 2 * SCALED_S * 1.5 or parts == pairs, found.id


def test_every_task_has_a_measured_cost():
    """A build after a change of the chapters plans its jobs by measurement."""
    with (ROOT / costs.TABLE).open(encoding="utf-8") as file:
        known = {(row["effort"], row["task"]) for row in csv.DictReader(file)}
    for effort in ("quick", "full"):
        tasks = set(BuildPlan(ROOT, Size(effort)).tasks) - {"notebooks"}
        tasks = {name for name in tasks if not name.startswith(("part/", "recorded/"))}
        missing = {name for name in tasks if (effort, name) not in known}
        assert len(missing) < len(tasks) / 10, sorted(missing)[:5]
