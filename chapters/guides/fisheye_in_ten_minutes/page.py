# %% [markdown]
# # Calibration of a fisheye in ten minutes
#
# **Question.** A fisheye lens of 183° is calibrated from images of a printed
# chessboard. Given a printer and the camera, this guide shows each step, the commands
# with their real output, and the values of a good result.

# %%
from functools import partial

from chapters.guides.fisheye_in_ten_minutes.experiment import (
    CALIBRATE,
    CHECK,
    CORNERS,
    EVALUATE,
    LENS,
    SIZES,
    UNDISTORT,
    board_image,
    calibrate,
    find_corners,
    inner_boards,
    look_through,
    model_scores,
    places_of,
    views_of,
)
from chapters.guides.fisheye_in_ten_minutes.report import COMMANDS, numbers, transcript
from chapters.shared.records import record, set_of
from repro.page import open_results, show, show_table, value
from repro.run import Plan, experiment

# %%
RECORDED = "calibrations"  # of data/records


@experiment(
    "ext_fisheye_pictures",
    artefact="ext_fisheye_corners",
    inputs=("data/rigs/coolpix-fce8-zoom-3.yaml",),
)
def ext_fisheye_pictures(effort):
    """The images: boards of the plan, and held-out boards."""
    size = SIZES[effort]
    count = len(places_of(size.plan)) + size.kept_out
    return Plan(
        lambda condition, rng: board_image(size, condition["view"], rng),
        [{"view": view} for view in range(count)],
        1,
        {"lens": LENS, "board": [size.columns, size.rows]},
    )


@experiment(
    "ext_fisheye_found", artefact="ext_fisheye_corners", needs=("ext_fisheye_pictures",)
)
def ext_fisheye_found(effort, made):
    """The corners, by the command."""
    run = partial(find_corners, SIZES[effort], *made.values())
    return Plan(lambda condition, rng: run(), [{}], 1)


@experiment(
    "ext_fisheye_camera",
    artefact="ext_fisheye_residuals",
    needs=("ext_fisheye_pictures", "ext_fisheye_found"),
)
def ext_fisheye_camera(effort, made):
    """The camera and its scores, by the commands."""
    run = partial(calibrate, SIZES[effort], *made.values())
    return Plan(lambda condition, rng: run(), [{}], 1)


@experiment(
    "ext_fisheye_look",
    artefact="ext_fisheye_views",
    needs=("ext_fisheye_pictures", "ext_fisheye_camera"),
)
def ext_fisheye_look(effort, made):
    """Corrected images."""
    run = partial(look_through, SIZES[effort], *made.values())
    return Plan(lambda condition, rng: run(rng), [{}], 1)


@experiment(
    "ext_fisheye_scores",
    artefact="ext_fisheye_models",
    needs=("ext_fisheye_pictures", "ext_fisheye_found"),
)
def ext_fisheye_scores(effort, made):
    """Four models from the inner boards, and from all of them."""
    size = SIZES[effort]

    def trial(condition, rng):
        fit, held_out = views_of(size, *made.values())
        if condition["boards"] == "inner":
            fit = fit[: inner_boards(size.plan)]
        return model_scores(size, fit, held_out, rng)

    return Plan(trial, [{"boards": "inner"}, {"boards": "all"}], 1)


@experiment(
    "ext_calibration_record",
    artefact="ext_fisheye_photographs",
    inputs=("data/records/calibrations.json",),
)
def ext_calibration_record(effort):
    """The content of the record; nothing is measured again."""
    kept = record(RECORDED)
    return Plan(
        lambda condition, rng: set_of(RECORDED, condition),
        [{"set": one["name"]} for one in kept["sets"]],
        1,
        {"record": RECORDED, "date": kept["date"]},
    )


# %% tags=["active-ipynb", "remove-input"]
# opened = {name: open_results(name) for name in COMMANDS}

# %% tags=["active-ipynb", "remove-input"]
# found = numbers(opened)

# %% tags=["active-ipynb", "remove-input"]
# for name, x in found.items(): value(name, x)

# %% tags=["active-ipynb"]
# show("ext_fisheye_views")

# %% [markdown]
# ## Findings
#
# 1. **`--model auto` selects the model**, the one with the smallest error on boards
#    that were not fitted, here {glue:text}`model`. That camera leaves
#    {glue:text}`held_out_px` RMS on held-out boards.
# 2. **The straightened image has no holes**, because a formula gives every pixel a ray.
#    A generic camera has rays only where boards were. Zhang's pinhole model cannot
#    represent such a lens. [The table](#ext_fisheye_models) compares the models.
#
# The images are rendered and cleaner than real ones. [Choice of a calibration
# method](choose_a_method.ipynb) gives the errors on real cameras.
#
# ## 1. Print
#
# Print a chessboard on A4 and glue it to something flat, such as glass or a stiff
# board. The board here has 17 × 12 inner corners at a pitch of 15 mm. Fine squares
# allow positions near the edge of the image circle. A square should be at least 15 px
# wide in the image. Corners of squares below about 5 px are imprecise or not found.
# Measure the printed pitch with a ruler.
#
# Install `raxel` from a copy of the repository with `pip install .` (`make setup`
# creates it, too: `.venv/bin/raxel`). This script writes a board:
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
# Print `board.svg` from a browser: A4 landscape, 100 %, no margins. If the printer
# needs margins, use a pitch of 13 mm in the script and in `set.yaml`. Glue the board
# to a larger white surface, so that it has a white border one square wide.
#
# ## 2. Take images
#
# Keep focus and zoom fixed. Show the whole board in each image. If no board is
# detected, [a monitor](../your_photographs.md) can be the target.
#
# - **One board in the middle**, close and tilted.
# - **A ring half way out**: 5 boards at about 35° from the optical axis, so close
#   that they overlap in the image.
# - **A ring at the edge**: 10 boards at about 75° from the axis and farther away,
#   with rows along the edge. Tilt the inner edge towards the lens.
# - **A few more** at such positions, marked `use: evaluate`. These held-out images
#   measure the accuracy of the calibration.
#
# Put the images in a folder with a file `set.yaml`:
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
# # ... one line per image, PNG or JPEG
# - {image: 20.png, use: evaluate}
# ```
#
# Sections 1 and 2 describe the board and the images of the full report. The outputs
# below are those of this build: a quick one renders a smaller board and fewer images.
#
# ## 3. Calibrate

# %% tags=["active-ipynb"]
# corners, camera, look = (opened[name] for name in COMMANDS)

# %% tags=["active-ipynb", "remove-input"]
# transcript(corners, CHECK, CORNERS)

# %% tags=["active-ipynb", "remove-input"]
# transcript(camera, CALIBRATE, EVALUATE)

# %% [markdown]
# `auto` divides the boards into four parts, fits each model without one part at a
# time, and compares the errors on the part left out (cross-validation). A corner
# without a ray counts as 5 px. `--report FOLDER` also writes a page with images of the
# corners, residuals and coverage.
#
# ## Values of a good result
#
# | Value | Good | Here |
# |---|---|---|
# | detected boards | all | {glue:text}`found_of` |
# | RMS, held-out boards | as on real cameras | {glue:text}`held_out_px` |
# | RMS, fitted boards | at least half of that | {glue:text}`fitted_px` |
# | `boards cover` | 90 % of the image circle | {glue:text}`covered` of all pixels |
# | lines with `warning:` | none | {glue:text}`warnings` |
#
# The command counts all pixels. A full circle of diameter D in an image of W × H
# fills π D² / (4 W H) of them.
#
# A small error on fitted boards is no proof of accuracy, because a flexible model
# follows the noise of its own corners. Beyond all boards a formula extrapolates, and no
# residual shows its error there. `calibrate` then prints a warning with an estimate.
#
# ## 4. Correct

# %% tags=["active-ipynb", "remove-input"]
# transcript(look, UNDISTORT)

# %% [markdown]
# In a program, OpenCV corrects images in real time with two remap tables:
#
# ```python
# import cv2
# from raxel.cameras import load_camera
# from raxel.multiview.views import perspective_view, source_pixels
#
# camera = load_camera("camera.npz")
# sources = source_pixels(camera, perspective_view(camera))
# map_x, map_y = cv2.split(sources)
# image = cv2.imread("fisheye/01.png")
# cv2.imwrite("ahead.png", cv2.remap(image, map_x, map_y, cv2.INTER_LINEAR))
# ```
#
# The tables are `float32` and give the source position of each pixel of the corrected
# image. No pinhole view covers 183°. Rotate `R_camera_view` of the view, or unroll
# the circle with `raxel.multiview.views`.
#
# ## Comparison of models

# %% tags=["active-ipynb"]
# show_table("ext_fisheye_models", digits=3)

# %% [markdown]
# *OpenCV fisheye* and *Kannala-Brandt* share one formula, and the rendered lens
# follows it exactly, so the comparison favours both. Kannala-Brandt gives every pixel
# a ray even from the inner boards. The generic camera needs no formula, but many
# boards. Real lenses follow the formula only approximately. For them `auto` can select
# smooth rays (`spline`), which also cover the whole image.
#
# The fit of OpenCV's model starts from a planar view of each board, which a board
# near 90° does not have. A fit that does not converge gives no camera or a large
# residual. Repeat it without the boards at the edge. The fit of *Kannala-Brandt* has
# no such limit. [Choice of a calibration method](choose_a_method.ipynb) compares the
# models on real cameras.
#
# ## Limits
#
# - Light, focus and the flatness of the board are perfect here.
# - The plan is for an image circle of 183°. Other plans were not compared.
# - Other lenses have other image shapes. The boards must cover them.
