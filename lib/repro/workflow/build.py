"""`python -m repro.workflow.build TARGET`: from a command to a finished build.

Downloads the image set, runs Snakemake with a plain progress display, and names the
file to open.
"""

from __future__ import annotations

import argparse
import difflib
import fcntl
import json
import os
import re
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from repro.workflow.forks import warm_jobs
from repro.workflow.image_sets import sets_in
from repro.workflow.intact import drop_damaged
from repro.workflow.interruption import stopped_by_signals
from repro.workflow.terminal import say
from repro.workflow.work import Work, planned

INTERRUPTED = "interrupted; run it again to continue (finished parts are kept)"
WHOLE = ("report", "quick", "notebooks")


class OrderError(Exception):
    """An invalid command; the message states the cause and what to do."""


def main(argv: list[str] | None = None) -> int:
    """Run one build command; return its exit status."""
    options = _parser().parse_args(argv)
    root = Path.cwd()
    try:
        with _only_build(root):
            return _build(root, options)
    except (OrderError, ValueError) as error:
        say(f"make {options.target}: {error}")
        return 1
    except KeyboardInterrupt as end:
        say(f"make {options.target}: {INTERRUPTED}")
        return 128 + (end.args[0] if end.args else signal.SIGINT)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m repro.workflow.build", description=__doc__
    )
    parser.add_argument("target")
    parser.add_argument("--effort", choices=("quick", "full"), default="full")
    parser.add_argument("--trials", default="")
    parser.add_argument("--recorded", default="")
    parser.add_argument("--readings", choices=("open", "all"), default="open")
    parser.add_argument("--cores", default="")
    return parser


def _build(root: Path, options: argparse.Namespace) -> int:
    recorded = _checked_recorded(options.recorded)
    trials = _checked_trials(options.trials, options.target)
    if options.target in WHOLE:
        _bring_photographs(root)
    planned.cache_clear()  # of an earlier build in the same process
    work = planned(root, options.effort, trials, recorded)
    targets = _targets(work, options.target)
    drop_damaged(work)
    _drop_judgements_of_gone_pages(work)
    words = [
        *targets,
        "--cores", options.cores or str(os.cpu_count() or 1),
        "--logger", "raxel", "--nolock", "--rerun-incomplete", "--scheduler", "greedy",
        "--config", *_config(options.effort, options.trials, recorded),
        f"readings={options.readings}",
    ]  # fmt: skip
    before = _ages(root, targets)
    done = _snakemake(words)
    if done:
        _say_where(work, targets, changed=_ages(root, targets) != before)
    return 0 if done else 1


def _config(effort: str, trials: str, recorded: str) -> list[str]:
    """Configuration for the rules; the path is in quotes that Snakemake does not
    remove."""
    folder = f" {json.dumps(recorded, ensure_ascii=False)} " if recorded else ""
    return [f"effort={effort}", f"trials={trials}", f"recorded={folder}"]


def _snakemake(words: list[str]) -> bool:
    """Run Snakemake as its command line does, with one setting that it does not offer.

    Its default limit of jobs per second starts a timer after each job, which checks all
    waiting jobs again and again: hundreds of timers keep a core busy. Without a limit
    there is no timer.
    """
    from snakemake.cli import args_to_api, parse_args

    parser, settings = parse_args(words)
    settings.max_jobs_per_timespan = None
    with warm_jobs() as end_jobs, stopped_by_signals(end_jobs):
        return args_to_api(settings, parser)


def _drop_judgements_of_gone_pages(work: Work) -> None:
    """Remove judged files of renamed pages."""
    folder = work.root / work.base / "judged"
    kept = {work.root / path for path in work.judged()}
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
    if not given:
        return None
    if not given.isdigit() or int(given) < 1:
        raise OrderError(f"TRIALS={given}: not a whole number above 0; give one")
    if target in WHOLE or _is_chapter(target):
        raise OrderError(
            "TRIALS: only for one artefact (a what-if, stored separately); name it, "
            "for example: make fig_2_3 TRIALS=500"
        )
    return int(given)


def _bring_photographs(root: Path) -> None:
    from repro.workflow.photographs import fetch

    fetch(root / "data" / "recorded" / "opencv-left")


def _targets(work: Work, target: str) -> list[str]:
    """Files of a command."""
    if target in ("report", "quick"):
        if not (work.root / work.site / "index.html").is_file():
            (work.root / work.site_done).unlink(missing_ok=True)
        return [work.site_done]
    if target == "notebooks":
        return ["report/notebooks/.done"]
    if _is_chapter(target):
        pages = [p for p in work.pages if _in_chapter(p, target)]
        if not pages:
            raise OrderError(f"no page of {_chapter_name(target)} is built yet")
        return [f"{work.pages_folder}/{page}.ipynb" for page in pages]
    made = {i: kind for kind, i in work.producers if kind in ("figure", "table")}
    if target not in made:
        raise OrderError(_unknown(target, list(made)))
    return work.files_of_artefact(made[target], target)


def _is_chapter(target: str) -> bool:
    return bool(re.fullmatch(r"ch\d+|appendix_[a-z]", target))


def _in_chapter(page: str, target: str) -> bool:
    """Whether a page is in ch02_some_title/ or in appendix_a/."""
    return page.startswith((f"{target}_", f"{target}/"))


def _chapter_name(target: str) -> str:
    if target.startswith("ch"):
        return f"chapter {int(target[2:])}"
    return f"appendix {target[-1].upper()}"


def _unknown(target: str, made: list[str]) -> str:
    """Message for an unknown figure or table, with similar ids."""
    near = difflib.get_close_matches(target, made, n=3)
    hint = f"did you mean {', '.join(near)}?" if near else "see the scoreboard"
    return f"{target}: no such figure or table; {hint}"


def _ages(root: Path, targets: list[str]) -> list[int]:
    paths = [root / target for target in targets]
    return [p.stat().st_mtime_ns if p.exists() else 0 for p in paths]


def _say_where(work: Work, targets: list[str], changed: bool) -> None:
    what = "" if changed else "Nothing changed. "
    shown = [target for target in targets if not target.endswith(".html")]
    for target in shown[:1] if len(shown) > 3 else shown:
        path = Path(target)
        if target == work.site_done:
            path = Path(work.site) / "index.html"
        if path.name == ".done":
            path = path.parent
        for ending in (".svg", ".csv"):
            if (
                path.suffix == ".json"
                and (work.root / path).with_suffix(ending).is_file()
            ):
                path = path.with_suffix(ending)
                break
        say(f"{what}Look at {path}")
    if work.site_done in targets:
        for message in work.image_sets.messages():
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
