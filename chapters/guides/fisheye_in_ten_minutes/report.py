"""Results of this page read: values of the prose, figures, tables."""

import textwrap

import numpy as np

from repro.page import Shown, literal, new_figure
from repro.run import Drawing, Table, cell, figure, in_columns, table

# Results of the commands, and the numbers of the prose.


NAMES = {"zhang": "Zhang", "opencv_fisheye": "OpenCV fisheye", "generic": "Generic"}
SETS = ("inner", "all")
CAMERA, VIEWS = "ext_fisheye_camera", "ext_fisheye_look"
FOUND, SCORES = "ext_fisheye_found", "ext_fisheye_scores"
COMMANDS = (FOUND, CAMERA, VIEWS)


def output_of(result, command):
    """Return what a command printed."""
    return result.texts(f"said.{command}")[0]


def numbers(results):
    """Return the texts of the prose: name -> value."""
    found, camera = results[FOUND], results[CAMERA]
    detected, boards = (int(found.column(name)[0]) for name in ("found", "boards"))
    warnings = output_of(camera, "calibrate").count("warning:")
    ray_share, fitted, kept = (
        camera.column(name)[0] for name in ("ray_share", "fitted_px", "kept_out_px")
    )
    return {
        "ray_share": percent(ray_share),
        "found_of": f"{detected} of {boards}",
        "warnings": str(warnings) if warnings else "none",
        "fitted_px": f"{fitted:.2g} px",
        "kept_px": f"{kept:.2g} px",
    }


def percent(share):
    """Return a share as text."""
    return f"{100 * share:.0f} %"


# A street through a fisheye, corrected by the calibrated camera.


@figure("ext_fisheye_views", needs=("ext_fisheye_look",), evidence="rendered")
def ext_fisheye_views(results):
    """Draw a street as taken, and as a pinhole view."""
    look = results[VIEWS]
    panels = {
        "As taken": look.arrays("street")[0],
        "Straight ahead": look.arrays("ahead")[0],
    }
    drawn, axes = new_figure(1, 2, height_in=2.6)
    for place, (title, picture) in zip(axes, panels.items(), strict=True):
        place.imshow(picture, cmap="gray", vmin=0, vmax=255)
        place.set_title(title)
        place.set_axis_off()
    lit_share = [float(np.mean(picture > 0)) for picture in panels.values()]
    return Drawing(
        drawn,
        {"panel": list(panels), "share of pixels not black": lit_share},
        "Image of a street through the rendered 183° lens, and the same image as a "
        "pinhole view, remapped with the calibrated camera. Straight edges are "
        "straight. Black pixels have no ray.",
    )


# Comparison of three calibrations, and the commands with their output.


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
