"""Gather the source of the site: its own pages, the executed chapters, the scoreboard.

Sphinx gets one folder with all sources. The guide to image sets is the README of
`data/recorded`. The pages that depend on the build (the start page, one index per
chapter) are templates in `report/source`, filled here: their numbers are counted from
the scoreboard, and a chapter is listed if it has a page. Downloads go to `_extra`,
which Sphinx copies to the top of the site.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import median
from types import MappingProxyType

from repro.judge.scoreboard import chapter_order, headline
from repro.page.furniture import Furnisher
from repro.page.wording import literal
from repro.site import artefacts, numbered
from repro.site.chapters import Chapter, chapters_of, documents, source_of, title_of
from repro.site.ledger_pages import codes, ledger_pages
from repro.site.library import library_pages
from repro.site.mirror import Content, files_below, mirror
from repro.site.notebooks import workable
from repro.site.provenance import experiment_page, quoted_page
from repro.site.scoreboard import written_before
from repro.site.source_pages import source_page
from repro.site.start import Quotable

DOCUMENTS = ("README.md", "REPRODUCED.md", "environment.txt")
SHOWN = (".svg", ".png", ".csv", ".html")


def assemble(
    root: Path,
    effort: str,
    pages: Sequence[Path],
    scoreboard: Path,
    rows: Path,
    out: Path,
    records: Sequence[Path] = (),
    model: Mapping = MappingProxyType({}),
) -> list[str]:
    """Bring the site's source at ``out`` up to date; return the files touched.

    Parameters
    ----------
    pages : executed notebooks, `.../<chapter>/<page>.ipynb`.
    scoreboard, rows : the scoreboard as a page and as JSON.
    records : of the calibrated image sets (`repro.workflow.image_sets`).
    model : of the costs of larger builds (`repro.workflow.scale`).
    """
    furnisher = Furnisher(root, effort, "")
    held = numbered.by_page(furnisher.made, furnisher.book.artefacts)
    chapters = chapters_of(root, pages, held)
    board = json.loads(rows.read_text("utf-8"))
    sets = {path: json.loads(path.read_text("utf-8")) for path in records}
    own = files_below(root / "report" / "source")
    wanted: dict[str, Content] = {
        name: path for name, path in own.items() if not name.endswith(".jinja")
    }
    for path in pages:
        wanted[f"{path.parent.name}/{path.name}"] = path
    wanted["scoreboard.md"] = scoreboard
    names = [page.name for page in documents(chapters)]
    found = artefacts.artefacts(furnisher, names, board)
    wanted["artefacts.md"] = artefacts.page(
        found, [(c.title, c.pages) for c in chapters], furnisher.book.artefacts
    )
    wanted |= _filled(root, effort, chapters, board, list(sets.values()), model)
    wanted |= ledger_pages(root, furnisher.book)
    wanted |= library_pages(root / "lib" / "raxel")
    wanted["_extra/scoreboard.json"] = rows
    wanted |= {
        f"_extra/{name}": content
        for name, content in _extra(furnisher, pages, board).items()
    }
    wanted |= {
        f"_extra/sets/{one['name']}/{file}": path.with_suffix("") / file
        for path, one in sets.items()
        for file in one["files"]
    }
    wanted["site.json"] = json.dumps(
        {
            "effort": effort,
            "sources": {f"{p.parent.name}/{p.stem}": source_of(p) for p in pages},
            # Neighbours show the title: when it changes, they are written again.
            "titles": _titles(chapters, wanted),
            "entries": {page.name: page.entry for page in documents(chapters)},
            "codes": codes(root, furnisher.book, board),
        },
        indent=1,
        ensure_ascii=False,
    )
    return mirror(wanted, out)


def _titles(chapters: Sequence[Chapter], wanted: Mapping[str, Content]) -> dict:
    titles = {d.name: d.title for d in documents(chapters)}
    titles |= {f"{chapter.folder}/index": chapter.title for chapter in chapters}
    for name, content in sorted(wanted.items()):
        if "/" not in name and name.endswith(".md") and isinstance(content, Path):
            titles[name.removesuffix(".md")] = title_of(content)
    return titles


def _extra(
    furnisher: Furnisher, pages: Sequence[Path], board: Sequence[Mapping]
) -> dict[str, Content]:
    """Downloads: figures, tables, results, their provenance, pages, code."""
    root, base = furnisher.root, furnisher.base
    kept: dict[str, Content] = {name: root / name for name in DOCUMENTS}
    for path in sorted(base.glob("*")):
        if path.suffix in SHOWN and not path.name.startswith("."):
            kept[f"figures/{path.name}"] = path
    experiments = {p.id: p for p in furnisher.made if p.kind == "experiment"}
    for path in sorted((base / "results").glob("[!.]*.json")):
        if path.stem in experiments:
            kept[f"results/{path.name}"] = path
            kept[f"provenance/{path.stem}.html"] = experiment_page(
                experiments[path.stem], path
            )
    by_id = {row["id"]: row for row in board}
    for path in pages:
        name = f"{path.parent.name}/{path.name}"
        kept[f"provenance/{name.removesuffix('.ipynb')}.html"] = quoted_page(
            root, path, by_id
        )
        kept[f"notebooks/{name}"] = workable(root / path)
        kept[f"source/{source_of(path)}"] = root / "chapters" / source_of(path)
    kept |= _code(root)
    return kept


def _code(root: Path) -> dict[str, Content]:
    """The code of the chapters and of the library, as pages with anchors."""
    chapters, library = root / "chapters", root / "lib"
    files = {p: p.relative_to(chapters) for p in chapters.glob("*/**/*.py")}
    files |= {p: p.relative_to(library) for p in library.glob("raxel/**/*.py")}
    return {
        f"source/{name.as_posix()}.html": source_page(
            path, name.as_posix(), "../" * len(name.parts)
        )
        for path, name in sorted(files.items())
    }


def _filled(
    root: Path,
    effort: str,
    chapters: Sequence[Chapter],
    board: list[dict],
    sets: Sequence[Mapping],
    model: Mapping,
) -> dict[str, str]:
    """The pages from templates; an unknown name in one is an error."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    templates = Environment(
        loader=FileSystemLoader(root / "report" / "source"),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,
    )
    templates.filters["median"] = lambda values: median(list(values))
    templates.filters["literal"] = literal
    templates.filters["totals"] = lambda rows: map(sum, zip(*rows, strict=True))
    counts = headline(board)
    known = {
        "effort": effort,
        "chapters": chapters,
        "counts": counts,
        "written_before": written_before(counts["changed"]),
        "quote": Quotable(root / "figures" / effort),
        "built": {page.name for page in documents(chapters)},
        "table": chapter_table(board, chapters),
        "sets": sets,
        "model": model,
    }
    guide = (root / "data" / "recorded" / "README.md").read_text("utf-8")
    filled = {"index.md": templates.get_template("index.md.jinja").render(known)}
    filled["your_photographs.md"] = guide + templates.get_template(
        "sets.md.jinja"
    ).render(known)
    if model:
        filled["scale.md"] = templates.get_template("scale.md.jinja").render(
            model, titles={chapter.folder: chapter.title for chapter in chapters}
        )
    for chapter in chapters:
        filled[f"{chapter.folder}/index.md"] = templates.get_template(
            "chapter.md.jinja"
        ).render(known, chapter=chapter)
    return filled


def chapter_table(board: Sequence[dict], chapters: Sequence[Chapter]) -> list[dict]:
    """One row per chapter of the thesis: its verdicts, its index if it has pages."""
    built = {chapter.number: chapter.folder for chapter in chapters if chapter.number}
    named = {str(row["chapter"]) for row in board} | set(built)
    table = []
    for number in sorted(named, key=chapter_order):
        own = [row for row in board if str(row["chapter"]) == number]
        mine = Counter(row["verdict"] for row in own)
        table.append(
            {
                "number": number,
                "folder": built.get(number, ""),
                "verdict": mine,
                "all": mine.total(),
                "counts": headline(own),
                "claims": [r for r in own if r["kind"] == "claim" and r.get("page")],
            }
        )
    return table
