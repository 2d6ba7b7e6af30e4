"""Results of this page read: values of the prose, figures, tables."""

import textwrap

from repro.page import Shown, literal, new_figure
from repro.run import Check, Drawing, Table, cell, figure, in_columns, table

# Results of the commands, and the numbers of the prose.


NAMES = {
    "zhang": "Zhang",
    "opencv_fisheye": "OpenCV fisheye",
    "kannala_brandt": "Kannala-Brandt",
    "generic": "Generic",
}
SETS = ("inner", "all")
CAMERA, VIEWS = "ext_fisheye_camera", "ext_fisheye_look"
FOUND, SCORES = "ext_fisheye_found", "ext_fisheye_scores"
COMMANDS = (FOUND, CAMERA, VIEWS)


def output_of(result, command):
    """Return the output of a command."""
    return result.texts("output", command)[0]


def numbers(results):
    """Return the texts of the prose: name -> value."""
    found, camera = results[FOUND], results[CAMERA]
    detected, boards = (int(found.column(name)[0]) for name in ("found", "boards"))
    warnings = output_of(camera, "calibrate").count("warning:")
    names = ("covered_share", "fitted_px", "held_out_px")
    covered, fitted, held_out = (camera.column(name)[0] for name in names)
    return {
        "model": camera.texts("model")[0],
        "covered": f"{100 * covered:.0f} %",
        "found_of": f"{detected} of {boards}",
        "warnings": str(warnings) if warnings else "none",
        "fitted_px": f"{fitted:.2g} px",
        "held_out_px": f"{held_out:.2g} px",
    }


# A street through a fisheye, corrected by the calibrated camera.


@figure("ext_fisheye_views", needs=("ext_fisheye_look",), evidence="rendered")
def ext_fisheye_views(results):
    """Draw a street as taken, and as a pinhole view."""
    look = results[VIEWS]
    panels = {
        "As taken": look.arrays("street")[0],
        "Straightened": look.arrays("ahead")[0],
    }
    drawn, axes = new_figure(1, 2, height_in=2.6)
    for place, (title, image) in zip(axes, panels.items(), strict=True):
        place.imshow(image, cmap="gray", vmin=0, vmax=255)
        place.set_title(title)
        place.set_axis_off()
    share = look.column("seen_share")[0]
    return Drawing(
        drawn,
        {"panel": list(panels), "share of pixels in the image": [1.0, share]},
        "Image of a street through the rendered 183° lens, and the same image as a "
        "pinhole view, remapped with the calibrated camera. Straight edges are "
        "straight.",
        Check(share == 1, "Every pixel of the straightened image has a source pixel."),
    )


# Comparison of four calibrations, and the commands with their output.


QUANTITIES = {
    "Fitted boards: RMS (px)": ("fitted_px", 1),
    "Held-out boards: RMS (px)": ("held_out_px", 1),
    "Held-out boards: angle (deg)": ("held_out_deg", 1),
    "Corners with a ray (%)": ("corners_with_ray", 100),
    "Image circle with a ray (%)": ("image_with_ray", 100),
    "Error of the rays (deg)": ("ray_deg", 1),
}
WIDTH = 68  # characters of a line of output
WHICH = {"inner": "inner rings", "all": "all"}


@table("ext_fisheye_models", needs=("ext_fisheye_scores",), evidence="rendered")
def ext_fisheye_models(results):
    """Compare three models with a formula and the generic camera."""
    scores = results[SCORES]
    rejected = [
        f" No camera: {name}, boards: {WHICH[use]} ({literal(reason)})."
        for use in SETS
        for model, name in NAMES.items()
        if (reason := scores.texts(model, "reason", boards=use)[0])
    ]
    return Table(
        in_columns(_scored_row(scores, use, model) for use in SETS for model in NAMES),
        "Errors and coverage of four models fitted to the same corners. On held-out "
        "boards only the pose is fitted. Error of the rays: median angle "
        "to the true rays, over the pixels with a ray, after the best rotation."
        + "".join(rejected),
    )


def _scored_row(scores, use, model):
    found = scores.one(boards=use)
    errors = {
        title: cell(unit * found.column(model, quantity)[0])
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
