"""Ctrl-C, or the end of a session: stop a build immediately and cleanly."""

from __future__ import annotations

import logging
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager

SIGNALS = (signal.SIGINT, signal.SIGTERM)


@contextmanager
def stopped_by_signals(stop: Callable[[], None]) -> Iterator[None]:
    """Raise KeyboardInterrupt(number) at the end if a signal arrived meanwhile.

    It is not raised immediately, because a lock of Snakemake would remain locked.
    ``stop`` ends the jobs and prevents new ones, so Snakemake soon finishes. Its
    messages about that are suppressed. A second signal ends the process.
    """
    heard: list[int] = []

    def hear(number: int, frame: object) -> None:
        heard.append(number)
        for one in SIGNALS:
            signal.signal(one, signal.SIG_DFL)
        logging.disable(logging.CRITICAL)
        stop()

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


@contextmanager
def _heard_by_snakemake(hear: Callable) -> Iterator[None]:
    """Its scheduler handles SIGTERM by waiting for jobs that have ended."""
    from snakemake.scheduling.job_scheduler import JobScheduler

    before = JobScheduler.exit_gracefully
    JobScheduler.exit_gracefully = staticmethod(hear)
    try:
        yield
    finally:
        JobScheduler.exit_gracefully = before
