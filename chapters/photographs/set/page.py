# %% [markdown]
# # {glue:text}`title`
#
# **Question.** A pinhole with two radial terms, or a general camera with a
# ray for every pixel: which one predicts photographs that it has not seen,
# and for how much of the image does it answer at all?
#
# {glue:text}`about`

# %%
from functools import partial

from chapters.photographs.set import results
from chapters.photographs.set.exercises import (
    exercise_camera,
    exercise_corner,
    field_of_view_task,
    residual_task,
)
from chapters.photographs.set.trials.study import (
    SIZES,
    boards_of,
    calibrated,
    conditions_of,
    fit_part,
    fold_part,
    image_part,
    scores,
    settings_of,
)
from chapters.shared.photographs.notes import origin, title
from chapters.shared.photographs.reading import BOARDS, Study
from raxel.sets import load_set
from repro.page.exercise import check
from repro.page.reader import open_results, show, show_code, show_table, value
from repro.run.experiment import experiment
from repro.run.outcomes import Plan


# %%
def study_trial(folder, size, condition, rng):
    """One condition of the study, by its part."""
    image_set = load_set(folder)
    if condition["part"] == "image":
        return image_part(folder, image_set, condition["view"], size)
    boards = boards_of(folder, size)
    if condition["part"] == "fit":
        return fit_part(image_set, boards, size, rng)
    parts = sum(c["part"] == "fold" for c in conditions_of(image_set, size))
    return fold_part(image_set, boards, condition["fold"], parts, rng)


@experiment(
    "photograph_study", artefact="ext_models", shards={"full": 2}, per_set=BOARDS
)
def photograph_study(effort, folder):
    """Every image, the calibration from all, and every part kept out."""
    image_set, size = load_set(folder), SIZES[effort]
    return Plan(
        partial(study_trial, folder, size),
        conditions_of(image_set, size),
        1,
        settings_of(image_set),
    )


# %% tags=["active-ipynb", "remove-input"]
# study = Study(open_results("photograph_study"))

# %% tags=["active-ipynb"]
# value("title", title(study))

# %% tags=["active-ipynb"]
# value("about", results.about(study))

# %% tags=["active-ipynb"]
# value("origin", origin(study))

# %% tags=["active-ipynb"]
# value("found", results.found(study))

# %% tags=["active-ipynb"]
# value("zhang", results.zhang(study))

# %% tags=["active-ipynb"]
# value("general", results.general(study))

# %% tags=["active-ipynb"]
# value("peer", results.peer(study))

# %% tags=["active-ipynb"]
# value("kept_out", results.kept_out(study))

# %% tags=["active-ipynb"]
# value("coverage", results.coverage(study))

# %% tags=["active-ipynb"]
# value("comparison", results.comparison(study))

# %% tags=["active-ipynb"]
# value("angles", results.angles(study))

# %% tags=["active-ipynb"]
# value("straightness", results.straightness(study))

# %% tags=["active-ipynb"]
# value("exercise", results.exercise(study))

# %% tags=["active-ipynb"]
# show("ext_cross_validation")

# %% [markdown]
# ## Findings
#
# - {glue:text}`found`
# - {glue:text}`comparison`
# - {glue:text}`peer`
# - {glue:text}`coverage`
# - {glue:text}`straightness`

# %% [markdown]
# ## Method
#
# 1. **Corners.** One detector finds the board's corners to a fraction of a
#    pixel. All models get the same ones.
# 2. **Zhang's method** {cite}`zhang2000`, through OpenCV: focal lengths,
#    principal point, two radial terms, and one pose per photograph. Six
#    numbers describe the camera.
# 3. **The general camera**, by the standard generic method of section 2.4
#    {cite}`sturm2004`: no model of the lens. Between the corners, a
#    homography per cell tells which point of the board each pixel sees; on
#    boards whose cells bend by more than their corners are uncertain, a
#    smooth surface through all corners.
#    Three overlapping boards give the centre, bundle adjustment and further
#    boards refine it. The result is a table of rays. A pixel that no board
#    covered has none.
# 4. **OpenCV's fisheye model** {cite}`kannala2006` stands beside these two:
#    eight numbers, fitted by `cv2.fisheye.calibrate`. It is scored like
#    them and decides nothing.
# 5. **Cross-validation.** A model is judged on photographs that were kept
#    out of its calibration. There, only the pose of the board is fitted, in
#    the same way for every model. The errors are the distance in px between
#    each corner and its prediction, and the angle at its ray. Each is taken
#    at the pose that makes it smallest: one pose for px, another for angles.
#
# A model with rays everywhere is easily blamed where the other is silent.
# So all are scored twice: on every corner they have a ray for, and on the
# corners that Zhang and the general camera both have a ray for.

# %% tags=["active-ipynb"]
# show_code(calibrated, fold_part, scores)

# %% [markdown]
# ## The photographs and their corners


# %% tags=["active-ipynb"]
# show("ext_corners")

# %% [markdown]
# Which corner is the first, and which way the rows run, is fixed by rule: x
# turns clockwise into y in the image, and the first cell is bright where
# the board allows it. On a symmetric board the order may be turned by half
# a turn from one photograph to the next. That changes the pose of the
# board, and nothing else.
#
# {glue:text}`origin`
#
# ## Cameras from the same corners
#
# {glue:text}`zhang`
#
# {glue:text}`general`
#
# ## Residuals of photographs kept out
#
# {glue:text}`kept_out`


# %% tags=["active-ipynb"]
# show("ext_residuals")

# %% [markdown]
# Arrows that agree with their neighbours show distortion that the model
# cannot follow. Arrows in all directions show the noise of the corners, and
# for the general camera also the noise of its own rays, which it took from
# a few boards each.
#
# ## The photograph without distortion


# %% tags=["active-ipynb"]
# show("ext_undistorted")

# %% [markdown]
# The distances from a flat lattice named above are in px of this view,
# which stretches what is far from its middle. The homography hides an error
# of the pose or of the centre. The angles of the cross-validation do not.
#
# ## Compared models


# %% tags=["active-ipynb"]
# show_table("ext_models", digits=3)

# %% [markdown]
# ### Every corner, every model
#
# The table above asks on shared corners, where a table of rays has an answer.
# Whoever wants to use all of the picture asks otherwise: how far off is a
# model on whatever a photograph shows?

# %% tags=["active-ipynb"]
# show_table("ext_every_corner", digits=3)

# %% [markdown]
# {glue:text}`angles`
#
# A model counts as better when a one-sided Wilcoxon signed-rank test over
# the photographs gives p < 0.01 and its median error is smaller by a factor
# of at least 1.05 with the whole 95 % interval. With six photographs or
# fewer, no test of this kind can decide.

# %% [markdown]
# ## Reading and limits
#
# - The fitted errors flatter the general camera: it has a parameter for
#   nearly everything that it was fitted to. Only photographs kept out
#   compare the models.
# - The general camera knows the pixels that boards covered, and is as good
#   as the interpolation inside a cell. Large cells near the edge of a
#   strongly distorted image can bend more than their corners tell.
# - It has one centre. Where rays do not meet in one point, as in many
#   mirrors and wide lenses, it spreads that error over its rays.
# - Every error contains the noise of the corners, and what bends the board.
#   Both models suffer alike.
# - Photographs of one session share the board, the light and the lens's
#   temperature. Cross-validation cannot see what they share.
# - Corners come from one detector. Photographs that it refuses are left out,
#   and it refuses the hard ones: a set with many refusals is judged on its
#   easy part.

# %% [markdown]
# ## Try it yourself
#
# Open this page as a notebook (`make notebooks`), put an answer in place of
# `None`, and run the cell. {glue:text}`exercise`
#
# **1.** A focal length in px means little without the image size. How many
# degrees does the camera see horizontally, from the left rim of the first
# pixel to the right rim of the last? Leave the radial terms out. Pixel
# centres are at whole numbers.

# %% tags=["active-ipynb"]
# camera = exercise_camera(study)

# %% tags=["active-ipynb"]
# camera

# %% tags=["active-ipynb"]
# check(None, **field_of_view_task(camera))

# %% [markdown]
# **2.** One corner of the board, its place on the board, the pose of the
# board (it takes board coordinates to camera coordinates), and the pixel
# where the corner was found. Compute the residual, found less predicted, as
# $(\Delta u, \Delta v)$ in px, with numpy alone: pose, equations 2.2 and
# 2.4, calibration matrix.

# %% tags=["active-ipynb"]
# corner = exercise_corner(study)

# %% tags=["active-ipynb"]
# corner

# %% tags=["active-ipynb"]
# check(None, **residual_task(camera, corner))
