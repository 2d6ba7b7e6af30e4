"""One command rebuilds exactly what a change reaches, and says why."""

import fcntl
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path
from textwrap import dedent

import pytest
import yaml

from tests.raxel.lab.test_rig import small_rig
from tests.verify import products

ROOT = Path(__file__).resolve().parents[3]
RIG = "data/rigs/small.yaml"
PAGE = "chapters/ch02_small/s1_dice/page.py"
CHAPTER = '''
# %% [markdown]
# # Dice
#
# A sentence that may change.

# %%
from repro.run.marks import experiment, figure
from repro.run.outcomes import Drawing, Plan
from repro.run.rendered import rendered_set
from repro.page.reader import show
from raxel.dice import spread, throw


def thrown(condition, rng):
    """One throw."""
    return {"eyes": throw(rng)}


def wide(condition, rng):
    """Spread of throws."""
    return {"spread": spread(rng)}


@experiment("dice_throws", artefact="fig_2_3")
def throws(effort):
    return Plan(thrown, [{"dice": 1}], 4)


@experiment(
    "dice_spread", artefact="fig_2_3",
    rendered={"quick": ("small/3",), "full": ("small/3", "small/4")},
)
def spreads(effort):
    assert (rendered_set("small", 3) / "truth").is_dir()
    return Plan(wide, [{"dice": 2}], 4)


@experiment("dice_again", artefact="fig_2_3", needs=("dice_throws",))
def again(effort, results):
    pool = results["dice_throws"].column("eyes", dice=1)
    return Plan(lambda condition, rng: {"eyes": rng.choice(pool)}, [{"dice": 1}], 4)


@figure("fig_2_3", needs=("dice_again",), evidence="synthetic")
def fig_2_3(results):
    from repro.page.style import new_figure

    drawn, axes = new_figure()
    eyes = results["dice_again"].column("eyes", dice=1)
    axes.plot(range(4), eyes)
    axes.set_xlabel("Throw")
    axes.set_ylabel("Eyes")
    return Drawing(drawn, {"eyes": eyes}, "Eyes of four throws.")


# %% tags=["active-ipynb"]
# show("fig_2_3")
'''
DICE = '''
def throw(rng):
    """Eyes of one die."""
    return int(rng.integers(1, 7))


def spread(rng):
    return float(rng.integers(1, 7, 50).std())
'''


@pytest.fixture(scope="module")
def checkout(tmp_path_factory) -> Path:
    """A small checkout in a folder with spaces in its name."""
    return dice_checkout(tmp_path_factory.mktemp("work") / "a path with spaces")


def dice_checkout(root: Path) -> Path:
    """A checkout with one page, whose trials throw dice."""
    small_checkout(root)
    (root / PAGE).parent.mkdir(parents=True)
    (root / PAGE).parents[1].joinpath("__init__.py").write_text("")
    (root / PAGE).write_text(CHAPTER.lstrip())
    (root / "lib" / "raxel" / "dice.py").write_text(dedent(DICE))
    (root / RIG).parent.mkdir()
    (root / RIG).write_text(yaml.safe_dump(small_rig()))
    return root


@pytest.fixture(scope="module")
def first(checkout) -> tuple[set[str], str, dict[str, str]]:
    """The first build in it, with which all is made, and its products."""
    return *made(checkout), products(checkout)


COSTS = """effort,task,seconds,peak_mb,trials,pairs
quick,experiment/dice_again,100,100,4,4
"""


def small_checkout(root: Path) -> Path:
    """A checkout with everything except chapters and images."""
    ignored = shutil.ignore_patterns("*.egg-info")
    shutil.copytree(ROOT / "lib", root / "lib", ignore=ignored)
    (root / "lib/repro/workflow/costs.csv").write_text(COSTS)
    shutil.copytree(ROOT / "data" / "published", root / "data" / "published")
    single = (
        "Snakefile",
        "CITATION.cff",
        "environment.txt",
        "chapters/unfinished.yaml",
    )
    for name in single:
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, root / name)
    (root / "chapters" / "__init__.py").write_text("")
    return root


def build(root: Path, target: str = "ch02") -> tuple[int, str]:
    """Exit status and what the terminal shows."""
    with started(root, target) as process:
        text = process.communicate()[0]
    return process.returncode, text


def started(root: Path, target: str = "ch02", profile: str = "") -> subprocess.Popen:
    """A build in a session of its own; the folder of the checkout may have a Slurm."""
    folders = Path(sys.executable).parent, root / "slurm", os.environ["PATH"]
    environment = os.environ | {
        "PYTHONPATH": f"{root / 'lib'}{os.pathsep}{root}",
        "PATH": os.pathsep.join(map(str, folders)),
        "XDG_CACHE_HOME": str(root / ".cache"),
    }
    return subprocess.Popen(
        [
            sys.executable, "-m", "repro.workflow", target,
            "--effort", "quick", "--cores", "2", "--profile", profile,
        ],
        cwd=root, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        text=True, start_new_session=True,
    )  # fmt: skip


def made(root: Path, target: str = "ch02") -> tuple[set[str], str]:
    """Build; the tasks that it made, and what the terminal shows."""
    before = written(root)
    status, text = build(root, target)
    assert status == 0, text
    after = written(root)
    return {name for name in after if after[name] != before.get(name)}, text


def written(root: Path) -> dict[str, int]:
    """BuildTask -> when its record was written."""
    folders = {"figures/quick/records": "", "data/synthetic/.records": "set/"}
    return {
        f"{kind}{path.relative_to(root / folder).with_suffix('').as_posix()}":
        path.stat().st_mtime_ns
        for folder, kind in folders.items()
        for path in (root / folder).rglob("*.json")
    }  # fmt: skip


def edit(root: Path, name: str, old: str, new: str) -> None:
    text = (root / name).read_text()
    assert old in text
    (root / name).write_text(text.replace(old, new))


THROWS = {"experiment/dice_throws"}
SET = {"set/small/3"}
SPREAD = {"experiment/dice_spread"}
AGAIN = {"part/dice_again/0-of-2", "part/dice_again/1-of-2", "experiment/dice_again"}
PAGE_TASKS = {"judged/ch02_small/s1_dice", "notebook/ch02_small/s1_dice"}
REST = {"figure/fig_2_3"} | PAGE_TASKS

CUT = (
    "data/synthetic/small/3/view-001.png",
    "figures/quick/results/dice_again.json",
    "figures/quick/fig_2_3.csv",
    "figures/quick/judged/ch02_small/s1_dice.json",
    "report/build/quick/pages/ch02_small/s1_dice.ipynb",
)
# A byte of it is changed, neither its size nor its time.
FLIPPED = "figures/quick/results/dice_throws.json"


def eyes_thrown(root: Path) -> set[int]:
    """Eyes in the trials of the experiment that another one reads."""
    result = json.loads((root / "figures/quick/results/dice_throws.json").read_text())
    return {trial["values"]["eyes"] for trial in result["trials"]}


def test_disk_faults_are_named_and_the_next_build_continues(checkout, first):
    """The figures' folder is a disk for this test; what it hides comes back."""
    figures = checkout / "figures"
    disk = ["mount", "-t", "tmpfs", "raxel", figures]
    if subprocess.run(disk, check=False, capture_output=True).returncode:
        pytest.skip("needs the right to mount a file system")
    try:
        for change, reason in (
            ("ro", "Read-only file"),
            ("rw,size=40k", "No space left"),
        ):
            subprocess.run(["mount", "-o", f"remount,{change}", figures], check=True)
            status, text = build(checkout)
            assert status == 1
            line = text.strip().splitlines()[-1]
            assert line.startswith(f"make ch02: {figures}/quick: {reason}")
        subprocess.run(["mount", "-o", "remount,size=100m", figures], check=True)
        made(checkout)
        assert products(checkout) == first[-1]
    finally:
        subprocess.run(["umount", figures], check=True)


def test_change_rebuilds_dependent_files(checkout, first):
    tasks, text, _ = first
    assert tasks == THROWS | AGAIN | SET | SPREAD | REST, text
    again = json.loads((checkout / "figures/quick/results/dice_again.json").read_text())
    assert {t["values"]["eyes"] for t in again["trials"]} <= eyes_thrown(checkout)

    tasks, text = made(checkout)
    assert tasks == set()
    assert "Nothing changed" in text

    edit(checkout, PAGE, "A sentence that may change.", "Another sentence.")
    edit(checkout, "lib/raxel/dice.py", '"""Eyes of one die."""', '"""Eyes."""')
    tasks, text = made(checkout)
    assert tasks == {"notebook/ch02_small/s1_dice"}, text

    edit(checkout, "lib/raxel/dice.py", "1, 7))", "1, 5)) + 1")
    tasks, text = made(checkout)
    assert tasks == THROWS | AGAIN | REST, text
    assert "code or settings changed" in text

    view = checkout / "data/synthetic/small/3/view-000.png"
    before = view.read_bytes()
    edit(checkout, RIG, "9000", "8000")
    edit(checkout, PAGE, "Eyes of four throws.", "Four throws.")
    tasks, text = made(checkout)
    assert tasks == SET | SPREAD | REST, text
    assert view.read_bytes() != before
    assert not [*(checkout / "data/synthetic").rglob(".3*")]


def test_failing_job_is_reported_and_damaged_file_rebuilt(checkout, first):
    result = checkout / "figures/quick/results/dice_spread.json"
    before = json.loads(result.read_text())
    edit(checkout, "lib/raxel/dice.py", "1, 7, 50).std()", "1, 7, 50).std() / []")
    status, text = build(checkout)
    assert status != 0
    assert "FAILED: experiments: experiment/dice_spread" in text
    assert "in experiment/dice_spread" in text
    assert "TypeError" in text
    assert not result.exists() or json.loads(result.read_text()) == before
    edit(checkout, "lib/raxel/dice.py", " / []", "")
    whole = {name: (checkout / name).read_bytes() for name in (*CUT, FLIPPED)}
    for name in CUT:
        (checkout / name).write_bytes(whole[name][: len(whole[name]) // 2])
    flipped, stat = bytearray(whole[FLIPPED]), (checkout / FLIPPED).stat()
    flipped[len(flipped) // 2] ^= 1
    (checkout / FLIPPED).write_bytes(flipped)
    os.utime(checkout / FLIPPED, ns=(stat.st_atime_ns, stat.st_mtime_ns))
    tasks, text = made(checkout)
    assert tasks == THROWS | {"experiment/dice_again"} | SET | SPREAD | REST, text
    for name, content in whole.items():
        assert f"{name}: damaged; it will be made again\n" in text
        assert (checkout / name).read_bytes() == content, name
    assert json.loads(result.read_text()) == before


HOLD = """

def hold():
    import pathlib, subprocess
    pathlib.Path("begun").touch()
    subprocess.run(["sleep", "3600"])
"""


def in_session(leader: int) -> list[str]:
    """Commands that run in a session."""
    found = []
    for path in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            fields = (path / "stat").read_text().rpartition(")")[2].split()
            if int(fields[3]) == leader and fields[0] != "Z":
                found.append((path / "cmdline").read_text())
    return found


SLURM = {
    "sbatch": 'for script; do :; done; setsid "$script" >/dev/null 2>&1 & echo $!',
    "scontrol": 'kill -0 "$4" && s=RUNNING || s=COMPLETED; echo " JobState=$s "',
    "scancel": 'echo "$@" >>cancelled; for job; do kill -- "-$job"; done',
}
"""Commands that run jobs of Slurm on this machine, without a queue."""


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="asks /proc")
@pytest.mark.parametrize("profile", ["", "slurm"])
def test_interrupted_build_ends_cleanly(checkout, profile):
    for name, text in SLURM.items():
        path = checkout / "slurm" / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(f"#!/bin/sh\n{text}\n")
        path.chmod(0o755)
    (checkout / "begun").unlink(missing_ok=True)
    dice = checkout / "lib" / "raxel" / "dice.py"
    before = dice.read_text()
    held = before.replace("def throw(rng):", "def throw(rng):\n    hold()")
    dice.write_text(held + HOLD)
    with started(checkout, "fig_2_3", profile) as process:
        while not (checkout / "begun").exists() and process.poll() is None:
            time.sleep(0.05)
        os.killpg(process.pid, signal.SIGINT)
        text = process.communicate(timeout=900)[0]
    dice.write_text(before)
    assert process.returncode == 130, text
    last = (
        "make fig_2_3: interrupted; run it again to continue (finished parts are kept)"
    )
    assert text.splitlines()[-1] == last
    assert "Traceback" not in text
    assert "FAILED" not in text
    assert in_session(process.pid) == []
    for job in (checkout / "cancelled").read_text().split() if profile else ():
        while in_session(int(job)):
            time.sleep(0.05)
    assert not [*(checkout / "figures").rglob(".*")]


def test_second_build_in_checkout_is_rejected(checkout):
    with (checkout / ".cache" / "build.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        status, text = build(checkout)
    assert status == 1
    assert text == "make ch02: another build runs in this folder; wait for it\n"


def test_unknown_target_is_rejected_in_one_line(checkout):
    status, text = build(checkout, "fig_2_33")
    assert status == 1
    (line,) = text.strip().splitlines()
    assert "did you mean fig_2_3?" in line


def test_figure_with_scene_has_one_more_file(checkout):
    edit(checkout, PAGE, 'evidence="synthetic")', 'evidence="synthetic", scene=True)')
    scene = 'Scene([Points([[0, 0, 0]], "k")], (0, 0, -5), (0, 0, 1))'
    edit(checkout, PAGE, 'throws.")', f'throws.", scene={scene})')
    edit(
        checkout,
        PAGE,
        "from repro.page.reader import",
        "from raxel.show import Points, Scene\nfrom repro.page.reader import",
    )
    tasks, text = made(checkout, "fig_2_3")
    assert "figure/fig_2_3" in tasks, text
    page = (checkout / "figures" / "quick" / "fig_2_3.html").read_text()
    assert re.search(r"<title>Fig. 2.3 .*throws.</title>", page)

    viewer = checkout / "lib/raxel/show/page.js"
    viewer.write_text(viewer.read_text() + "// A word more.\n")
    tasks, text = made(checkout, "fig_2_3")
    assert tasks == {"figure/fig_2_3"}, text


def test_results_are_independent_of_number_of_jobs(checkout, first):
    result = checkout / "figures/quick/results/dice_again.json"
    before = result.read_bytes()
    edit(checkout, "lib/repro/workflow/costs.csv", "dice_again,100", "dice_again,150")
    parts = {f"part/dice_again/{i}-of-3" for i in range(3)}
    tasks, text = made(checkout, "fig_2_3")
    assert tasks == parts, text
    assert "not needed" in next(checkout.rglob("logs/experiments/*0-of-3*")).read_text()
    result.unlink()
    tasks, _ = made(checkout, "fig_2_3")
    assert tasks == {"experiment/dice_again"} | parts
    assert result.read_bytes() == before
