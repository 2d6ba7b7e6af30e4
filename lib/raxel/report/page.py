"""The page of a report: numbers and figures, one file of HTML without scripts."""

from __future__ import annotations

import contextlib
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
from raxel.evaluation.diagnoses import (
    TEXT,
    camera_lines,
    comparison_lines,
    line,
    number,
    overview,
    summary,
)
from raxel.evaluation.distortion import MIN_N_BOARDS
from raxel.evaluation.split_half import (
    MAX_FACTOR,
    MAX_FACTOR_PX,
    MIN_DIFFERENCE_PX,
    MIN_RATIO,
    P_THRESHOLD,
)
from raxel.io.files import check_can_be_written
from raxel.sets.mirror_set import MirrorSet
from raxel.sets.model import ImageSet, words_of

# A report is a folder: complete, or as it was before.


PAGE, ERRORS = "index.html", "uncertainty.png"
MARK = '<meta name="generator" content="raxel calibrate">'
FILES = re.compile(
    r"index\.html|(corners|points|residuals|shape)-\d+\.jpg|"
    r"(residuals|coverage|stability|profiles|uncertainty)\.png"
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
    # The new one is made in the folder that contains it.
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
.pairs th::first-letter { text-transform: uppercase; }
.wide { overflow-x: auto; }
pre { overflow-x: auto; }
img { max-width: 100%; height: auto; background: #fff; }
figure { margin: 1rem 0; } figcaption { margin-top: .3rem; }
.warning { color: var(--warn); }
"""
FORMATS = {"rms_px": ".3f", "median_px": ".3f", "mean_deg": ".4f"}
# Format of `raxel export`, file, line of code or command that reads it.
READERS = (
    (
        "opencv",
        "camera.yaml",
        "K, D = (cv2.FileStorage('camera.yaml', 0).getNode(n).mat() for n in "
        "('camera_matrix', 'distortion_coefficients'))",
    ),
    ("ros", "camera_info.yaml", "camera_info_url: file:///.../camera_info.yaml"),
    ("kalibr", "camchain.yaml", "kalibr_calibrate_imu_camera --cams camchain.yaml ..."),
    ("colmap", "cameras.txt", "_, model, width, height, *parameters = LINE.split()"),
    ("nerfstudio", "transforms.json", "ns-train nerfacto --data ."),
    ("mrcal", "camera.cameramodel", "model = mrcal.cameramodel('camera.cameramodel')"),
    (
        "maps",
        "maps.npz",
        "maps = np.load('maps.npz'); "
        "image = cv2.remap(image, maps['mapx'], maps['mapy'], cv2.INTER_LINEAR)",
    ),
    ("table", "rays.npz", "rays = np.load('rays.npz')['directions']"),
)
HEADS = ("Not scored", "RMS (px)", "Median (px)", "Mean angle (deg)")
RULE = (
    "{target}s differ from each other {found[photographs_over_scatter]:.2g} times as "
    "much as {point} scatter explains. There is a warning above {factor:g} times, if "
    "halves differ by {factor_px:g} px or more; and if halves differ by {least_px:g} "
    "px or more, {times:g} times what differences between images allow (p &lt; "
    "{p_threshold:g}, all divisions)."
)
# Captions of the two figures of an image.
CAPTIONS = {
    "board": ("Corners, numbered row by row.", "Residuals"),
    "grid": (
        "Decoded positions: red increases along x of the grid, green along y.",
        "Residuals of every second row and column of points",
    ),
}


class ReportImage(NamedTuple):
    """Hold what the page shows of one image.

    Attributes
    ----------
    name : str
        Name of the image.
    score : ImageScore or None
        Its score.
    detected, residuals : str or None
        Names of its two figures. With `score`, all are None for an image that could not
        be used.
    reason : str
        Remark on the image.
    """

    name: str
    score: ImageScore | None
    detected: str | None
    residuals: str | None
    reason: str


def page(
    image_set: ImageSet,
    result: dict[str, Any],
    images: Sequence[ReportImage],
    has_errors: bool,
) -> str:
    """Return the page as text.

    Parameters
    ----------
    image_set : ImageSet
        The set.
    result : dict
        What `raxel calibrate` writes as JSON.
    images : sequence of ReportImage
        The images.
    has_errors : bool
        Whether there is the figure ERRORS of predicted errors.

    Returns
    -------
    str
        HTML.
    """
    words = words_of(image_set.target)
    title = escape(f"{image_set.name}: calibration, {result['model']}")
    errors = figure(
        ERRORS,
        "Predicted standard deviation of where in the image each ray belongs, after "
        "the best rotation of the camera.",
    )
    parts = [
        f"<h1>{title}</h1>",
        f"<p>{escape(image_set.camera or 'No description of the camera.')}</p>",
        *warnings(result["warnings"]),
        pairs(overview(result, words)),
        "<h2>Residuals in the image</h2>",
        figure(
            "residuals.png",
            f"Residuals (detected minus projected {words.point}s) of all "
            f"{words.target}s, one colour each. Where arrows of several "
            f"{words.target}s agree, the model does not fit. Arrows in all directions "
            "are noise.",
        ),
        "<h2>Split-half test</h2>",
        *_stability(result["stability"], words),
        "<h2>Coverage</h2>",
        figure(
            "coverage.png",
            f"Number of {words.target}s that cover each part of the image. Without a "
            f"{words.target}, a parametric model extrapolates and a table has no rays.",
        ),
        *(("<h2>Uncertainty of the rays</h2>", errors) if has_errors else ()),
        "<h2>Images</h2>",
        table(("Image", f"{words.point}s".capitalize(), *HEADS), map(_row, images)),
        *(_figures(p, words) for p in images if p.score is not None),
        "<h2>Use the camera</h2>",
        _files(),
        "<h2>All results</h2>",
        pairs(_rows(image_set, result, words)),
    ]
    return document(title, parts)


def _files():
    """Files to take away, with the code that reads each."""
    lines = (
        f"# raxel export camera.npz --format {name} --out {file}\n{code}"
        for name, file, code in READERS
    )
    return f"<pre><code>{escape(chr(10).join(lines))}</code></pre>"


def document(title, parts):
    """The whole file of a page; title and parts (list of text) are HTML."""
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'{MARK}\n<meta name="viewport" content="width=device-width">\n'
        f"<title>{title}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n"
        + "\n".join([*parts, "</body>\n</html>\n"])
    )


def _rows(image_set, result, words):
    """Yield (label, text) of the camera and its tests."""
    yield "image", f"{image_set.width} x {image_set.height} px"
    if "size" in result:
        yield "board size, by vote", _vote(result["size"])
    if "chosen_because" in result:
        yield line("chosen", words, result)
    yield from camera_lines(result, words)
    yield from summary(result, words, MIN_N_BOARDS)
    if counts := result["wrong_points_of"]:
        yield (
            f"excluded {words.point}s",
            ", ".join(f"{name}: {n}" for name, n in counts.items()),
        )
    yield from comparison_lines(result.get("cross_validation", {}), words)


def _vote(size):
    """The vote of the images for the size of a board, as text."""
    votes = [
        f"{vote['columns']} x {vote['rows']} corners in {len(vote['files'])}"
        for vote in size["votes"]
    ]
    return f"{', '.join(votes)} of {size['photographs']} images"


def warnings(texts):
    """A paragraph (text) for each warning."""
    return [f'<p class="warning">warning: {escape(text)}</p>' for text in texts]


def pairs(named):
    """A table of (label, text)."""
    rows = (f"<tr><th>{escape(a)}</th><td>{escape(b)}</td></tr>" for a, b in named)
    return '<table class="pairs">\n' + "\n".join(rows) + "\n</table>"


def _stability(found, words):
    """The split-half test: figure, rule, table."""
    if found is None:
        return [
            f"<p>Not tested: too few {words.target}s, or no image area that halves of "
            "them share.</p>"
        ]
    _, worst = line("halves", words, found, {"count": len(found["divisions"])})
    limits = {
        "factor": MAX_FACTOR,
        "factor_px": MAX_FACTOR_PX,
        "times": MIN_RATIO,
        "least_px": MIN_DIFFERENCE_PX,
        "p_threshold": P_THRESHOLD,
        "found": found,
    }
    rule = TEXT.format(RULE, **words._asdict() | limits)
    return [
        figure("stability.png", f"Ray differences of two halves; {worst}."),
        f"<p>{rule[0].upper()}{rule[1:]}</p>",
        _divisions(found["divisions"]),
        *(
            f"<p>{name} half of the worst division: {escape(', '.join(half))}.</p>"
            for name, half in zip(("First", "Second"), found["halves"], strict=True)
        ),
    ]


def _divisions(divisions):
    heads = "Divided by", "Difference (px)", "From scatter (px)", "Allowed (px)", "p"
    keys = "disagreement_px", "scatter_px", "allowed_px"
    forms = dict.fromkeys(keys, ".2f") | {"p_value": ".2g"}
    rows = (
        f"<td>{escape(each['divided_by'])}</td>"
        + numbers(number(each[key], form) for key, form in forms.items())
        for each in divisions
    )
    return table(heads, rows, "divisions")


def _row(image):
    name, score = escape(image.name), image.score
    if score is None:
        return (
            f'<td>{name}</td><td colspan="5">{escape(image.reason or "not found")}</td>'
        )
    cells = [score.n_corners, score.n_without_ray]
    cells += [number(getattr(score, key), form) for key, form in FORMATS.items()]
    return f"<td>{name}</td>{numbers(cells)}"


def _figures(image, words):
    note = f" {image.reason}." if image.reason else ""
    positions, residuals = CAPTIONS[words.target]
    return "\n".join(
        [
            f"<h3>{escape(image.name)}</h3>",
            figure(image.detected, f"{positions}{note}"),
            figure(
                image.residuals, f"{residuals}, same scale for all {words.target}s."
            ),
        ]
    )


def table(heads, rows, kind="scores"):
    """A table that scrolls on narrow screens; rows: HTML of the cells of each."""
    head = "".join(f"<th>{name}</th>" for name in heads)
    lines = "\n".join(f"<tr>{row}</tr>" for row in (head, *rows))
    return f'<div class="wide"><table class="{kind}">\n{lines}\n</table></div>'


def numbers(cells):
    """Cells of a row with numbers as text."""
    return "".join(f'<td class="number">{cell}</td>' for cell in cells)


def figure(name, caption):
    """A figure with its caption."""
    return (
        f'<figure><img src="{name}" alt="{escape(caption)}" loading="lazy">'
        f"<figcaption>{escape(caption)}</figcaption></figure>"
    )
