"""`python -m repro.workflow.build TARGET`: from a command to a finished build.

Downloads the image set, runs Snakemake with a plain progress display, and names the
file to open.
"""

from __future__ import annotations

import argparse
import difflib
import errno
import fcntl
import json
import os
import re
import shutil
import signal
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr
from io import StringIO
from pathlib import Path

from raxel.errors import InputError
from repro.run.jobs import Size
from repro.workflow.image_sets import sets_in
from repro.workflow.interruption import stopped_by_signals
from repro.workflow.photographs import fetch
from repro.workflow.plan import BuildPlan, planned
from repro.workflow.records import drop_damaged
from repro.workflow.terminal import say

INTERRUPTED = "interrupted; run it again to continue (finished parts are kept)"
REMEDY = "the folder needs space and write permission; then run it again"
FULL_BYTES = 1_000_000
WHOLE = ("report", "quick", "notebooks")
PROFILES = Path("lib/repro/workflow/profiles")
CHAPTER = r"ch\d+|appendix_[a-z]"


class OrderError(InputError):
    """An invalid command; the message states the cause and what to do."""


def main(argv: list[str] | None = None) -> int:
    """Run one build command; return its exit status."""
    options = _parser().parse_args(argv)
    root = Path.cwd()
    try:
        with _only_build(root):
            return _build(root, options)
    except (InputError, ValueError) as error:
        status, message = 1, str(error)
    except SyntaxError as error:
        status, message = 1, f"{error.filename}:{error.lineno}: not Python; correct it"
    except OSError as error:
        status, message = 1, f"{error.filename}: {error.strerror}; {REMEDY}"
    except KeyboardInterrupt as end:
        status, message = 128 + (*end.args, signal.SIGINT)[0], INTERRUPTED
    say(f"make {options.target}: {message}")
    return status


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m repro.workflow.build", description=__doc__
    )
    parser.add_argument("target")
    parser.add_argument("--effort", choices=("quick", "full"), default="full")
    parser.add_argument("--readings", choices=("open", "all"), default="open")
    for name in ("trials", "scale", "recorded", "cores", "profile"):
        parser.add_argument(f"--{name}", default="")
    return parser


def _build(root: Path, options: argparse.Namespace) -> int:
    recorded = _checked_recorded(options.recorded)
    trials = _checked_trials(options.trials, options.target)
    scale = _checked_scale(options.scale, trials)
    where = _where(options.profile, options.cores)
    if options.target in WHOLE:
        fetch(root / "data" / "recorded" / "opencv-left")
    planned.cache_clear()  # of an earlier build in the same process
    size = Size(options.effort, trials, scale)
    target = "report" if options.target == "quick" else options.target
    plan = planned(root, size, recorded, target, options.readings)
    if not plan.final:
        raise OrderError(_unknown(plan, target))
    base = root / plan.base
    base.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryFile(dir=base):  # it may be read-only
        drop_damaged(plan)
    _drop_judgements_of_gone_pages(plan)
    if target == "report" and not (root / size.site / "index.html").is_file():
        plan.record("site").unlink(missing_ok=True)
    markers = [plan.marker(job) for job in plan.jobs.values()]
    words = [
        *where, "--logger", "raxel", "--nolock", "--rerun-incomplete",
        "--scheduler", "greedy", "--config", *_config(plan),
    ]  # fmt: skip
    before = _ages(root, markers)
    done = _snakemake(words)
    if done:
        _say_where(plan, changed=_ages(root, markers) != before)
    elif shutil.disk_usage(base).free < FULL_BYTES:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(base))
    return 0 if done else 1


def _config(plan: BuildPlan) -> list[str]:
    """Configuration for the rules; the path is in quotes that Snakemake does not
    remove."""
    size, given = plan.size, plan.recorded
    folder = f" {json.dumps(given, ensure_ascii=False)} " if given else ""
    trials = "" if size.trials is None else size.trials
    return [
        f"target={plan.target}", f"effort={size.effort}", f"trials={trials}",
        f"scale={size.scale}", f"readings={plan.readings}", f"recorded={folder}",
    ]  # fmt: skip


def _snakemake(words: list[str]) -> bool:
    """Run Snakemake as its command line does, with one setting that it does not offer.

    Its default limit of jobs per second starts a timer after each job, which checks all
    waiting jobs again and again: hundreds of timers keep a core busy. Without a limit
    there is no timer.
    """
    from snakemake.cli import args_to_api, parse_args
    from snakemake.exceptions import CliException

    try:
        with redirect_stderr(StringIO()) as usage:
            parser, settings = parse_args(words)
    except (SystemExit, CliException) as end:  # only a profile has other words
        fault = usage.getvalue().partition("error: ")[2] or str(end)
        raise OrderError(f"PROFILE={words[1]}: {' '.join(fault.split())}") from None
    settings.max_jobs_per_timespan = None
    with stopped_by_signals(on_cluster=bool(settings.executor)):
        return args_to_api(settings, parser)


def _drop_judgements_of_gone_pages(plan: BuildPlan) -> None:
    """Remove judged files of renamed pages."""
    folder = plan.root / plan.base / "judged"
    kept = {folder / f"{page}.json" for page in plan.pages}
    for path in folder.rglob("*.json"):
        if path not in kept:
            path.unlink()


def _checked_recorded(given: str) -> str:
    """An absolute folder that is an image set or contains some."""
    if not given:
        return ""
    folder = Path(given).expanduser()
    if not folder.is_dir():
        raise OrderError(f"RECORDED={given}: no such folder; name an image set")
    if not sets_in(folder):
        raise OrderError(
            f"RECORDED={given}: no images in it; see data/recorded/README.md"
        )
    return str(folder.resolve())


def _checked_trials(given: str, target: str) -> int | None:
    if given and (target in WHOLE or re.fullmatch(CHAPTER, target)):
        raise OrderError(
            "TRIALS: only for one artefact (a what-if, stored separately); name it, "
            "for example: make fig_2_3 TRIALS=500"
        )
    return _number("TRIALS", given) if given else None


def _checked_scale(given: str, trials: int | None) -> int:
    if given and trials is not None:
        raise OrderError("SCALE: not together with TRIALS; give one of them")
    return _number("SCALE", given or "1")


def _number(name: str, given: str) -> int:
    if not given.isdecimal() or int(given) < 1:
        raise OrderError(f"{name}={given}: not a whole number above 0; give one")
    return int(given)


def _where(profile: str, cores: str) -> list[str]:
    """Arguments for a build on this machine, or with a profile on a cluster."""
    if not profile:
        return ["--cores", str(_number("CORES", cores or str(os.cpu_count() or 1)))]
    for folder in (PROFILES / profile, Path(profile).expanduser()):
        if (folder / "profile.yaml").is_file():
            if folder.parent == PROFILES and not shutil.which("sbatch"):
                raise OrderError(f"PROFILE={profile}: no sbatch; use a login node")
            return ["--workflow-profile", str(folder)]
    known = ", ".join(sorted(path.parent.name for path in PROFILES.glob("*/*.yaml")))
    raise OrderError(
        f"PROFILE={profile}: no such profile; give {known}, or a folder with a "
        "profile.yaml"
    )


def _unknown(plan: BuildPlan, target: str) -> str:
    """Message for an unknown target, for artefacts with similar ids."""
    if re.fullmatch(CHAPTER, target):
        number, last = target.removeprefix("ch"), target[-1].upper()
        name = f"chapter {int(number)}" if number.isdigit() else f"appendix {last}"
        if len(number) == 1:
            return f"{target}: no such chapter; give ch0{number}"
        return f"no page of {name} is built yet"
    made = [i for kind, i in plan.producers if kind in ("figure", "table")]
    near = difflib.get_close_matches(target, made, n=3)
    hint = f"did you mean {', '.join(near)}?" if near else "see the scoreboard"
    return f"{target}: no such figure or table; {hint}"


def _ages(root: Path, targets: list[str]) -> list[int]:
    return [(root / t).stat().st_mtime_ns for t in targets if (root / t).exists()]


def _say_where(plan: BuildPlan, changed: bool) -> None:
    what = "" if changed else "Nothing changed. "
    whole = {"report": f"{plan.size.site}/index.html", "notebooks": "report/notebooks"}
    made = [whole.get(plan.target) or plan.product(name) for name in plan.final]
    for path in made if len(made) < 4 else made[:1]:
        say(f"{what}Look at {path}")
    if plan.target == "report":
        for message in plan.image_sets.messages():
            say(message)


@contextmanager
def _only_build(root: Path) -> Iterator[None]:
    """Lock the checkout for one build; a killed build leaves no lock."""
    folder = root / ".cache"
    folder.mkdir(exist_ok=True)
    with (folder / "build.lock").open("w") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise OrderError("another build runs in this folder; wait for it") from None
        yield


if __name__ == "__main__":
    sys.exit(main())
