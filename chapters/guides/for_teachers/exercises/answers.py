"""`make answers`: the exercises of every route with their answers, for the lecturer.

    python -m chapters.guides.for_teachers.exercises.answers --effort quick

A Markdown file per route in report/answers. No site, archive or notebook has it in it.
"""

from __future__ import annotations

import argparse
import os
import re
import sys
from pathlib import Path
from typing import NamedTuple

import nbformat
import numpy as np

from repro.page.questions import exercises_of, reason_of, task_of
from repro.page.reader import names_on_page
from repro.run.results import write_atomic

FOLDER = Path("report", "answers")
ROUTES = Path("chapters", "guides", "for_teachers", "page.py")
LINK = re.compile(r"\]\((?:\.\./)?([\w/]+)\.ipynb\)")
HEAD = """# Answers for {title}

For the lecturer. The library computed the answers; 1 % off is right, unless a line
says otherwise. Below an answer stand wrong ones that are expected, and what is said to
them."""


class Route(NamedTuple):
    """A route: its letter, its title, and the ids of the pages that it links."""

    letter: str
    title: str
    pages: list[str]


def routes(text):
    """The routes that the text of the page for teachers describes."""
    found = []
    for part in re.split(r"^# (?=## Route )", text, flags=re.M)[1:]:
        part = re.split(r"^# ## (?!Route)", part, flags=re.M)[0]
        title = part.splitlines()[0].removeprefix("## R")
        pages = [p if "/" in p else f"guides/{p}" for p in LINK.findall(part)]
        letter = title.split()[1][0]
        found.append(Route(letter, f"r{title}", list(dict.fromkeys(pages))))
    return found


def sheet(route, folder):
    """The sheet of a route; folder: the executed pages."""
    parts = [HEAD.format(title=route.title)]
    for page in route.pages:
        notebook = nbformat.read(folder / f"{page}.ipynb", as_version=4)
        title = notebook.cells[0].source.splitlines()[0].removeprefix("# ")
        names = names_on_page(page)
        answers = [answer(one, notebook, names) for one in exercises_of(notebook)]
        parts += [f"## {title}", *answers] if answers else []
    return "\n\n".join(parts) + "\n"


def answer(exercise, notebook, names):
    """Question, answer, reason, and the slips with what they are told."""
    expected, options = task_of(exercise, notebook, names)
    told = [in_words(expected()) + "."]
    if "tolerance" in options:
        told.append(f"Within {100 * options['tolerance']:g} %.")
    if options.get("up_to_factor"):
        told.append("Any factor common to all numbers is right.")
    slips = [
        f"- {in_words(wrong())}: {said}"
        for said, wrong in options.get("slips", {}).items()
    ]
    lines = [f"**Answer:** {' '.join(told)} {reason_of(exercise, names)}", *slips]
    return f"{exercise.question}\n\n" + "\n".join(lines)


def in_words(found):
    """An answer as text: numbers to four digits."""
    if isinstance(found, str):
        return found
    return ", ".join(_written(number) for number in np.ravel(found).tolist())


def _written(number):
    whole = isinstance(number, int) or abs(number) >= 1e4
    return f"{number:,.0f}" if whole else f"{number:.4g}"


def main(argv=None):
    """Write the sheets; return the exit status."""
    parser = argparse.ArgumentParser(prog="make answers")
    parser.add_argument("--effort", choices=("quick", "full"), default="full")
    effort = parser.parse_args(argv).effort
    os.environ |= {"RAXEL_EFFORT": effort, "RAXEL_SET": ""}
    folder = Path("report", "build", effort, "pages")
    for route in routes(ROUTES.read_text("utf-8")):
        write_atomic(FOLDER / f"route-{route.letter}.md", sheet(route, folder))
    print(f"Look at {FOLDER}: for the lecturer alone")
    return 0


if __name__ == "__main__":
    sys.exit(main())
