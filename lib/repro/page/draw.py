"""The job that draws a figure or fills a table from results, with its description."""

from __future__ import annotations

from pathlib import Path

from repro.judge.ledger import load
from repro.page.wording import label, plain
from repro.run import discover, jobs, results
from repro.run.as_columns import csv_text, in_numbers, measured
from repro.run.outcomes import Check, Drawing, Film, Table


def draw(root: Path, kind: str, name: str, folder: Path, out: Path) -> None:
    """Draw a figure (svg, png, csv) or write a table (csv), and describe it (json).

    A figure marked with a scene also writes the scene or its video (html). Published
    numbers are passed only here, after the results are computed.
    """
    found = jobs.producer(root, kind, name)
    given = [results.opened(folder, found.needs)]
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
            "results": list(found.needs),
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
    """Write the figure's scene if its decorator has one; otherwise delete an old
    one."""
    from repro.page.film import film_page
    from repro.page.space import scene_page

    promised = found.details.get("scene", False)
    if promised != (made.scene is not None):
        raise ValueError(
            f"{found.module}:{found.line}: {found.id}: marked with scene={promised}, "
            f"but its drawing has {'a' if made.scene else 'no'} scene"
        )
    if made.scene is None:
        out.unlink(missing_ok=True)
    else:
        title = f"{label(found.id)} {plain(made.caption)}".strip()
        page = film_page if isinstance(made.scene, Film) else scene_page
        results.write_atomic(out, page(made.scene, title))


def _opened(made: Drawing | Table) -> str:
    """Link below a figure: a scene, a video, a slider."""
    scene = getattr(made, "scene", None)
    if isinstance(scene, Film):
        return "film" if scene.per_second else "slider"
    return "3-D" if scene else ""


def _check(made: Drawing | Table) -> dict | None:
    check: Check | None = made.check
    return None if check is None else {"holds": bool(check.holds), "text": check.text}
