"""`python -m repro JOB`: the commands that the workflow's rules call."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from repro.run import jobs
from repro.run.rendered import declared


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m repro", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)

    def command(name: str, *, out: bool = True) -> argparse.ArgumentParser:
        sub = commands.add_parser(name)
        sub.add_argument("name")
        if out:
            sub.add_argument("--out", type=Path, required=True)
        return sub

    run = command("run")
    run.add_argument("--shard", required=True, help="number/of")
    whole, gather = command("whole"), command("gather")
    for sub in (run, whole, gather):
        sub.add_argument("--effort", choices=("quick", "full"), required=True)
        sub.add_argument("--trials", type=int)
        sub.add_argument("--results", type=Path, required=True)
    for sub in (whole, gather):
        sub.add_argument("--code", required=True)
    gather.add_argument("--shards", nargs="+", type=Path, required=True)
    for kind in ("figure", "table"):
        draw = command(kind)
        draw.add_argument("--results", type=Path, required=True)
    judge = command("judge")
    judge.add_argument("--effort", choices=("quick", "full"), required=True)
    judge.add_argument("--folder", type=Path, required=True)
    judge.add_argument("--readings", choices=("open", "all"), default="open")
    books = commands.add_parser("notebooks")
    books.add_argument("pages", nargs="+", type=Path)
    books.add_argument("--out", type=Path, required=True)
    return parser


def _order(a: argparse.Namespace) -> jobs.Order:
    return jobs.Order(a.name, a.effort, a.trials, a.results)


def main(argv: list[str] | None = None) -> int:
    """Run one job; return its exit status."""
    a = _parser().parse_args(argv)
    with declared(()):  # an experiment opens its own; readers of results open none
        _run(a, Path.cwd())
    return 0


def _run(a: argparse.Namespace, root: Path) -> None:
    if a.command == "run":
        shard, of = (int(part) for part in a.shard.split("/"))
        jobs.run(root, _order(a), shard, of, a.out)
    elif a.command == "whole":
        order = _order(a)
        jobs.whole(root, order, a.code, order.inputs(root), a.out)
    elif a.command == "gather":
        order = _order(a)
        jobs.gather(root, order, a.code, order.inputs(root), a.shards, a.out)
    elif a.command in ("figure", "table"):
        from repro.page.draw import draw

        draw(root, a.command, a.name, a.results, a.out)
    elif a.command == "judge":
        from repro.run.judging import judge

        judge(root, a.name, a.effort, a.folder, a.out, a.readings)
    else:
        from repro.site.notebooks import notebooks

        notebooks(a.pages, a.out)


if __name__ == "__main__":
    sys.exit(main())
