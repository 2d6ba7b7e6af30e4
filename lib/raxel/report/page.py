"""The page of a report: numbers and pictures, one file of HTML without scripts."""

from __future__ import annotations

import contextlib
import math
import os
import re
import shutil
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from html import escape
from pathlib import Path
from typing import Any, NamedTuple

from raxel.errors import InputError
from raxel.evaluation.cross_validation import ImageScore
from raxel.evaluation.split_half import ERRATIC, ERRATIC_PX, LEAST_PX, SURE, TIMES
from raxel.io.files import check_can_be_written
from raxel.sets.mirror_set import MirrorSet
from raxel.sets.model import ImageSet, words_of

# A report is a folder: there whole, or as it was before.


PAGE = "index.html"
MARK = '<meta name="generator" content="raxel calibrate">'
FILES = re.compile(
    r"index\.html|(corners|points|residuals|shape)-\d+\.jpg|"
    r"(residuals|coverage|stability|profiles)\.png"
)


def check_report(
    folder: str | Path,
    image_set: ImageSet | MirrorSet,
    others: Iterable[str | Path | None] = (),
) -> None:
    """Raise InputError unless a report of the set can be put at `folder`.

    There may be nothing, an empty folder, or an earlier report, which the new one
    replaces.

    Parameters
    ----------
    folder : str or Path
        Folder of the report.
    image_set : ImageSet or MirrorSet
        The set.
    others : iterable of str, Path or None
        Names of files that are read or written as well. None of them may be located in
        `folder`.

    Raises
    ------
    InputError
        If the folder is in the set, or the set in it; if one of `others` or another
        file is there; or if the folder cannot be written.
    """
    folder = Path(folder)
    place, home = folder.resolve(), image_set.folder.resolve()
    if place.is_relative_to(home) or home.is_relative_to(place):
        raise InputError(
            f"{folder}: this is in the set, or the set in it, and sets are only read; "
            "give a folder of its own"
        )
    for name in filter(None, others):
        if Path(name).resolve().is_relative_to(place):  # type: ignore[arg-type]
            raise InputError(
                f"{name}: found in {folder}, whose place the report takes; choose "
                "another name"
            )
    if folder.exists() and not _may_go(folder):
        raise InputError(
            f"{folder}: found other files than a report's; give a new folder"
        )
    # The folder beside which the new one is made is to be written to.
    check_can_be_written(folder.parent / PAGE)


@contextlib.contextmanager
def new_report(folder: str | Path) -> Iterator[Path]:
    """Yield a temporary folder next to `folder`; put it in its place on success.

    If the block raises, what was at `folder` stays as it was and nothing is left.

    Parameters
    ----------
    folder : str or Path
        Folder of the report.

    Yields
    ------
    Path
        The temporary folder.
    """
    folder = Path(folder)
    made = tempfile.mkdtemp(prefix=f".{folder.name}-", dir=folder.parent)
    new, old = Path(made, "new"), Path(made, "old")
    try:
        new.mkdir()
        yield new
        if folder.exists():
            os.replace(folder, old)
        os.replace(new, folder)
    finally:
        if old.exists() and not folder.exists():
            os.replace(old, folder)
        shutil.rmtree(made, ignore_errors=True)


def _may_go(folder):
    """Whether all that is there is a report, so that nothing else is lost."""
    if not folder.is_dir():
        return False
    names = [path.name for path in folder.iterdir()]
    if not all(FILES.fullmatch(name) for name in names):
        return False
    page = folder / PAGE
    if not page.is_file():
        return not names
    return MARK in page.read_text("utf-8", errors="replace")[:2000]


STYLE = """
:root { color-scheme: light dark; --ink: #1c1c1e; --paper: #fff; --line: #c8ccd2;
  --warn: #8a4b00; }
@media (prefers-color-scheme: dark) { :root { --ink: #e8e8ea; --paper: #17181b;
  --line: #44484f; --warn: #ffb964; } }
body { color: var(--ink); background: var(--paper); max-width: 62rem;
  margin: 2rem auto; padding: 0 1rem; font: 1rem/1.5 system-ui, sans-serif; }
table { border-collapse: collapse; margin: 1rem 0; }
th, td { border-bottom: 1px solid var(--line); padding: .25rem .8rem .25rem 0;
  text-align: left; vertical-align: top; overflow-wrap: anywhere; }
th { overflow-wrap: break-word; }
td.number { text-align: right; font-variant-numeric: tabular-nums; }
.divisions td.number { white-space: nowrap; }
img { max-width: 100%; height: auto; background: #fff; }
figure { margin: 1rem 0; } figcaption { margin-top: .3rem; }
.warning { color: var(--warn); }
"""
NUMBERS = (("rms_px", ".3f"), ("median_px", ".3f"), ("mean_deg", ".4f"))
NAMES = {"rms": "RMS", "median": "Median", "mean": "Mean angle"}
HEADS = ("Not scored", "RMS (px)", "Median (px)", "Mean (deg)")
SHAPE = {
    "bend_x": "ends of x behind its middle by",
    "bend_y": "ends of y behind its middle by",
    "twist": "twisted by",
    "stretch": "x longer against y by",
}
# (what was found, what residuals are drawn)
SHOWN = {
    "board": ("Corners, numbered row by row.", "Residuals"),
    "grid": (
        "What was decoded: red grows along x of the grid, green along y.",
        "Residuals of every second row and column of points",
    ),
}


class Photograph(NamedTuple):
    """Hold what the page shows of one image.

    Attributes
    ----------
    name : str
        Name of the image.
    score : ImageScore or None
        Its score.
    seen, residuals : str or None
        Names of its two figures. With `score`, all are None for an image that could not
        be used.
    reason : str
        Remark on the image.
    """

    name: str
    score: ImageScore | None
    seen: str | None
    residuals: str | None
    reason: str


def page(
    image_set: ImageSet, result: dict[str, Any], photographs: Sequence[Photograph]
) -> str:
    """Return the page as text.

    Parameters
    ----------
    image_set : ImageSet
        The set.
    result : dict
        What `raxel calibrate` writes as JSON.
    photographs : sequence of Photograph
        The images.

    Returns
    -------
    str
        HTML.
    """
    words = words_of(image_set.target)
    title = escape(f"{image_set.name}: calibration, {result['model']}")
    parts = [
        f"<h1>{title}</h1>",
        f"<p>{escape(image_set.camera or 'The camera is not described.')}</p>",
        *warnings(result["warnings"]),
        pairs(_numbers(image_set, result)),
        "<h2>Residuals in the image</h2>",
        figure(
            "residuals.png",
            f"Found {words.point} less where the camera sees it, for all "
            f"{words.target}s, each in its colour. Arrows of different {words.target}s "
            "that agree at one place show what the camera cannot follow; arrows all "
            "ways show noise.",
        ),
        "<h2>Stability</h2>",
        *_stability(result["stability"], words),
        "<h2>Coverage</h2>",
        figure(
            "coverage.png",
            f"How many {words.target}s cover each part of the image. Where none is, a "
            "formula is a guess and a table has no ray.",
        ),
        "<h2>Photographs</h2>",
        _table(photographs, words),
        *(_photograph(p, words) for p in photographs if p.score is not None),
    ]
    return document(title, parts)


def document(title, parts):
    """The whole file of a page; title and parts (list of text) are HTML."""
    body = "\n".join(parts)
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'{MARK}\n<meta name="viewport" content="width=device-width">\n'
        f"<title>{title}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n{body}\n"
        "</body>\n</html>\n"
    )


def _numbers(image_set, result):
    """[(what, value in words)] of the camera and its fit."""
    camera, misfit = result["camera"], result["misfit"]
    yield "Image", f"{image_set.width} x {image_set.height} px"
    if "size" in result:
        yield "Board, by vote", _vote(result["size"])
    if "focal_px" in camera:
        f, p = camera["focal_px"], camera["principal_point_px"]
        yield "Focal lengths", f"{f[0]:.2f} and {f[1]:.2f} px"
        yield "Principal point", f"({p[0]:.2f}, {p[1]:.2f}) px"
        yield "Radial terms", ", ".join(f"{k:.5g}" for k in camera["radial"])
    if "share_of_image_with_ray" in camera:
        yield (
            "Rays for",
            f"{100 * camera['share_of_image_with_ray']:.1f} % of the image",
        )
        yield "Lengths in", camera["units"]
    angles = camera["field_of_view_deg"]
    for name, what in (
        ("horizontal", "Field of view, middle row"),
        ("vertical", "Field of view, middle column"),
        ("from_axis", "Largest angle from the axis"),
    ):
        yield what, told(angles[name], ".2f", " deg")
    share = camera["share_of_image_under_boards"]
    target, point = words_of(image_set.target)[:2]
    yield f"{target.capitalize()}s cover", f"{100 * share:.1f} % of the image"
    for key, form in NUMBERS:
        name, unit = key.split("_")
        yield (f"{NAMES[name]}, fitted {target}s", told(result[key], form, f" {unit}"))
    yield f"Single {point}s scatter by", told(misfit["scatter_px"], ".3f", " px")
    yield f"Stated of single {point}s", told(misfit["stated_sd_px"], ".3f", " px")
    yield from _shape(result["board_shape"], target, result["unit"])
    if (corners := result["board_corners"]) is not None:
        name = f"{target.capitalize()}: {point}s"
        yield name, _beside(corners, result["unit"])
    if of := result["wrong_points_of"]:
        counts = ", ".join(f"{name}: {n}" for name, n in of.items())
        yield f"{point.capitalize()}s without weight", counts
    if "chosen_because" in result:
        yield "Chosen", result["chosen_because"]
    for model, found in result.get("cross_validation", {}).items():
        what = f"{model}, kept-out {target}s"
        if "refused" in found:
            yield what, found["refused"]
            continue
        own = found["own"]
        yield (
            what,
            f"{told(own['rms_px'], '.3f', ' px')} RMS, "
            f"{told(own['mean_deg'], '.4f', ' deg')} mean",
        )


def _shape(found, target, unit):
    """[(what, value in words)] of the board's shape."""
    if found is None:
        yield f"Shape of the {target}", "taken as stated, not asked for"
        return
    for name, what in SHAPE.items():
        value, sd, used = (found[name][key] for key in ("value", "sd", "used"))
        # A stretch is a ratio.
        times, of = (100, "%") if name == "stretch" else (1, unit)
        yield (
            f"{target.capitalize()}: {what}",
            f"{times * value:.3g} +- {times * sd:.2g} {of}, "
            f"{'used' if used else 'not used'}",
        )


def _beside(corners, unit):
    """Whether corners lie where they are taken to be, in words."""
    if corners["as_stated"]:
        return f"where they are taken to be (p = {corners['p_value']:.2g})"
    number = corners["worst"]
    off, p_value = math.hypot(*corners["offsets"][number]), corners["p_value"]
    return f"number {number}, from 0, is {off:.2g} {unit} off (p = {p_value:.2g})"


def _vote(size):
    """How photographs voted for the size of a board, in words."""
    told = [
        f"{vote['columns']} x {vote['rows']} corners in {len(vote['files'])}"
        for vote in size["votes"]
    ]
    return f"{', '.join(told)} of {size['photographs']} photographs"


def warnings(texts):
    """A paragraph (text) for each warning."""
    return [f'<p class="warning">warning: {escape(text)}</p>' for text in texts]


def pairs(named):
    """A table of (what, value in words)."""
    rows = (f"<tr><th>{escape(a)}</th><td>{escape(b)}</td></tr>" for a, b in named)
    return "<table>\n" + "\n".join(rows) + "\n</table>"


def _stability(found, words):
    """What halves of the photographs tell of each other: picture, rule, table."""
    if found is None:
        return [
            f"<p>Not tested: too few {words.target}s, or no part of the image that "
            "halves of them share.</p>"
        ]
    return [
        figure(
            "stability.png",
            "Where the second half sees the rays of the first, divided by "
            f"'{found['divided_by']}', the worst division: "
            f"{found['disagreement_px']:.2g} px apart (RMS, after the best rotation), "
            f"of which the {words.point}s' scatter explains "
            f"{found['scatter_px']:.2g} px, and {found['allowed_px']:.2g} px with what "
            "photographs of one half differ by.",
        ),
        f"<p>{words.target.capitalize()}s differ from each other "
        f"{found['photographs_over_scatter']:.2g} times as much as their "
        f"{words.point}s' scatter explains. There is a warning where that is more than "
        f"{ERRATIC:g} and leads to halves {ERRATIC_PX:g} px apart or more; and where "
        f"halves are {TIMES:g} times as far apart as such {words.target}s explain and "
        f"{LEAST_PX:g} px or more, and chance does so in fewer than one of "
        f"{1 / SURE:,.0f} sets.</p>",
        _divisions(found["divisions"]),
        *(
            f"<p>{name} half of the worst division: {escape(', '.join(half))}.</p>"
            for name, half in zip(("First", "Second"), found["halves"], strict=True)
        ),
    ]


def _divisions(divisions):
    keys = (
        ("disagreement_px", ".2f"),
        ("scatter_px", ".2f"),
        ("allowed_px", ".2f"),
        ("p_value", ".2g"),
    )
    heads = "Divided by", "Apart (px)", "By scatter (px)", "Explained (px)", "p"
    rows = [
        f"<tr><td>{escape(each['divided_by'])}</td>"
        f"{numbers([told(each[key], form, '') for key, form in keys])}</tr>"
        for each in divisions
    ]
    head = "".join(f"<th>{name}</th>" for name in heads)
    return "\n".join(
        ['<table class="divisions">', f"<tr>{head}</tr>", *rows, "</table>"]
    )


def _table(photographs, words):
    names = "Photograph", f"{words.point.capitalize()}s", *HEADS
    head = "".join(f"<th>{name}</th>" for name in names)
    rows = "\n".join(_row(p) for p in photographs)
    return f"<table>\n<tr>{head}</tr>\n{rows}\n</table>"


def _row(photograph):
    name, score = escape(photograph.name), photograph.score
    if score is None:
        why = escape(photograph.reason or "not found")
        return f'<tr><td>{name}</td><td colspan="5">{why}</td></tr>'
    cells = [score.n_corners, score.n_without_ray]
    cells += [told(getattr(score, key), form, "") for key, form in NUMBERS]
    return f"<tr><td>{name}</td>{numbers(cells)}</tr>"


def _photograph(photograph, words):
    name = escape(photograph.name)
    note = f" {photograph.reason}." if photograph.reason else ""
    found, residuals = SHOWN[words.target]
    scale = f"on one scale for all {words.target}s"
    return "\n".join(
        [
            f"<h3>{name}</h3>",
            figure(photograph.seen, f"{found}{note}"),
            figure(photograph.residuals, f"{residuals}, {scale}."),
        ]
    )


def numbers(cells):
    """Cells of a row with numbers in words."""
    return "".join(f'<td class="number">{cell}</td>' for cell in cells)


def figure(name, caption):
    """A picture beside the page, with its caption."""
    return (
        f'<figure><img src="{name}" alt="{escape(caption)}" loading="lazy">'
        f"<figcaption>{escape(caption)}</figcaption></figure>"
    )


def told(number, form, unit):
    """A number in words, such as told(0.12, ".3f", " px")."""
    known = number is not None and math.isfinite(number)
    return f"{number:{form}}{unit}" if known else "unknown"
