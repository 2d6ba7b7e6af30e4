"""One warm process for a build, which is forked for each job.

Small jobs spend half of their time on importing numpy, OpenCV and matplotlib. This
process imports them once and is forked for each job. Imports that only some jobs need
are delayed until the first of these: after a changed sentence nothing is computed.

    python -m repro.workflow.forks DESCRIPTOR

The server and its jobs end when its standard input closes, so that nothing outlives the
build. `lib/repro/workflow/ask.py` sends it a job. Without a server (on a cluster, or
from Snakemake's command line) it starts an interpreter for the job instead.
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
"""Environment of every job: the workflow assigns the cores, and sums are
reproducible."""

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
"""Module and function to run once for all jobs: for pages, a schema is compiled; for
figures and experiments, fonts and compiled loops are loaded."""
READING = ("judge", "notebooks", "page", "result", "scoreboard", "site", "table")
"""Kinds of jobs (first words of their labels) that only read results: they need neither
rendering nor compiled loops."""

END = signal.SIGUSR1
GRACE_S = 2.0
RUNNING: set[int] = set()
"""Jobs of this server, each the leader of its own process group."""


@contextmanager
def warm_jobs() -> Iterator[Callable[[], None]]:
    """Run a server for the jobs that are started inside; they find it through the
    environment.

    Yields a function that ends the server and the running jobs early.
    """
    # The path of a socket has to be short; that of the checkout may be long.
    with tempfile.TemporaryDirectory(prefix="raxel-") as folder:
        address = str(Path(folder) / "jobs")
        # It listens before the server starts, so that the first job finds it.
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
    """A requested job: its streams, folder, arguments and variables."""

    streams: list[int]
    folder: str
    words: list[str]
    variables: list[str]


def serve(descriptor: int) -> None:
    """Fork a job for each request at a listening socket, until standard input ends."""
    listener = socket.socket(fileno=descriptor)
    for number in SIGNALS:  # the build receives them, and ends the jobs
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
        with suppress(OSError):  # the job may have done so already, or have ended
            os.setpgid(number, number)
        RUNNING.add(number)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGCHLD, END])
        for stream in request.streams:
            os.close(stream)
        connection.close()
    _end_jobs()


def _asked(listener: socket.socket) -> bool:
    """Wait for the next request; return False if the build has ended.

    Nothing is imported before the first one: a build may have nothing to do.
    """
    ready, _, _ = select.select([listener, sys.stdin], [], [])
    return sys.stdin not in ready


def _reap(number: int, frame: object) -> None:
    """Collect ended jobs: their processor time counts as that of this process."""
    with suppress(ChildProcessError):
        while ended := os.waitpid(-1, os.WNOHANG)[0]:
            RUNNING.discard(ended)


def _end(number: int, frame: object) -> None:
    """End early, also during imports or compilation."""
    _end_jobs()
    os._exit(1)


def _end_jobs() -> None:
    """Ask the running jobs and their children to end; then kill them."""
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
    """The request; None if the requesting process has ended meanwhile."""
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
    """Import what jobs of this kind need, at the first of them."""
    # Do not collect a process that an import starts and waits for.
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
    with suppress(LedgerError):  # left to the job that needs it
        load(Path.cwd())
    _keep_apart()


@cache
def _run_once() -> None:
    """Import the chapters, load fonts, and load or compile the loops, once."""
    _imported(WARMER)
    _imported(sorted({one.module for one in discover.producers(Path.cwd())}))
    _called(COMPUTING)
    _keep_apart()


def _imported(names: Iterable[str]) -> None:
    """Import modules. The job reports a broken one."""
    for name in names:
        try:
            importlib.import_module(name)
        except Exception:
            traceback.print_exc()


def _called(functions: Iterable[tuple[str, str]]) -> None:
    """Call functions of modules. The job reports a failing one."""
    for module, name in functions:
        try:
            getattr(importlib.import_module(module), name)()
        except Exception:
            traceback.print_exc()


def _keep_apart() -> None:
    """Exclude present objects from garbage collection: jobs share their memory."""
    gc.collect()
    gc.freeze()


def _job(connection: socket.socket, request: Request) -> None:
    """Take over the streams, folder and environment of the requesting process."""
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
    """End this job and its children when the requesting process has ended."""
    connection.recv(1)
    os.killpg(0, signal.SIGKILL)


def _leave(number: int, frame: object) -> None:
    """End the job; unfinished files are removed."""
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
