"""One warm process for a build, which is forked for each job.

Half of the work of many small jobs is to import numpy, OpenCV and matplotlib again.
Here they are imported once, and a job begins where that has been done. What only some
jobs need waits for the first of these: after a changed sentence nothing is computed.

    python -m repro.workflow.forks DESCRIPTOR

The server ends when its standard input does, and its jobs with it, so that nothing
outlives the build, however that ends.
`lib/repro/workflow/ask.py` hands it a job; without a server (on a cluster, or from
Snakemake's own command line) that starts an interpreter for the job instead.
"""

from __future__ import annotations

import gc
import importlib
import os
import select
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import traceback
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import NamedTuple

from repro.judge.ledger import LedgerError, load
from repro.run import discover
from repro.workflow import job
from repro.workflow.interruption import SIGNALS

PINNED = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "OPENCV_FOR_THREADS_NUM": "1",
    "PYTHONHASHSEED": "0",
    "MPLBACKEND": "Agg",
}
"""Of every job: the cores are shared out by the workflow, and sums stay the same."""

ADDRESS = "RAXEL_JOBS"
WARM = (
    "cv2", "jupytext", "matplotlib.figure", "nbformat", "numpy", "scipy.ndimage",
    "scipy.optimize", "scipy.spatial", "scipy.stats", "IPython.core.interactiveshell",
    "raxel.calibration", "raxel.evaluation", "repro.run.judging", "repro.page.draw",
    "repro.page.execute",
)  # fmt: skip
WARMER = (
    "PIL.ImageDraw", "PIL.ImageFont", "aiohttp.web", "nest_asyncio2",
    "pyvista.plotting", "scipy.signal", "trame.widgets.dataclass", "trame.widgets.rca",
    "trame_pyvista.jupyter", "trame_vtk.modules.vtk.protocols",
    "trame_vtk.modules.vtk.serializers", "wslink.backends.aiohttp", "wslink.protocol",
)  # fmt: skip
VALIDATING = (("nbformat.v4", "new_markdown_cell"),)
COMPUTING = ("repro.page.style", "draw_ahead"), ("raxel.compile_loops", "compile_loops")
"""Module and function of what is run once for all jobs: for pages, a schema becomes
code; for figures and experiments, fonts and compiled loops are loaded."""
READING = ("judge", "notebooks", "page", "result", "scoreboard", "site", "table")
"""Kinds of jobs, the first words of their labels, that read results and no more: they
render nothing and run no compiled loop that would be worth to load before them."""

END = signal.SIGUSR1
GRACE_S = 2.0
RUNNING: set[int] = set()
"""Jobs of this server, each the leader of a process group of its own."""


@contextmanager
def warm_jobs() -> Iterator[Callable[[], None]]:
    """Run a server for the jobs that are started inside; they find it by themselves.

    Gives what ends the server, and the jobs that run, before their time.
    """
    # A socket's path has to be short, which the checkout's may not be.
    with tempfile.TemporaryDirectory(prefix="raxel-") as folder:
        address = str(Path(folder) / "jobs")
        # It listens before the server does: the first job finds it, however slow that.
        with socket.socket(socket.AF_UNIX) as listener:
            listener.bind(address)
            listener.listen(64)
            number = listener.fileno()
            server = subprocess.Popen(
                [sys.executable, "-m", "repro.workflow.forks", str(number)],
                stdin=subprocess.PIPE,
                env={**os.environ, **PINNED},
                pass_fds=[number],
            )
        os.environ[ADDRESS] = address

        def end() -> None:
            Path(f"{address}.ended").touch()
            server.send_signal(END)

        try:
            yield end
        finally:
            del os.environ[ADDRESS]
            server.stdin.close()
            server.wait()


class Request(NamedTuple):
    """A job that is asked for: where it writes to, its folder, words and variables."""

    streams: list[int]
    folder: str
    words: list[str]
    variables: list[str]


def serve(descriptor: int) -> None:
    """Fork a job for each request at a listening socket, until standard input ends."""
    listener = socket.socket(fileno=descriptor)
    for number in SIGNALS:  # the build hears them, and ends what has to end
        signal.signal(number, signal.SIG_IGN)
    signal.signal(END, _end)
    signal.signal(signal.SIGCHLD, _reap)
    while _asked(listener):
        connection, _ = listener.accept()
        request = _request(connection)
        if request is None:
            connection.close()
            continue
        _get_ready(request.words[0])
        signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGCHLD, END])
        number = os.fork()
        if number == 0:
            listener.close()
            _job(connection, request)
        with suppress(OSError):  # the job may be as far already, or have ended
            os.setpgid(number, number)
        RUNNING.add(number)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGCHLD, END])
        for stream in request.streams:
            os.close(stream)
        connection.close()
    _end_jobs()


def _asked(listener: socket.socket) -> bool:
    """Wait for the next request; False where the build has ended instead.

    Nothing is imported before the first one: a build may have nothing to do.
    """
    ready, _, _ = select.select([listener, sys.stdin], [], [])
    return sys.stdin not in ready


def _reap(number: int, frame: object) -> None:
    """Wait for the jobs that have ended: their processor time counts as this one's."""
    with suppress(ChildProcessError):
        while ended := os.waitpid(-1, os.WNOHANG)[0]:
            RUNNING.discard(ended)


def _end(number: int, frame: object) -> None:
    """End before the time, whatever is being imported or compiled."""
    _end_jobs()
    os._exit(1)


def _end_jobs() -> None:
    """Ask the jobs that run to end, with all that they have started; then end them."""
    last = time.monotonic() + GRACE_S
    _signal_jobs(signal.SIGTERM)
    while RUNNING and time.monotonic() < last:
        time.sleep(0.01)
    _signal_jobs(signal.SIGKILL)


def _signal_jobs(number: int) -> None:
    for leader in tuple(RUNNING):
        with suppress(ProcessLookupError):
            os.killpg(leader, number)


def _request(connection: socket.socket) -> Request | None:
    """What is asked for; None where the process that asks has ended meanwhile."""
    try:
        head, streams, _, _ = socket.recv_fds(connection, 8, 2)
        asked = _received(connection, int.from_bytes(head, "big"))
    except ConnectionError:
        return None
    if not asked:
        return None
    folder, count, *rest = os.fsdecode(asked).split("\0")
    return Request(streams, folder, rest[: int(count)], rest[int(count) :])


def _received(connection: socket.socket, size: int) -> bytes:
    received = b""
    while len(received) < size:
        part = connection.recv(size - len(received))
        if not part:
            raise ConnectionError
        received += part
    return received


def _get_ready(label: str) -> None:
    """Import what this job and its like need, where none of them came before."""
    # A process that an import starts and waits for is not taken from it.
    signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGCHLD])
    _import_ahead()
    if label.partition("/")[0] not in READING:
        _run_once()
    signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGCHLD])


@cache
def _import_ahead() -> None:
    """Import what every job needs, list the producers and read the ledger."""
    _imported(WARM)
    _called(VALIDATING)
    discover.producers(Path.cwd())
    with suppress(LedgerError):  # left for the job that needs it
        load(Path.cwd())
    _keep_apart()


@cache
def _run_once() -> None:
    """Import the chapters, load fonts, and compiled loops or compile them, once."""
    _imported(WARMER)
    _imported(sorted({one.module for one in discover.producers(Path.cwd())}))
    _called(COMPUTING)
    _keep_apart()


def _imported(names: Iterable[str]) -> None:
    """Import modules. One that is broken is left for its job to report."""
    for name in names:
        try:
            importlib.import_module(name)
        except Exception:
            traceback.print_exc()


def _called(functions: Iterable[tuple[str, str]]) -> None:
    """Call functions of modules. One that fails is left for its job to report."""
    for module, name in functions:
        try:
            getattr(importlib.import_module(module), name)()
        except Exception:
            traceback.print_exc()


def _keep_apart() -> None:
    """What is there now is never collected: jobs share its memory with this process."""
    gc.collect()
    gc.freeze()


def _job(connection: socket.socket, request: Request) -> None:
    """Take the place of the process that asks: its streams, folder and environment."""
    os.setpgid(0, 0)
    for number in (signal.SIGCHLD, END):
        signal.signal(number, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGCHLD, END])
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    signal.signal(signal.SIGTERM, _leave)
    for own, given in zip((1, 2), request.streams, strict=True):
        os.dup2(given, own)
        os.close(given)
    os.environ.clear()
    os.environ.update(pair.split("=", 1) for pair in request.variables)
    os.chdir(request.folder)
    threading.Thread(target=_end_with, args=(connection,), daemon=True).start()
    status = _status(request.words)
    for stream in (sys.stdout, sys.stderr):
        stream.flush()
    connection.sendall(bytes([status]))
    os._exit(status)


def _end_with(connection: socket.socket) -> None:
    """End this job, and what it started, when the process that asked for it is gone."""
    connection.recv(1)
    os.killpg(0, signal.SIGKILL)


def _leave(number: int, frame: object) -> None:
    """Give up: nothing half written stays behind."""
    signal.signal(number, signal.SIG_IGN)
    raise SystemExit(128 + number)


def _status(words: list[str]) -> int:
    try:
        return job.run(words)
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else int(end.code is not None)
    except BaseException:
        traceback.print_exc()
        return 1


if __name__ == "__main__":
    serve(int(sys.argv[1]))
