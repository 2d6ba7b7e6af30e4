# %% [markdown]
# # {glue:text}`title`
#
# **Question.** A pinhole with two radial terms, or a general camera with a
# ray for every pixel: which one predicts photographs that it has not seen,
# and for how much of the image does it answer at all?
#
# {glue:text}`about`

# %% tags=["hide-cell"]
from functools import partial

from chapters.photographs.set.detectors import (
    detector_conditions,
    detector_trial,
    detectors_table,
    score,
)
from chapters.photographs.set.exercises import (
    exercise_camera,
    exercise_corner,
    field_of_view_task,
    residual_task,
)
from chapters.photographs.set.figures.fields import (
    held_out_errors,
    residual_fields,
)
from chapters.photographs.set.tables import images_table, models_table
from chapters.shared.photographs import sentences
from chapters.shared.photographs.pictures import (
    contact_sheet,
    undistorted_views,
)
from chapters.shared.photographs.reading import Study
from chapters.shared.photographs.study import (
    SIZES,
    calibrated,
    conditions_of,
    fold_part,
    scores,
    settings_of,
    study_trial,
)
from raxel.sets import load_set
from repro.page.exercise import check
from repro.page.reader import (
    open_results,
    show,
    show_code,
    show_table,
    value,
)
from repro.run.experiment import experiment, figure, table
from repro.run.outcomes import Plan

# %% [markdown]
# ## Method
#
# 1. **Corners.** One detector finds the board's corners to a fraction of a
#    pixel. Both models get the same ones.
# 2. **Zhang's method** {cite}`zhang2000`, through OpenCV: focal lengths,
#    principal point, two radial terms, and one pose per photograph. Six
#    numbers describe the camera.
# 3. **The general camera**, by the standard generic method of section 2.4
#    {cite}`sturm2004`: no model of the lens. Between the corners, a
#    homography per cell tells which point of the board each pixel sees.
#    Three overlapping boards give the centre, bundle adjustment and further
#    boards refine it. The result is a table of rays. A pixel that no board
#    covered has none.
# 4. **Cross-validation.** A model is judged on photographs that were kept
#    out of its calibration. There, only the pose of the board is fitted, in
#    the same way for both models. The error is the distance in px between
#    each corner and its prediction, and the angle at its ray.
#
# A model with rays everywhere is easily blamed where the other is silent.
# So both are scored twice: on all corners they have a ray for, and on the
# corners that both have a ray for.

# %% tags=["active-ipynb", "hide-output"]
# show_code(calibrated, fold_part, scores)


# %% tags=["hide-cell"]
@experiment(
    "photograph_study",
    artefact="ext_models",
    shards={"quick": 2, "full": 4},
    per_set=True,
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


def study_of(results):
    """The study in the results that a producer was given."""
    return Study(results["photograph_study"])


# %% tags=["active-ipynb", "remove-input"]
# study = Study(open_results("photograph_study"))

# %% tags=["active-ipynb"]
# value("title", sentences.title(study))

# %% tags=["active-ipynb"]
# value("about", sentences.about(study))

# %% tags=["active-ipynb"]
# value("origin", sentences.origin(study))

# %% tags=["active-ipynb"]
# value("found", sentences.found(study))

# %% tags=["active-ipynb"]
# value("zhang", sentences.zhang(study))

# %% tags=["active-ipynb"]
# value("general", sentences.general(study))

# %% tags=["active-ipynb"]
# value("kept_out", sentences.kept_out(study))

# %% tags=["active-ipynb"]
# value("coverage", sentences.coverage(study))

# %% tags=["active-ipynb"]
# value("comparison", sentences.comparison(study))

# %% tags=["active-ipynb"]
# value("angles", sentences.angles(study))

# %% tags=["active-ipynb"]
# value("straightness", sentences.straightness(study))

# %% tags=["active-ipynb"]
# value("exercise", sentences.exercise(study))

# %% [markdown]
# ## The photographs and their corners
#
# {glue:text}`found`


# %% tags=["hide-cell"]
@figure(
    "ext_corners",
    needs=("photograph_study",),
    evidence="photograph",
    per_set=True,
)
def ext_corners(results):
    """Every photograph with its corners in order."""
    return contact_sheet(study_of(results))


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
# ## Two cameras from the same corners
#
# {glue:text}`zhang`
#
# {glue:text}`general`
#
# ## Residuals of photographs kept out
#
# {glue:text}`kept_out`


# %% tags=["hide-cell"]
@figure(
    "ext_residuals",
    needs=("photograph_study",),
    evidence="photograph",
    per_set=True,
)
def ext_residuals(results):
    """Residual vectors of corners kept out, both models on one scale."""
    return residual_fields(study_of(results))


# %% tags=["active-ipynb"]
# show("ext_residuals")

# %% [markdown]
# Arrows that agree with their neighbours show distortion that the model
# cannot follow. Arrows in all directions show the noise of the corners, and
# for the general camera also the noise of its own rays, which it took from
# a few boards each. {glue:text}`coverage`
#
# ## Error per photograph


# %% tags=["hide-cell"]
@figure(
    "ext_cross_validation",
    needs=("photograph_study",),
    evidence="photograph",
    per_set=True,
)
def ext_cross_validation(results):
    """Error of both models in every photograph kept out."""
    return held_out_errors(study_of(results))


@table(
    "ext_images",
    needs=("photograph_study",),
    evidence="photograph",
    per_set=True,
)
def ext_images(results):
    """Every photograph: corners found, errors, remarks."""
    return images_table(study_of(results))


# %% tags=["active-ipynb"]
# show("ext_cross_validation")

# %% tags=["active-ipynb"]
# show_table("ext_images", digits=3)

# %% [markdown]
# ## The photograph without distortion


# %% tags=["hide-cell"]
@figure(
    "ext_undistorted",
    needs=("photograph_study",),
    evidence="photograph",
    per_set=True,
)
def ext_undistorted(results):
    """One photograph as taken, and undistorted through both models."""
    return undistorted_views(study_of(results))


# %% tags=["active-ipynb"]
# show("ext_undistorted")

# %% [markdown]
# {glue:text}`straightness`
#
# These px are of the undistorted view, which stretches what is far from its
# middle. The homography hides an error of the pose or of the centre. The
# angles of the cross-validation do not.
#
# ## Compared models


# %% tags=["hide-cell"]
@table(
    "ext_models",
    needs=("photograph_study",),
    evidence="photograph",
    per_set=True,
)
def ext_models(results):
    """Both models: parameters, fit, prediction, coverage."""
    return models_table(study_of(results))


# %% tags=["active-ipynb"]
# show_table("ext_models", digits=3)

# %% [markdown]
# {glue:text}`comparison` {glue:text}`angles` Other lenses stand beside this
# one on [a page of their own](by_distortion.ipynb).
#
# A model counts as better when a one-sided Wilcoxon signed-rank test over
# the photographs gives p < 0.01 and its median error is smaller by a factor
# of at least 1.05 with the whole 95 % interval. With six photographs or
# fewer, no test of this kind can decide.
#
# ## Detectors side by side
#
# The question of 3.3.2, asked of these photographs: which detector returns
# the board, with every corner in its place? A corner that is more than 8 px
# off, or nearer to another's place, makes a board wrong. Both detectors of
# today's OpenCV and the one [without
# clicks](../ch03_planar_grids/ext_without_clicks.ipynb) know the size of the
# board; [CELECT](../ch03_planar_grids/s1_2_celect.ipynb) has four clicks as
# well. Reference corners are what several detectors agree on, so a detector
# that went into them is judged mildly.

# %% tags=["active-ipynb", "hide-output"]
# show_code(detector_trial, score)


# %% tags=["hide-cell"]
@experiment(
    "photograph_detectors",
    artefact="ext_detectors",
    shards={"quick": 1, "full": 4},
    per_set=True,
)
def photograph_detectors(effort, folder):
    """Every detector on every image of the set."""
    image_set = load_set(folder)
    return Plan(
        partial(detector_trial, folder),
        detector_conditions(image_set, effort),
        1,
        settings_of(image_set),
    )


@table(
    "ext_detectors",
    needs=("photograph_detectors",),
    evidence="photograph",
    per_set=True,
)
def ext_detectors(results):
    """Detectors side by side: boards returned and right, errors."""
    return detectors_table(results["photograph_detectors"])


# %% tags=["active-ipynb"]
# show_table("ext_detectors")

# %% [markdown]
# ## Reading and limits
#
# - The fitted errors flatter the general camera: it has a parameter for
#   nearly everything that it was fitted to. Only photographs kept out
#   compare the models.
# - The general camera knows the pixels that boards covered, and is as good
#   as the homography inside a cell. Large cells near the edge of a strongly
#   distorted image bend more than a homography can.
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
