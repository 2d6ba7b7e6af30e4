"""Comparison of three calibrations, and the commands with their output."""

import textwrap

from chapters.guides.fisheye_in_ten_minutes.results import (
    NAMES,
    SCORES,
    SETS,
    output_of,
)
from repro.page.reader import Shown
from repro.page.wording import literal
from repro.run.columns import cell, in_columns
from repro.run.experiment import table
from repro.run.outcomes import Table

QUANTITIES = {
    "Fitted boards: RMS (px)": ("fitted_px", 1),
    "Kept out: RMS (px)": ("kept_out_px", 1),
    "Kept out: angle (deg)": ("kept_out_deg", 1),
    "Corners with a ray (%)": ("corners_with_ray", 100),
    "Image circle with a ray (%)": ("image_with_ray", 100),
    "Error of the rays (deg)": ("ray_deg", 1),
}
WIDTH = 68  # characters of a line of output
WHICH = {"inner": "inner rings", "all": "all"}


@table("ext_fisheye_models", needs=("ext_fisheye_scores",), evidence="rendered")
def ext_fisheye_models(results):
    """Compare Zhang, OpenCV's fisheye model and the generic camera."""
    scores = results[SCORES]
    refused = [
        f" No camera: {name}, boards: {WHICH[use]} ({literal(reason)})."
        for use in SETS
        for model, name in NAMES.items()
        if (reason := scores.texts(f"{model}.reason", boards=use)[0])
    ]
    return Table(
        in_columns(_scored_row(scores, use, model) for use in SETS for model in NAMES),
        "Errors and coverage of three models fitted to the same corners. Kept out: "
        "held-out boards, with only their pose fitted. Error of the rays: median angle "
        "to the true rays, over the pixels with a ray, after the best rotation."
        + "".join(refused),
    )


def _scored_row(scores, use, model):
    found = scores.one(boards=use)
    errors = {
        title: cell(unit * found.column(f"{model}.{quantity}")[0])
        for title, (quantity, unit) in QUANTITIES.items()
    }
    boards = f"{WHICH[use]} ({found.column('boards')[0]:.0f})"
    return {"Boards": boards, "Model": NAMES[model], **errors}


def transcript(result, *commands):
    """Return the commands as typed, each with its output."""
    text = "\n".join(
        folded(f"$ raxel {' '.join(typed)}", " \\\n")
        + f"\n{folded(output_of(result, typed[0]).rstrip())}\n"
        for typed in commands
    )
    return Shown(f"````text\n{text}````", f"<pre>{text}</pre>")


def folded(text, end="\n"):
    """Wrap long lines with an indent, so that none is truncated."""
    return "\n".join(
        f"{end}    ".join(
            textwrap.wrap(line, WIDTH, break_long_words=False, break_on_hyphens=False)
        )
        if len(line) > WIDTH
        else line
        for line in text.split("\n")
    )
