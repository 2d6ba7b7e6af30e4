"""Ctrl-C, or the end of a session: a build stops at once and in good order."""

from __future__ import annotations

import logging
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager

SIGNALS = (signal.SIGINT, signal.SIGTERM)


@contextmanager
def stopped_by_signals(stop: Callable[[], None]) -> Iterator[None]:
    """Raise KeyboardInterrupt(number) at the end where a signal was heard meanwhile.

    It is not raised at once: inside a lock of Snakemake's it would leave that locked
    for ever. ``stop`` ends the jobs and lets none begin, so Snakemake soon has nothing
    to do. What it says of that is nobody's news. A second signal ends the process as
    it would any other.
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
    """Its scheduler takes SIGTERM for itself, to wait for jobs that are no more."""
    from snakemake.scheduling.job_scheduler import JobScheduler

    before = JobScheduler.exit_gracefully
    JobScheduler.exit_gracefully = staticmethod(hear)
    try:
        yield
    finally:
        JobScheduler.exit_gracefully = before
