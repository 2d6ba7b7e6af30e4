"""The job that draws a figure or fills a table from results, and describes it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from repro.judge.ledger import load
from repro.page.wording import label, plain
from repro.run import discover, jobs, results
from repro.run.as_columns import csv_text, in_numbers, measured
from repro.run.outcomes import Check, Drawing, Film, Table


def draw(
    root: Path, kind: str, name: str, folder: Path, out: Path, sets: Sequence[str] = ()
) -> None:
    """Draw a figure (svg, png, csv) or write a table (csv), and describe it (json).

    A figure marked with a scene leaves that or its film too (html). ``sets`` are the
    image sets of the build, for what shows all of them. What is marked with published
    numbers gets them here, when its results are computed, and nowhere else.
    """
    found = jobs.producer(root, kind, name)
    read = jobs.results_of(root, found, name, sets)
    given = [results.opened(folder, read)]
    if found.published:
        given.append(load(root).printed(found.published))
    made = jobs.function_of(found)(*given)
    lines = False
    if isinstance(made, Drawing):
        from repro.page.style import only_lines, save_drawing

        save_drawing(made, out.with_suffix(""))
        lines = only_lines(made.figure)
        _write_scene(found, made, out.with_suffix(".html"))
    else:
        text = csv_text(in_numbers(made.columns))
        results.write_atomic(out.with_suffix(".csv"), text)
    results.write_json(
        out,
        {
            "id": name,
            "kind": kind,
            "caption": made.caption,
            "evidence": found.details["evidence"],
            "results": read,
            "check": _check(made),
            "lines": lines,
            "scene": _opened(made),
            "texts": list(getattr(made, "texts", ())),
            "measured": measured(made.columns) if isinstance(made, Table) else [],
            "printed": dict(getattr(made, "printed", {})),
            "source": [found.path, found.function],
        },
    )


def _write_scene(found: discover.Producer, made: Drawing, out: Path) -> None:
    """Write the figure's scene where its mark promises one; drop an old one if not."""
    from repro.page.film import film_page
    from repro.page.space import scene_page

    promised = found.details.get("scene", False)
    if promised != (made.scene is not None):
        raise ValueError(
            f"{found.module}:{found.line}: {found.id} is marked with scene={promised}, "
            f"and its drawing has {'a' if made.scene else 'no'} scene"
        )
    if made.scene is None:
        out.unlink(missing_ok=True)
    else:
        title = f"{label(found.id)} {plain(made.caption)}".strip()
        page = film_page if isinstance(made.scene, Film) else scene_page
        results.write_atomic(out, page(made.scene, title))


def _opened(made: Drawing | Table) -> str:
    """What a reader of the page can open below a figure: a scene, a film, a slider."""
    scene = getattr(made, "scene", None)
    if isinstance(scene, Film):
        return "film" if scene.per_second else "slider"
    return "3-D" if scene else ""


def _check(made: Drawing | Table) -> dict | None:
    check: Check | None = made.check
    return None if check is None else {"holds": bool(check.holds), "text": check.text}
