# %% [markdown]
# # A fisheye in ten minutes
#
# **Question.** From a printed board to a corrected picture: what does one
# do, what does one see on the way, and what is good? A lens of 183° is
# calibrated here, by commands that are really run and what they print.

# %%
from functools import partial

from chapters.guides.fisheye_in_ten_minutes import results, tables
from chapters.guides.fisheye_in_ten_minutes.trials import boards, commands, models
from chapters.shared.records import record, set_of
from repro.page.reader import open_results, show, show_table, value
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

# %%
RECORDED = "calibrations"  # of data/records


@experiment(
    "ext_fisheye_pictures",
    artefact="ext_fisheye_corners",
    shards={"full": 2},
    inputs=("data/rigs/coolpix-fce8-zoom-3.yaml",),
)
def ext_fisheye_pictures(effort):
    """The photographs: boards by the plan, and boards that are kept out."""
    size = boards.SIZES[effort]
    count = len(boards.places_of(size.plan)) + size.kept_out
    return Plan(
        lambda condition, rng: boards.photograph(size, condition["view"], rng),
        [{"view": view} for view in range(count)],
        1,
        {"lens": boards.LENS, "board": [size.columns, size.rows]},
    )


@experiment(
    "ext_fisheye_found", artefact="ext_fisheye_corners", needs=("ext_fisheye_pictures",)
)
def ext_fisheye_found(effort, made):
    """The corners, by the command."""
    run = partial(commands.find_corners, boards.SIZES[effort], *made.values())
    return Plan(lambda condition, rng: run(), [{}], 1)


@experiment(
    "ext_fisheye_camera",
    artefact="ext_fisheye_residuals",
    needs=("ext_fisheye_pictures", "ext_fisheye_found"),
)
def ext_fisheye_camera(effort, made):
    """The camera and its scores, by the commands."""
    run = partial(commands.calibrate, boards.SIZES[effort], *made.values())
    return Plan(lambda condition, rng: run(), [{}], 1)


@experiment(
    "ext_fisheye_look",
    artefact="ext_fisheye_views",
    needs=("ext_fisheye_pictures", "ext_fisheye_camera"),
)
def ext_fisheye_look(effort, made):
    """Corrected images."""
    run = partial(commands.look_through, boards.SIZES[effort], *made.values())
    return Plan(lambda condition, rng: run(rng), [{}], 1)


@experiment(
    "ext_fisheye_scores",
    artefact="ext_fisheye_models",
    needs=("ext_fisheye_pictures", "ext_fisheye_found"),
)
def ext_fisheye_scores(effort, made):
    """Three models from the inner boards, and from all of them."""
    size = boards.SIZES[effort]

    def trial(condition, rng):
        fit, kept_out = commands.views_of(size, *made.values())
        if condition["boards"] == "inner":
            fit = fit[: boards.inner_boards(size.plan)]
        return models.model_scores(size, fit, kept_out, rng)

    return Plan(trial, [{"boards": "inner"}, {"boards": "all"}], 1)


@experiment(
    "ext_calibration_record",
    artefact="ext_fisheye_photographs",
    inputs=("data/records/calibrations.json",),
)
def ext_calibration_record(effort):
    """What the record holds; nothing is measured again."""
    kept = record(RECORDED)
    return Plan(
        lambda condition, rng: set_of(RECORDED, condition),
        [{"set": one["name"]} for one in kept["sets"]],
        1,
        {"record": RECORDED, "date": kept["date"]},
    )


# %% tags=["active-ipynb", "remove-input"]
# opened = {name: open_results(name) for name in results.COMMANDS}

# %% tags=["active-ipynb", "remove-input"]
# found = results.numbers(opened, opened[results.FOUND].effort)

# %% tags=["active-ipynb", "remove-input"]
# for name, x in found.items(): value(name, x)

# %% tags=["active-ipynb"]
# show("ext_fisheye_views")

# %% [markdown]
# ## Findings
#
# - **The generic camera** leaves {glue:text}`kept_px` on boards that it was
#   not calibrated with, and has a ray for {glue:text}`ray_share` of all pixels.
# - **OpenCV's fisheye model** needs fewer boards, and the right formula. **Zhang's
#   pinhole** cannot follow such a lens. [The table](#ext_fisheye_models) compares
#   the three, from the {glue:text}`inner` inner boards and from all
#   {glue:text}`boards`.
#
# The images are rendered and cleaner than real ones. [Which method for my
# camera](choose_a_method.ipynb) gives the errors on real cameras.
#
# ## 1. Print
#
# A chessboard on a sheet of A4, glued to something flat: glass, or a stiff
# board. Here it has {glue:text}`columns` × {glue:text}`rows` inner corners,
# {glue:text}`pitch:g` mm apart. Fine squares let the board lie near the rim
# of the picture; but a square should be at least 15 pixels wide, and below
# 7.5 the detector refuses it. Measure the printed pitch with a ruler.
#
# Install `raxel` from a copy of the repository: `pip install .` (`make setup`
# makes it, too: `.venv/bin/raxel`). This script writes a board:
#
# ```python
# from pathlib import Path
#
# columns, rows = 17, 12  # inner corners
# pitch_mm, border_mm = 15, 7.5
# width = (columns + 1) * pitch_mm + 2 * border_mm
# height = (rows + 1) * pitch_mm + 2 * border_mm
# side = f"h{pitch_mm}v{pitch_mm}h-{pitch_mm}z"
# squares = "".join(
#     f"M{border_mm + i * pitch_mm:g} {border_mm + j * pitch_mm:g}{side}"
#     for j in range(rows + 1)
#     for i in range(j % 2, columns + 1, 2)
# )
# Path("board.svg").write_text(
#     f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:g}mm" '
#     f'height="{height:g}mm" viewBox="0 0 {width:g} {height:g}">'
#     f'<path d="{squares}"/></svg>'
# )
# ```
#
# Print `board.svg` from a browser: A4 landscape, 100 %, no margins. If the
# printer needs margins, take a pitch of 13 mm here and in `set.yaml`. Glue it to
# something white and larger: it wants a white border one square wide.
#
# ## 2. Photograph
#
# One focus, one zoom. The whole board is in each picture. (Where no board
# is found, [a monitor](../your_photographs.md) can be the target.)
#
# - **One in the middle**, near and tilted.
# - **A ring half way out**: {glue:text}`half_boards` boards, about
#   {glue:text}`half_deg:.0f`° from the lens's axis, so near that they
#   overlap each other in the picture.
# - **A ring at the rim**: {glue:text}`rim_boards` boards, about
#   {glue:text}`rim_deg:.0f`° from the axis and farther away, rows along the
#   rim. Tilt the inner edge towards the lens.
# - **A few more** at such places, marked `use: evaluate`. No calibration
#   sees them, so they tell how good it is.
#
# Put the pictures in a folder with a file `set.yaml`:
#
# ```yaml
# raxel_set: 1
# name: fisheye
# camera: fisheye converter, 183 degrees
# resolution: [1024, 768]
# target: {kind: chessboard, columns: 17, rows: 12, pitch_mm: 15}
# views:
# - image: 01.png
# - image: 02.png
# # ... a line for each picture; JPEG will do as well
# - {image: 20.png, use: evaluate}
# ```
#
# ## 3. Calibrate

# %% tags=["active-ipynb"]
# corners, camera, look = (opened[name] for name in results.COMMANDS)

# %% tags=["active-ipynb", "remove-input"]
# tables.transcript(corners, commands.CHECK, commands.CORNERS)

# %% tags=["active-ipynb", "remove-input"]
# tables.transcript(camera, commands.CALIBRATE, commands.EVALUATE)

# %% [markdown]
# `--report FOLDER` writes a page with pictures of your corners, residuals
# and coverage as well. `--model auto` tries Zhang's pinhole, too, and keeps
# what predicts boards better that it has not seen.

# ## What good looks like
#
# | Look at | Good | Here |
# |---|---|---|
# | boards found | all | {glue:text}`found_of` |
# | kept out | as on [real cameras](choose_a_method.ipynb) | {glue:text}`kept_px` |
# | fitted | not less than half of that | {glue:text}`fitted_px` |
# | `a ray for` | 90 % of the image circle | {glue:text}`ray_share` |
# | lines with `warning:` | none | {glue:text}`warnings` |
#
# The command counts all pixels. A circle D pixels wide, whole in an image of
# W × H, fills π D² / (4 W H) of them.
#
# A fitted error alone says little: a camera with a ray for every pixel
# follows the noise of its own corners. A small error where there are rays
# says nothing of where there are none.
#
# ## 4. Correct

# %% tags=["active-ipynb", "remove-input"]
# tables.transcript(look, commands.UNDISTORT)

# %% [markdown]
# In a program, OpenCV does it in real time with two tables, made once:
#
# ```python
# import cv2
# from raxel.cameras import load_camera
# from raxel.multiview.perspective_view import perspective_view, source_pixels
#
# camera = load_camera("camera.npz")
# sources = source_pixels(camera, perspective_view(camera))
# map_x, map_y = cv2.split(sources)
# picture = cv2.imread("fisheye/01.png")
# cv2.imwrite("ahead.png", cv2.remap(picture, map_x, map_y, cv2.INTER_LINEAR))
# ```
#
# The tables are `float32`: where each pixel of the new image comes from in
# the old one. No pinhole sees 183°: rotate `R_camera_view` of the view, or
# unroll the circle with `raxel.multiview.cylindrical_view`.
#
# ## Which model?

# %% tags=["active-ipynb"]
# show_table("ext_fisheye_models", digits=3)

# %% [markdown]
# OpenCV's fisheye model has eight numbers. The rendered lens follows its
# formula exactly, so it is at its best here. It then has a ray for every
# pixel from the inner boards alone, which the generic camera cannot have: that
# one knows only what boards have covered. A real lens follows the
# formula more or less; the generic camera needs no formula.
#
# Its fit starts from a flat picture of each board, which a board near 90° does
# not have. A fit that did not converge has a large residual: calibrate it
# without the boards at the rim. [Which method for my
# camera](choose_a_method.ipynb) compares the models on real cameras.
#
# ## Limits
#
# - Light, focus and the flatness of the board are perfect here.
# - The plan is for a circle of 183°. Whether it is the best was not
#   asked.
# - Pictures of other lenses have other shapes: boards must cover them.
