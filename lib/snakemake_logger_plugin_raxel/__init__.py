"""One line per job: progress of the build, job, reason."""

from __future__ import annotations

import time
from logging import LogRecord
from pathlib import Path

from snakemake_interface_logger_plugins.base import LogHandlerBase
from snakemake_interface_logger_plugins.common import LogEvent

from repro.workflow.terminal import say

REASONS = {
    "Missing output files": "not made yet",
    "Input files updated by another job": "its input is new",
    "Updated input files": "its input changed",
    "Params have changed": "code or settings changed",
    "Code has changed": "its rule changed",
    "Set of input files has changed": "other inputs",
    "Forced execution": "asked for",
    "incomplete": "was left half done",
}
# A failed job is reported with its log; these events only repeat it.
SAID_ALREADY = ("RuleException", "WorkflowError", "Exiting because", "CalledProcess")


def plain_reason(text: str) -> str:
    """Snakemake's reason in a few words."""
    for start, words in REASONS.items():
        if start.lower() in text.lower():
            return words
    return text.split(";")[0][:60]


class LogHandler(LogHandlerBase):
    """Prints job starts with progress and reason, and the end of a failed job's log."""

    def __post_init__(self) -> None:
        self._done, self._total, self._jobs = 0, 0, {}
        self._begin = time.monotonic()

    @property
    def writes_to_stream(self) -> bool:
        """It does."""
        return True

    @property
    def writes_to_file(self) -> bool:
        """It does not."""
        return False

    @property
    def has_filter(self) -> bool:
        """It selects the events itself."""
        return True

    @property
    def has_formatter(self) -> bool:
        """It formats itself."""
        return True

    @property
    def needs_rulegraph(self) -> bool:
        """It does not."""
        return False

    def emit(self, record: LogRecord) -> None:
        """Print the relevant part of the record."""
        event = getattr(record, "event", None)
        if event == LogEvent.RUN_INFO:
            self._total = sum(
                count
                for rule, count in (getattr(record, "stats", None) or {}).items()
                if rule not in ("all", "total")
            )
        elif event == LogEvent.JOB_INFO and record.rule_name != "all":
            what = record.rule_msg or record.rule_name
            self._jobs[record.jobid] = what
            self._say(f"{what}  ({plain_reason(record.reason or '')})")
        elif event == LogEvent.JOB_FINISHED:
            self._done = min(self._done + 1, self._total)
        elif event == LogEvent.JOB_ERROR:
            self._failed(record)
        elif event in (LogEvent.ERROR, None) and record.levelno >= 40:
            text = record.getMessage()
            if not text.startswith(SAID_ALREADY):
                say(text)

    def _say(self, text: str) -> None:
        seconds = time.monotonic() - self._begin
        say(f"[{self._done:3d}/{self._total} {seconds:5.0f} s] {text}")

    def _failed(self, record: LogRecord) -> None:
        number = record.aux.get("external_jobid")
        where = f"  (job {number} of the cluster)" if number else ""
        self._say(f"FAILED: {self._jobs.get(record.jobid, record.rule_name)}{where}")
        for name in record.log or []:
            path = Path(str(name))
            if path.is_file() and path.stat().st_size:
                lines = path.read_text("utf-8", "replace").strip().splitlines()
                say("\n".join(lines[-6:]))
                say(f"The whole log: {path}")
