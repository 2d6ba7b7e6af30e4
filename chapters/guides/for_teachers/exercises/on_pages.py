"""The exercises of the chapters' pages, found in their files and timed."""

from __future__ import annotations

import ast
import html
from itertools import pairwise
from typing import NamedTuple

from chapters.shared.run_times import rounded_seconds, timed
from repro.page.reader import (
    Missing,
    Shown,
    checkout,
    names_on_page,
    pipe_table,
)

CHECKS = ("check", "check_function")
CHAPTERS = ("ch01_*", "ch02_*")
WRONG = 0.0  # an answer that is checked, and so makes the library work


class ExercisePage(NamedTuple):
    """A page with exercises: id, title, and the lines that check answers."""

    id: str
    title: str
    checks: tuple[str, ...]


def display_lines(text):
    """The lines of the display cells of a page's text, in their order."""
    lines = text.splitlines()
    return [
        line.removeprefix("# ")
        for above, line in pairwise(lines)
        if above.startswith("# %%") and '"active-ipynb"' in above
    ]


def checks(text):
    """The display lines of a page's text that check an answer."""
    return tuple(line for line in display_lines(text) if _is_check(line))


def _is_check(line):
    call = _statement(line)
    return (
        isinstance(call, ast.Expr)
        and isinstance(call.value, ast.Call)
        and getattr(call.value.func, "id", "") in CHECKS
    )


def _statement(line):
    """The one statement of a line; nothing where it is not Python."""
    try:
        return ast.parse(line).body[0]
    except (SyntaxError, IndexError):
        return None


def title_of(text):
    """The first heading of a page's text."""
    for line in text.splitlines():
        if line.startswith("# # "):
            return line.removeprefix("# # ")
    return ""


def pages_with_exercises(folders=CHAPTERS):
    """Pages of the chapters that check answers, in reading order."""
    root = checkout() / "chapters"
    found = []
    for folder in folders:
        for path in sorted(root.glob(f"{folder}/*/page.py")):
            text = path.read_text("utf-8")
            if checks(text):
                name = path.parent.relative_to(root).as_posix()
                found.append(
                    ExercisePage(name, title_of(text), checks(text))
                )
    return found


def check_seconds(page_text, names):
    """Seconds to check a wrong answer, for each exercise of a page's text.

    names: what the page's module defines. What a display cell defines is
    computed first and not counted.
    """
    names = dict(names)
    made = _assignments(page_text)
    seconds = []
    for line in checks(page_text):
        expression = ast.Expression(_statement(line).value)
        _define(expression, made, names)
        expression.body.args[0] = ast.Constant(WRONG)
        ast.fix_missing_locations(expression)
        code = compile(expression, "exercise", "eval")
        seconds.append(timed(lambda code=code: eval(code, names)))
    return seconds


def _assignments(page_text):
    """Name -> display line that defines it."""
    found = {}
    for line in display_lines(page_text):
        statement = _statement(line)
        if isinstance(statement, ast.Assign):
            for target in ast.walk(statement.targets[0]):
                if isinstance(target, ast.Name):
                    found[target.id] = line
    return found


def _define(node, made, names):
    """Run the display lines that define what ``node`` reads."""
    for part in ast.walk(node):
        unknown = isinstance(part, ast.Name) and part.id not in names
        if unknown and part.id in made:
            _define(ast.parse(made[part.id]).body[0].value, made, names)
            exec(made[part.id], names)


def timed_page(page):
    """The longest check of a page in words, or why it was not timed."""
    path = checkout() / "chapters" / page.id / "page.py"
    names = names_on_page(page.id)
    try:
        found = check_seconds(path.read_text("utf-8"), names)
    except Missing:
        return "not timed: needs a result not built yet"
    return rounded_seconds(max(found))


def exercise_list(pages):
    """Table of pages, how many exercises each has, and the longest check."""
    head = ["ExercisePage", "Exercises", "Longest check"]
    rows = [[page, len(page.checks), timed_page(page)] for page in pages]
    cells = [
        [
            f'<a href="../{page.id}.html">{html.escape(page.title)}</a>',
            str(count),
            took,
        ]
        for page, count, took in rows
    ]
    text = pipe_table(head, cells, [False, True, False])
    plain = "".join(
        f"<li>{html.escape(page.title)}: {count} ({took})</li>"
        for page, count, took in rows
    )
    return Shown(text, f"<ul>{plain}</ul>")
