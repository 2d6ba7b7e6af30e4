"""The exercises of all pages, and the sheets with their answers."""

from __future__ import annotations

import argparse
import html
import os
import re
import sys
from pathlib import Path
from typing import NamedTuple

import nbformat
import numpy as np
from nbformat import NotebookNode

from chapters.shared.run_times import rounded_seconds, timed
from repro.page import Missing, Shown, checkout, names_on_page, pipe_table
from repro.page.notebook import read_page
from repro.page.questions import Exercise, exercises_of, reason_of, task_of
from repro.run.results import write_atomic

# `make answers`: the exercises of every lesson with their answers, for the teacher.
#
#     python -m chapters.guides.for_teachers.exercises --effort quick
#
# One Markdown file per lesson in report/answers. Site, archive and notebooks exclude
# it.


FOLDER = Path("report", "answers")
PAGE = Path("chapters", "guides", "for_teachers", "page.py")
LINK = re.compile(r"\]\((?:\.\./)?([\w/]+)\.ipynb\)")
HEAD = """# Answers for {title}

For the teacher. The library computes the answers. An error of 1 % is accepted unless
stated otherwise. Below each answer are common mistakes and the reply to them."""


class Lesson(NamedTuple):
    """A lesson: its number, its title, and the ids of the pages that it links."""

    number: int
    title: str
    pages: list[str]


def lessons(text):
    """Return the lessons that the text of the page for teachers describes."""
    found = []
    for part in re.split(r"^# (?=## Lesson )", text, flags=re.M)[1:]:
        part = re.split(r"^# ## (?!Lesson)", part, flags=re.M)[0]
        title = part.splitlines()[0].removeprefix("## ")
        pages = [p if "/" in p else f"guides/{p}" for p in LINK.findall(part)]
        number = int(re.match(r"Lesson (\d+)", title)[1])
        found.append(Lesson(number, title, list(dict.fromkeys(pages))))
    return found


def sheet(lesson, folder):
    """Return the sheet of a lesson; folder: the executed pages."""
    parts = [HEAD.format(title=lesson.title)]
    for page in lesson.pages:
        notebook = nbformat.read(folder / f"{page}.ipynb", as_version=4)
        title = notebook.cells[0].source.splitlines()[0].removeprefix("# ")
        names = names_on_page(page)
        answers = [answer(one, notebook, names) for one in exercises_of(notebook)]
        parts += [f"## {title}", *answers] if answers else []
    return "\n\n".join(parts) + "\n"


def answer(exercise, notebook, names):
    """Return question, answer, reason, and common mistakes with their replies."""
    expected, options = task_of(exercise, notebook, names)
    parts = [in_words(expected()) + "."]
    if "tolerance" in options:
        parts.append(f"Within {100 * options['tolerance']:g} %.")
    if options.get("up_to_factor"):
        parts.append("Any factor common to all numbers is right.")
    slips = [
        f"- {in_words(wrong())}: {reply}"
        for reply, wrong in options.get("slips", {}).items()
    ]
    lines = [f"**Answer:** {' '.join(parts)} {reason_of(exercise, names)}", *slips]
    return f"{exercise.question}\n\n" + "\n".join(lines)


def in_words(found):
    """Return an answer as text, with numbers to four digits."""
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
    os.environ |= {"RAXEL_EFFORT": effort}
    folder = Path("report", "build", effort, "pages")
    for lesson in lessons(PAGE.read_text("utf-8")):
        write_atomic(FOLDER / f"lesson-{lesson.number}.md", sheet(lesson, folder))
    print(f"Look at {FOLDER}: for the teacher alone")
    return 0


if __name__ == "__main__":
    sys.exit(main())


# Exercises of the chapters' pages, found in their cells and timed.


CHAPTERS = ("ch0*", "appendix_a")


class ExercisePage(NamedTuple):
    """A page with exercises: id, title, cells, and the exercises in them."""

    id: str
    title: str
    notebook: NotebookNode
    exercises: list[Exercise]


def exercise_page(path):
    """Return the page of a file below chapters/."""
    notebook = read_page(path)
    title = notebook.cells[0].source.splitlines()[0].removeprefix("# ")
    name = path.parent.relative_to(checkout() / "chapters").as_posix()
    return ExercisePage(name, title, notebook, exercises_of(notebook))


def pages_with_exercises(folders=CHAPTERS):
    """Return the pages of the chapters that check answers, in reading order."""
    root = checkout() / "chapters"
    paths = [p for f in folders for p in sorted(root.glob(f"{f}/*/page.py"))]
    return [page for page in map(exercise_page, paths) if page.exercises]


def check_seconds(page, names):
    """Return the seconds to compute the expected answer of each exercise of a page.

    names: names defined by the page's module. Names of display cells are computed first
    and not counted.
    """
    tasks = [task_of(one, page.notebook, names) for one in page.exercises]
    return [timed(task.expected) for task in tasks]


def timed_page(page):
    """Return the longest check of a page as text, or why it was not timed."""
    try:
        return rounded_seconds(max(check_seconds(page, names_on_page(page.id))))
    except Missing:
        return "not timed: needs a result not built yet"


def exercise_list(pages):
    """Return a table of pages, their number of exercises, and the longest check."""
    head = ["Page", "Exercises", "Longest check"]
    rows = [[page, len(page.exercises), timed_page(page)] for page in pages]
    cells = [
        [f'<a href="../{page.id}.html">{html.escape(page.title)}</a>', str(count), took]
        for page, count, took in rows
    ]
    text = pipe_table(head, cells, [False, True, False])
    plain = "".join(
        f"<li>{html.escape(page.title)}: {count} ({took})</li>"
        for page, count, took in rows
    )
    return Shown(text, f"<ul>{plain}</ul>")
