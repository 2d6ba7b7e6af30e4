"""`make times`: what the builds take, beside their budgets and the last run.

    python -m repro.workflow.clock build --effort quick
    python -m repro.workflow.clock test COMMAND ...

builds, and prints what each part took and by how much it has grown. Nothing fails
for it: a slower machine, or one that is busy, is no fault of the code.

What this machine took last is kept in `.cache/times.json`, outside of git. A fresh
clone has no such file: there `data/records/times.json` takes its place, and since that
was written on some other machine, only what grew beyond the ratio of the two counts.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from repro.run import discover
from repro.run.rendered import TIMES as SET_TIMES
from repro.run.results import write_json
from repro.run.sets_of_report import sets_of_report
from repro.site.times import Times, seconds_kept, times_of
from repro.workflow.work import Work

OWN = Path(".cache/times.json")
RECORD = Path("data/records/times.json")
GREW = 0.05
"""Growth that is told: two runs of the same thing differ by about as much."""
LEAST_S = 0.5
"""And seconds below which no growth is told."""


class Took(NamedTuple):
    """Seconds that something took: of all processors, and on the wall's clock."""

    processor: float
    wall: float


class Budget(NamedTuple):
    """Seconds on two idle cores: of the chapters that stand, and of the whole book.

    processor: of all processors, for those that stand, where a budget is set.
    """

    wall: float
    book: float
    processor: float | None = None


BUDGETS = {
    "quick": Budget(170, 240, 330),
    "full": Budget(36 * 60, 60 * 60, 70 * 60),
    "nothing changed": Budget(4, 4),
    "a page again": Budget(10, 10),
    "make test": Budget(7 * 60, 9 * 60),
}
RUNS = {"quick": "make quick", "full": "make report"}


@dataclass(frozen=True)
class Clocked:
    """Processor seconds of the parts of a build, and what whole runs took."""

    parts: Mapping[str, float]
    runs: Mapping[str, Took]

    def as_json(self) -> dict:
        """As `clocked_from` reads it."""
        return {
            "parts": {name: round(seconds, 1) for name, seconds in self.parts.items()},
            "runs": {n: [round(s, 1) for s in took] for n, took in self.runs.items()},
        }


def clocked_from(kept: Mapping) -> Clocked:
    """What `Clocked.as_json` gave; nothing where the file has nothing yet."""
    runs = {name: Took(*took) for name, took in kept.get("runs", {}).items()}
    return Clocked(kept.get("parts", {}), runs)


# ------------------------------------------------------------------------ adding up


def parts_of(times: Times, site: float) -> dict[str, float]:
    """Part of the book -> processor seconds of its jobs: chapters, and what is of
    none."""
    parts: dict[str, float] = {}
    for page in times.pages:
        chapter = page.page.partition("/")[0]
        parts[chapter] = parts.get(chapter, 0.0) + page.total
    others = {"rendered sets": times.rendered, "scoreboard": times.scoreboard}
    return parts | others | {"site": site}


def ratio(now: Mapping[str, float], before: Mapping[str, float]) -> float:
    """How many times as long the parts that both have take now."""
    both = now.keys() & before.keys()
    was = sum(before[name] for name in both)
    return sum(now[name] for name in both) / was if was else 1.0


def grown(
    now: Mapping[str, float], before: Mapping[str, float], scale: float = 1.0
) -> dict[str, tuple[float, float]]:
    """Part -> (seconds as it would have been, seconds now), most grown first.

    ``scale``: how many times as long this machine takes as that of ``before``.
    """
    found = {
        name: (scale * before[name], seconds)
        for name, seconds in now.items()
        if name in before
        and seconds - scale * before[name] > max(LEAST_S, GREW * scale * before[name])
    }
    return dict(sorted(found.items(), key=lambda item: item[1][0] - item[1][1]))


# ------------------------------------------------------------------------- printing


def in_words(seconds: float) -> str:
    """A time as README gives it: 3.4 s, 45 s, 2 min 50 s, 36 min."""
    if seconds < 9.95:
        return f"{seconds:.1f} s"
    if seconds < 59.5:
        return f"{seconds:.0f} s"
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes} min {rest} s" if rest and minutes < 10 else f"{minutes} min"


def table(rows: Sequence[Sequence[str]]) -> list[str]:
    """Lines of rows in columns, the first to the left and the others to the right."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [
        "  ".join(
            cell.rjust(width) if place else cell.ljust(width)
            for place, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in rows
    ]


def runs_said(now: Mapping[str, Took], before: Mapping[str, Took]) -> list[str]:
    """Lines on whole runs: what each took, took before, and may take."""
    rows = [("processors and wall", "now", "before", "budget", "whole book")]
    for name, took in now.items():
        was, budget = before.get(name), BUDGETS[name]
        allowed = Took(budget.processor or 0, budget.wall)
        rows.append(
            (
                RUNS.get(name, name),
                _both(took),
                _both(was) if was else "-",
                _both(allowed) if budget.processor else in_words(budget.wall),
                in_words(budget.book),
            )
        )
    return table(rows)


def _both(took: Took) -> str:
    return f"{took.processor:.0f} s, {in_words(took.wall)}"


def parts_said(now: Mapping[str, float], before: Mapping[str, float]) -> list[str]:
    """Lines on the parts of a build, and their sum."""
    rows = [("processor seconds of the jobs", "now", "before")]
    for name, seconds in now.items():
        rows.append((name, f"{seconds:.1f}", _number(before.get(name))))
    whole = sum(before.values()) if before else None
    return table([*rows, ("all", f"{sum(now.values()):.1f}", _number(whole))])


def _number(seconds: float | None) -> str:
    return "-" if seconds is None else f"{seconds:.1f}"


def growth_said(
    now: Mapping[str, float], before: Mapping[str, float], same_machine: bool
) -> list[str]:
    """Lines on the parts that take longer than they did, or that none does."""
    if not before:
        return ["No earlier run is known; the next one is held against this."]
    scale, lines = 1.0, []
    if not same_machine:
        scale = ratio(now, before)
        lines.append(
            f"before: {RECORD}, of another machine; this one takes {scale:.2f} times as"
            " long, and what grew did so beyond that"
        )
    more = grown(now, before, scale)
    lines += [
        f"grew: {name}, {was:.1f} s -> {seconds:.1f} s"
        + (f" (+{100 * (seconds / was - 1):.0f} %)" if was else "")
        for name, (was, seconds) in more.items()
    ]
    return lines if more else [*lines, f"no part grew by more than {GREW:.0%}"]


# ------------------------------------------------------------------------ measuring


def timed(words: Sequence[str]) -> tuple[int, Took]:
    """Exit status of a command, and what it and all that it waited for took."""
    before, start = _processor_seconds(), time.monotonic()
    process = subprocess.Popen(words)
    try:
        status = process.wait()
    except KeyboardInterrupt:  # the command hears it as well, and says so
        status = process.wait()
    return status, Took(_processor_seconds() - before, time.monotonic() - start)


def _processor_seconds() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def measured(root: Path, effort: str, recorded: str, cores: str) -> tuple[int, Clocked]:
    """Build, build again, and a third time with one page to make; the exit status of
    the first that failed, and what they took.

    The page stands for a changed sentence: it is taken away, so that it and the site
    are made again and nothing else, and no source is touched.
    """
    target = "report" if effort == "full" else "quick"
    words = [
        sys.executable, "-m", "repro.workflow", target, "--effort", effort,
        "--recorded", recorded, "--cores", cores,
    ]  # fmt: skip
    folder = root / "figures" / effort / "times"
    bare = not any(_records(folder, root / SET_TIMES))
    runs: dict[str, Took] = {}
    status, took = timed(words)
    if bare:
        runs[effort] = took
    work = Work(root, effort, None, sets_of_report(root, recorded))
    for name in ("nothing changed", "a page again"):
        if status:
            return status, Clocked({}, runs)
        if name == "a page again":
            (root / work.notebooks()[0]).unlink()
        status, runs[name] = timed(words)
    times = times_of(
        folder, root / SET_TIMES, effort, discover.producers(root), [*work.pages]
    )
    site = sum(map(seconds_kept, sorted((folder / "site").glob("*.json"))))
    return status, Clocked(parts_of(times, site), runs)


def _records(*folders: Path) -> Iterable[Path]:
    return (path for folder in folders for path in folder.rglob("*.json"))


# -------------------------------------------------------------------------- keeping


def kept_in(path: Path) -> dict:
    """What the file holds; nothing where there is none, or it was cut."""
    try:
        return json.loads(path.read_text("utf-8"))
    except (OSError, ValueError):
        return {}


def keep(path: Path, name: str, now: Clocked) -> None:
    """Keep what was measured under a name, and of its runs those not timed now."""
    kept = kept_in(path)
    before = clocked_from(kept.get(name, {}))
    both = Clocked(now.parts, {**before.runs, **now.runs})
    path.parent.mkdir(parents=True, exist_ok=True)
    write_json(path, kept | {name: both.as_json()})


def main(argv: list[str] | None = None) -> int:
    """Build and print, or run the tests; return the exit status of these alone."""
    words = sys.argv[1:] if argv is None else argv
    if words[:1] == ["test"]:
        return _test(words[1:])
    parser = argparse.ArgumentParser(
        prog="python -m repro.workflow.clock", description=__doc__
    )
    parser.add_argument("order", choices=("build",))
    parser.add_argument("--effort", choices=("quick", "full"), default="quick")
    parser.add_argument("--record", action="store_true", help=f"write {RECORD}, too")
    parser.add_argument("--recorded", default="")
    parser.add_argument("--cores", default="")
    return _build(parser.parse_args(words))


def _test(words: Sequence[str]) -> int:
    status, took = timed(words)
    if not status:
        now = {"make test": took}
        before = clocked_from(kept_in(OWN).get("test", {})).runs
        print("\n".join(runs_said(now, before)))
        keep(OWN, "test", Clocked({}, now))
    return status


def _build(options: argparse.Namespace) -> int:
    status, now = measured(Path.cwd(), options.effort, options.recorded, options.cores)
    if status:
        return status
    own, record = kept_in(OWN), kept_in(RECORD)
    same_machine = options.effort in own
    kept = own if same_machine else record
    before = clocked_from(kept.get(options.effort, {}))
    tests = clocked_from(own.get("test", {})).runs
    lines = runs_said({**now.runs, **tests}, before.runs)
    if options.effort not in now.runs:
        again = f"make clean times EFFORT={options.effort}"
        lines.append(f"{RUNS[options.effort]}: a part was there; {again} times all")
    lines += ["", *parts_said(now.parts, before.parts), ""]
    lines += growth_said(now.parts, before.parts, same_machine)
    print("\n".join(lines))
    for path in (OWN, RECORD) if options.record else (OWN,):
        keep(path, options.effort, now)
    if options.record and tests:
        keep(RECORD, "test", Clocked({}, tests))
    return 0


if __name__ == "__main__":
    sys.exit(main())
