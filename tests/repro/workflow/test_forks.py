"""Jobs forked from a warm process do what a process of their own does."""

import json
import os
import re
import socket
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

import pytest

from repro.workflow.forks import ADDRESS, END, PINNED, READING, warm_jobs

ROOT = Path(__file__).resolve().parents[3]
# Seconds after which a test gives up: none of what is waited for takes long anywhere.
FOREVER = 900
ASK = ROOT / "lib" / "repro" / "workflow" / "ask.py"
SAMPLE = """
import os, subprocess, sys, time

def main(words):
    if words[0] == "say":
        print(os.getcwd(), os.environ["THESIS_SCENE"], *words[1:])
        print("aside", file=sys.stderr)
        return 0
    if words[0] == "sleep":
        print(os.getpid(), flush=True)
        time.sleep(3600)
    if words[0] == "half":
        from raxel.io.files import replacing

        with replacing("whole.json") as temporary:
            temporary.write_text("{")
            waiting = subprocess.Popen(["sleep", "3600"])
            print(waiting.pid, flush=True)
            waiting.wait()
    if words[0] == "die":
        os._exit(3)
    if words[0] == "raise":
        raise ValueError("wrong")
    sys.exit(int(words[1]))

if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with a command, and a name that needs quoting."""
    folder = tmp_path_factory.mktemp("a folder")
    (folder / "sample.py").write_text(SAMPLE)
    return folder


@pytest.fixture(scope="module", params=["forked", "its own process"])
def ask(request, folder):
    """Starts a job in the folder; both ways must not differ."""
    environment = (
        os.environ
        | PINNED
        | {
            "PYTHONPATH": os.pathsep.join([str(ROOT / "lib"), str(folder)]),
            "THESIS_SCENE": "a = b",
            "RAXEL_TIMES": str(folder / "times"),
        }
    )

    def start(*words, **more):
        return subprocess.Popen(
            [sys.executable, "-I", "-S", str(ASK), "page/label", "sample", *words],
            cwd=folder, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
            env=environment | {ADDRESS: os.environ.get(ADDRESS, "")} | more,
        )  # fmt: skip

    if request.param == "its own process":
        yield start
        return
    before = os.environ.get("PYTHONPATH")
    os.environ["PYTHONPATH"] = environment["PYTHONPATH"]
    with warm_jobs():
        yield start
    os.environ.pop("PYTHONPATH") if before is None else os.environ.update(
        PYTHONPATH=before
    )


def test_job_gets_folder_arguments_environment_streams(ask, folder):
    job = ask("say", "two words", "", 'quo"te')
    output, aside = job.communicate(timeout=FOREVER)
    assert job.returncode == 0, aside
    assert output == f'{folder} a = b two words  quo"te\n'
    assert aside == "aside\n"
    took = json.loads((folder / "times" / "page" / "label.json").read_text())
    assert took["processor_seconds"] >= 0
    assert set(took) == {"seconds", "processor_seconds", "peak_mb"}


@pytest.mark.parametrize(
    ("words", "status", "reason"),
    [(("leave", "7"), 7, ""), (("raise",), 1, "ValueError: wrong")],
)
def test_failed_job_returns_status(ask, folder, words, status, reason):
    (folder / "times" / "page" / "label.json").unlink(missing_ok=True)
    job = ask(*words)
    _, aside = job.communicate(timeout=FOREVER)
    assert job.returncode == status
    assert reason in aside
    assert not (folder / "times" / "page" / "label.json").exists()


def test_job_ends_with_requesting_process(ask):
    job = ask("sleep")
    number = int(job.stdout.readline())
    job.kill()
    job.wait()
    end = time.monotonic() + FOREVER
    while Path(f"/proc/{number}").exists() and time.monotonic() < end:
        time.sleep(0.02)
    assert not Path(f"/proc/{number}").exists()


BARE = """
import sys, time
from repro.workflow import forks

forks.WARM, forks._run_once, forks.GRACE_S = (), lambda: SLOWLY, 900
forks.serve(int(sys.argv[1]))
"""
BUSY = "[print(flush=True), time.sleep(3600)]"


@contextmanager
def bare_server(folder, ahead="None"):
    """A server without imports that listens at `jobs` in the folder, and what asks it
    for a job."""
    (folder / "sample.py").write_text(SAMPLE)
    paths = os.pathsep.join([str(ROOT / "lib"), str(folder)])
    environment = os.environ | {"PYTHONPATH": paths, ADDRESS: str(folder / "jobs")}
    environment.pop("RAXEL_TIMES", None)
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(environment[ADDRESS])
        listener.listen()
        server = subprocess.Popen(
            [
                sys.executable, "-c", BARE.replace("SLOWLY", ahead),
                str(listener.fileno()),
            ],
            cwd=folder, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            env=environment, pass_fds=[listener.fileno()],
        )  # fmt: skip

    def ask(*words):
        return subprocess.Popen(
            [sys.executable, "-I", "-S", str(ASK), *words],
            cwd=folder, text=True, stdout=subprocess.PIPE, env=environment,
        )  # fmt: skip

    yield server, ask


def ended_and_left_nothing(job, folder):
    return job.wait(timeout=FOREVER) != 0 and not [*folder.rglob("whole.json")]


def test_importing_server_ends_immediately(tmp_path):
    with bare_server(tmp_path, BUSY) as (server, ask):
        job = ask("kind/label", "sample", "half")
        server.stdout.readline()
        server.send_signal(END)
        assert server.wait(timeout=FOREVER) == 1
        assert ended_and_left_nothing(job, tmp_path)


def test_reading_jobs_do_not_wait_for_compute_imports(tmp_path):
    with bare_server(tmp_path, BUSY) as (server, ask):
        job = ask("page/label", "sample", "half")
        assert int(job.stdout.readline()) > 0
        server.send_signal(END)
        assert server.wait(timeout=FOREVER) == 1
        assert server.stdout.read() == b""
        assert ended_and_left_nothing(job, tmp_path)


def test_reading_jobs_exist_in_rules():
    rules = (ROOT / "lib/repro/workflow/rules").glob("*.smk")
    text = "\n".join(path.read_text("utf-8") for path in rules)
    labels = set(re.findall(r'"\(?job ([a-z]+)[/ ]', text))
    assert labels - set(READING) == {"experiment", "figure"}
    assert set(READING) < labels


@pytest.mark.parametrize("how", ["the build is gone", "it says so"])
def test_jobs_end_with_build(tmp_path, how):
    with bare_server(tmp_path) as (server, ask):
        job = ask("kind/label", "sample", "half")
        started = Path("/proc") / job.stdout.readline().strip()
        assert len(list(tmp_path.glob(".*/whole.json"))) == 1
        if how == "the build is gone":
            server.stdin.close()
        else:
            server.send_signal(END)
        assert server.wait(timeout=FOREVER) == (how != "the build is gone")
        assert ended_and_left_nothing(job, tmp_path)
    assert not started.exists() or "Z" in (started / "stat").read_text().split()[2]


def test_no_job_starts_after_interruption(folder):
    with warm_jobs() as end:
        end()
        environment = os.environ | {"PYTHONPATH": str(folder), "THESIS_SCENE": ""}
        asked = [sys.executable, "-I", "-S", str(ASK), "kind/label", "sample", "say"]
        job = subprocess.run(asked, env=environment, capture_output=True, check=False)
    assert (job.returncode, job.stdout) == (1, b"")
