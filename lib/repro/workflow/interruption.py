"""Ctrl-C, or the end of a session: stop a build immediately and cleanly."""

from __future__ import annotations

import logging
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import psutil

from repro.workflow.terminal import say

SIGNALS = (signal.SIGINT, signal.SIGTERM)
GRACE_S = 2.0


@contextmanager
def stopped_by_signals(on_cluster: bool = False) -> Iterator[None]:
    """Raise KeyboardInterrupt(number) at the end if a signal arrived meanwhile.

    It is not raised immediately, because a lock of Snakemake would remain locked. The
    jobs are ended, so Snakemake soon finishes; after a failed job it starts no other.
    Its messages about that are suppressed. A second signal ends the process.

    Jobs on a cluster are no processes of this machine: there Snakemake itself is
    interrupted, also between two submissions, and cancels them.
    """
    heard: list[int] = []

    def hear(number: int, frame: object) -> None:
        heard.append(number)
        for one in SIGNALS:
            signal.signal(one, signal.SIG_DFL)
        logging.disable(logging.CRITICAL)
        if on_cluster:
            say("cancelling the jobs on the cluster")
            raise KeyboardInterrupt
        end_jobs()

    before = {one: signal.signal(one, hear) for one in SIGNALS}
    try:
        with _heard_by_snakemake(hear):
            yield
    except BaseException:
        if not heard:
            raise
    finally:
        logging.disable(logging.NOTSET)
        for one, handler in before.items():
            signal.signal(one, handler)
    if heard:
        raise KeyboardInterrupt(heard[0])


def end_jobs() -> None:
    """Ask the processes that this one started to end; then kill them."""
    running = psutil.Process().children(recursive=True)
    for process in running:
        _send(process, signal.SIGTERM)
    _, left = psutil.wait_procs(running, GRACE_S)
    for process in left:
        _send(process, signal.SIGKILL)


def _send(process: psutil.Process, number: int) -> None:
    try:
        process.send_signal(number)
    except psutil.NoSuchProcess:
        return


@contextmanager
def _heard_by_snakemake(hear: Callable) -> Iterator[None]:
    """Its scheduler handles SIGTERM by waiting for jobs that have ended, and cancels
    no job whose status is being queried."""
    from snakemake.scheduling.job_scheduler import JobScheduler
    from snakemake_interface_executor_plugins.executors.remote import RemoteExecutor

    before = JobScheduler.exit_gracefully, RemoteExecutor.cancel
    JobScheduler.exit_gracefully = staticmethod(hear)
    RemoteExecutor.cancel = _cancel
    try:
        yield
    finally:
        JobScheduler.exit_gracefully, RemoteExecutor.cancel = before


def _cancel(executor: Any) -> None:
    """Cancel the jobs on a cluster, after the round of queries that removes them from
    the list."""
    executor.wait = False
    executor.wait_thread.join()
    executor.cancel_jobs(executor.active_jobs)
    executor.shutdown()
