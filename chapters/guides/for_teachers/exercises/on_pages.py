"""Exercises of the chapters' pages, found in their cells and timed."""

from __future__ import annotations

import html
from typing import NamedTuple

from nbformat import NotebookNode

from chapters.shared.run_times import rounded_seconds, timed
from repro.page.notebook import read_page
from repro.page.questions import Exercise, exercises_of, task_of
from repro.page.reader import Missing, Shown, checkout, names_on_page, pipe_table

CHAPTERS = ("ch01_*", "ch02_*", "ch03_*", "ch04_*", "ch05_*", "appendix_a")


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
