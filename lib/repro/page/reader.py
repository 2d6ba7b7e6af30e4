"""Functions of display cells: results, figures, tables, values, verdicts.

A page only reads. Every function finds its files below `figures/<effort>` of the
checkout, with the effort of the build (`RAXEL_EFFORT`, `full` by default). The return
value of a cell is displayed as MyST in the built page and as HTML in a notebook.
"""

from __future__ import annotations

import base64
import csv
import importlib
import inspect
import json
import math
import os
import re
import sys
import textwrap
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from markupsafe import escape

from repro.page.cells import as_read, is_numeric
from repro.page.templates import part, render
from repro.page.wording import label, literal, plain, rounded, unescaped
from repro.run.discover import page_module
from repro.run.results import Result, opened

# Results that this page has opened so far.
_opened: list[str] = []
# What can be opened below a figure, as a link says it.
OPENED = {"3-D": "3-D scene", "film": "film", "slider": "slider"}


class Missing(FileNotFoundError):
    """A file that a page shows and that is missing; the message names the command."""


class Shown:
    """Something a display cell returns: MyST for the page, HTML for a notebook."""

    def __init__(self, markdown: str, page: str) -> None:
        self.markdown = markdown
        self.html = page

    def _repr_mimebundle_(self, include: object = None, exclude: object = None) -> dict:
        return {
            "text/markdown": self.markdown,
            "text/html": self.html,
            "text/plain": re.sub(r"<[^>]+>", "", self.html).strip()[:200],
        }


def checkout() -> Path:
    """Return the checkout: the current folder, or the nearest parent with chapters."""
    here = Path.cwd()
    for folder in (here, *here.parents):
        if (folder / "chapters").is_dir() and (folder / "data" / "published").is_dir():
            return folder
    return here


def names_on_page(page: str) -> dict[str, object]:
    """Return the definitions of a page's module (`chapter/page`), for its display
    lines."""
    return dict(vars(importlib.import_module(page_module(page))))


def base() -> Path:
    """Return the folder of the figures and results of this effort."""
    return checkout() / "figures" / os.environ.get("RAXEL_EFFORT", "full")


def _needed(path: Path, target: str) -> Path:
    if not path.is_file():
        raise Missing(
            f"{path.relative_to(checkout())} is missing; `make {target}` makes it"
        )
    return path


def forget_results() -> None:
    """Begin a page: what other pages of this process have opened does not count."""
    _opened.clear()


def open_results(experiment: str) -> Result:
    """Return the result of an experiment with its trials
    (`repro.run.results.Result`)."""
    folder = base() / "results"
    _opened.append(experiment)
    return Result(_needed(folder / f"{experiment}.json", "report"))


def seconds(experiment: str) -> float:
    """Return the processing time of an experiment, summed over its jobs, seconds."""
    folder = base() / "results"
    record = _needed(folder / f"{experiment}.run.json", "report")
    return float(json.loads(record.read_text("utf-8"))["seconds"])


def results_behind(artefact: str) -> dict[str, Result]:
    """Return the results of which a figure or table was made, experiment ->
    Result."""
    read = _described(artefact)["results"]
    _opened.extend(read)
    return opened(base() / "results", read)


def show(artefact: str) -> Shown:
    """Show a regenerated figure with its caption, its data, and its source."""
    about = _described(artefact)
    svg = _needed(base() / f"{artefact}.svg", artefact)
    caption = about["caption"]
    alt = f"{label(artefact)} {plain(caption)}".strip()
    links = _links(artefact, about, ("svg", "png", "csv"))
    scene, opens = f"{_up()}figures/{artefact}.html", about.get("scene")
    markdown = "\n".join(
        [
            part("anchor", artefact) + "\n",
            f"::::{{figure}} /_extra/figures/{artefact}.svg",
            f":name: {artefact}",
            # In quotes, as YAML: a caption may begin with what is special there.
            f":alt: {json.dumps(alt, ensure_ascii=False)}",
            f":target: {_up()}figures/{artefact}.svg",
            *([":class: raxel-lines"] if about.get("lines") else []),
            "",
            f"{_titled(artefact, caption)}",
            "",
            links,
            "::::",
            "",
            *([part("opened", scene, alt, opens), ""] if opens else []),
            mark(artefact),
        ]
    )
    data = base64.b64encode(svg.read_bytes()).decode()
    page = render(
        "figure",
        artefact=artefact,
        alt=alt,
        data=data,
        label=label(artefact),
        caption=unescaped(" ".join(caption.split())),
    )
    return Shown(markdown, page)


def show_table(artefact: str, digits: int = 4) -> Shown:
    """Show a regenerated table with ``digits`` digits; the CSV has all of them.

    Columns in the table's texts are shown unchanged, the others as Markdown. A cell for
    which the table names a printed number gets a placeholder, which
    `repro.page.furniture` fills.
    """
    about = _described(artefact)
    path = _needed(base() / f"{artefact}.csv", artefact)
    with path.open(encoding="utf-8", newline="") as file:
        head, *rows = list(csv.reader(file))
    filled = zip(*rows, strict=True) if rows else [()] * len(head)
    columns = as_read(
        dict(zip(head, filled, strict=True)),
        about.get("measured", ()),
        about.get("texts", ()),
        digits,
    )
    head = list(columns)
    texts = [name in about.get("texts", ()) for name in head]
    cells = [list(row) for row in zip(*columns.values(), strict=True)]
    written = [
        [literal(c) if text else c for c, text in zip(row, texts, strict=True)]
        for row in cells
    ]
    numeric = [is_numeric(column) for column in columns.values()]
    written = _with_places(head, written, about)
    titled = _titled(artefact, about["caption"])
    markdown = "\n".join(
        [
            part("anchor", artefact) + "\n",
            f"::::{{table}} {titled}",
            f":name: {artefact}",
            "",
            pipe_table(head, written, numeric),
            "::::",
            "",
            f":::{{div}} raxel-links\n{_links(artefact, about, ('csv',))}\n:::",
            "",
            mark(artefact),
        ]
    )
    page = render(
        "table",
        artefact=artefact,
        label=label(artefact),
        caption=unescaped(" ".join(about["caption"].split())),
        head=head,
        rows=_with_places(
            head, [[str(escape(c)) for c in row] for row in cells], about
        ),
    )
    return Shown(markdown, page)


def _with_places(
    head: list[str], rows: list[list[str]], about: dict
) -> list[list[str]]:
    """Rows of a table, with a placeholder after each cell with a number of the thesis.

    The cells contain Markdown or HTML by now.
    """
    printed = about.get("printed", {})
    none = [None] * len(rows)
    ids = zip(*(printed.get(name, none) for name in head), strict=True)
    return [
        [
            cell + part("printed_mark", own) if own else cell
            for cell, own in zip(row, of_row, strict=True)
        ]
        for row, of_row in zip(rows, ids, strict=True)
    ]


def show_code(*functions: Callable) -> Shown:
    """Show the source of functions of the library, with its position."""
    pieces = []
    for function in functions:
        lines, first = inspect.getsourcelines(inspect.unwrap(function))
        code = textwrap.dedent("".join(lines)).rstrip()
        place = f"{function.__module__}, from line {first}"
        pieces.append((place, code))
    markdown = "\n\n".join(
        f":::{{div}} raxel-links\n{place}\n:::\n\n````python\n{code}\n````"
        for place, code in pieces
    )
    return Shown(markdown, render("code", pieces=pieces))


def pipe_table(head: list[str], rows: list[list[str]], numeric: list[bool]) -> str:
    """A Markdown table; numeric columns are aligned to the right."""
    rule = ["---:" if right else "---" for right in numeric]
    lines = [head, rule, *rows]
    return "\n".join(
        "| " + " | ".join(re.sub(r"(?<!\\)\|", r"\|", cell) for cell in line) + " |"
        for line in lines
    )


def value(name: str, number: float | int | str) -> None:
    """Name a value for the prose, which quotes it as {glue:text}`name:.2f`.

    A format of Python's `format` may follow the name.
    """
    from IPython.display import display

    if hasattr(number, "item"):
        number = number.item()
    if not isinstance(number, int | float | str):
        raise TypeError(
            f"value {name!r}: found a {type(number).__name__}; give a number"
        )
    if isinstance(number, float) and not math.isfinite(number):
        raise ValueError(f"value {name!r}: found {number}; give a finite number")
    made = _maker()
    note = {"scrapbook": {"name": name, "value": number, "made": made}}
    display({"text/plain": f"{name} = {number}"}, raw=True, metadata=note)


def _maker() -> dict:
    """Path and function of a chapter that call `value`, for the provenance.

    ``results``: those that the calling functions hold, or else all that the page has
    opened so far. The path of a cell is empty.
    """
    chapters = f"{checkout() / 'chapters'}{os.sep}"
    frame, made, results = sys._getframe(2), {}, []
    while frame:
        code = frame.f_code
        in_cell = frame.f_globals.get("__name__") == "__main__"
        if in_cell or code.co_filename.startswith(chapters):
            path = Path() if in_cell else Path(code.co_filename).relative_to(checkout())
            function = code.co_name.strip("<>")
            made = made or {
                "path": "" if in_cell else path.as_posix(),
                "function": function,
            }
            if function == "module":
                break
            results += _results_in(frame.f_locals.values())
        frame = frame.f_back
    return made | {"results": sorted(set(results or _opened))}


def _results_in(objects: Iterable[object]) -> Iterator[str]:
    """Names of the results among objects, and among the values of dictionaries."""
    for one in objects:
        for inner in one.values() if isinstance(one, dict) else (one,):
            if isinstance(inner, Result):
                yield inner.path.stem


def values() -> None:
    """Name every regenerated number of this page for the prose.

    A number of the ledger with id ``x`` gives ``x`` (number only), ``x.low`` and
    ``x.high`` if it has an interval, and ``x.text`` with unit and interval, rounded by
    the interval.
    """
    judged = base() / "judged" / f"{page_id()}.json"
    content = json.loads(_needed(judged, "report").read_text("utf-8"))
    for name, entry in content["numbers"].items():
        if entry["value"] is None:
            continue
        value(name, entry["value"])
        interval = entry.get("interval")
        if interval and None not in interval:
            value(f"{name}.low", interval[0])
            value(f"{name}.high", interval[1])
        value(f"{name}.text", rounded(entry["value"], interval, entry.get("unit", "")))


def compared(page: str | None = None) -> Shown:
    """Show this page's rows of the scoreboard: published, regenerated, verdict."""
    from repro.page.rows import comparison_table

    table = comparison_table(
        page or page_id(), os.environ.get("RAXEL_EFFORT", "full"), checkout()
    )
    return Shown(table, table)


def scoreboard() -> tuple[list[dict], list[dict]]:
    """Return the rows of the scoreboard of this build, and the statements of the thesis
    (`repro.judge.scoreboard.concluded`), for a page with `READS_VERDICTS = True`.

    No printed number is included: rows other than claims have only a verdict.
    """
    from repro.judge.scoreboard import concluded, read_statements

    path = _needed(base() / "scoreboard.json", "report")
    rows = [
        row
        if row["kind"] == "claim"
        else {key: row[key] for key in ("id", "kind", "chapter", "verdict")}
        for row in json.loads(path.read_text("utf-8"))
    ]
    return rows, concluded(read_statements(checkout()), rows)


def show_part(name: str, *values: object) -> Shown:
    """Show a part of the scoreboard, by the name of its macro (`repro.page.rows`)."""
    from repro.page.rows import part

    text = part(name, *values, _up())
    return Shown(text, text)


def page_id() -> str:
    """Return the id of the page being built (`RAXEL_PAGE`)."""
    page = os.environ.get("RAXEL_PAGE", "")
    if not page:
        raise Missing("RAXEL_PAGE: not set; give the id of the page, chapter/section")
    return page


def mark(name: str) -> str:
    """Placeholder for the information about an artefact (`repro.page.furniture`)."""
    return part("mark", name)


def _described(name: str) -> dict:
    return json.loads(_needed(base() / f"{name}.json", name).read_text("utf-8"))


def _titled(artefact: str, caption: str) -> str:
    name = label(artefact)
    return f"{f'**{name}.** ' if name else ''}{' '.join(caption.split())}"


def _up() -> str:
    """The path from a page of the site to its top."""
    return "../" * os.environ.get("RAXEL_PAGE", "").count("/")


def _links(name: str, about: dict, endings: tuple[str, ...]) -> str:
    up = _up()
    scene, behind = [], []
    if about.get("scene"):
        scene.append((f"{up}figures/{name}.html", OPENED[about["scene"]]))
    for result in about["results"]:
        behind.append((f"{up}results/{result}.json", f"every trial: {result}"))
    if "source" in about:
        path, function = about["source"]
        behind.append((f"{up}source/{path}.html#{function}", "source"))
    return part(
        "links",
        scene,
        [(f"{up}figures/{name}.{e}", e.upper()) for e in endings],
        behind,
        about["evidence"],
    )
