# %% [markdown]
# # {glue:text}`title`
#
# **Question.** A camera can be described by a pinhole with two radial terms, or by a
# ray for every pixel. Given images of a chessboard, which description predicts
# held-out images more accurately, and for how much of the image does it have rays?
#
# {glue:text}`about`

# %%
from functools import partial

from chapters.photographs.set.exercises import (
    exercise_camera,
    exercise_corner,
    field_of_view_task,
    residual_task,
)
from chapters.photographs.set.experiment import (
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
from chapters.photographs.set.report import (
    about,
    comparison,
    coverage,
    exercise,
    found,
    general,
    held_out,
    peer,
    zhang,
)
from chapters.shared.images.notes import origin, title
from chapters.shared.images.reading import BOARDS, Study
from raxel.sets import load_set
from repro.page import check, open_results, show, show_code, show_table, value
from repro.run import Plan, experiment


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
    """Every image, the calibration from all, and every held-out part."""
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
# value("about", about(study))

# %% tags=["active-ipynb"]
# value("origin", origin(study))

# %% tags=["active-ipynb"]
# value("found", found(study))

# %% tags=["active-ipynb"]
# value("zhang", zhang(study))

# %% tags=["active-ipynb"]
# value("general", general(study))

# %% tags=["active-ipynb"]
# value("peer", peer(study))

# %% tags=["active-ipynb"]
# value("held_out", held_out(study))

# %% tags=["active-ipynb"]
# value("coverage", coverage(study))

# %% tags=["active-ipynb"]
# value("comparison", comparison(study))

# %% tags=["active-ipynb"]
# value("exercise", exercise(study))

# %% tags=["active-ipynb"]
# show("ext_cross_validation")

# %% [markdown]
# ## Findings
#
# 1. {glue:text}`found`
# 2. {glue:text}`comparison`
# 3. {glue:text}`peer`
# 4. {glue:text}`coverage`

# %% [markdown]
# ## Method
#
# 1. **Corners.** One detector finds the board's corners with subpixel accuracy. All
#    models use the same corners.
# 2. **Zhang's method** {cite}`zhang2000`, through OpenCV: focal lengths, principal
#    point, two radial terms, and one pose per image. Six parameters describe the
#    camera.
# 3. **The general camera**, by the standard generic method of section 2.4
#    {cite}`sturm2004`: a per-pixel ray model. Between corners, a homography per cell
#    gives the board point of each pixel. If cells bend by more than the uncertainty
#    of their corners, a smooth surface through all corners replaces it. Three
#    overlapping boards give the centre. Bundle adjustment and further boards refine
#    it. A pixel that no board covers has no ray.
# 4. **OpenCV's fisheye model** {cite}`kannala2006`, by `cv2.fisheye.calibrate`: eight
#    parameters. It is scored like the others but does not enter the decision.
# 5. **Cross-validation.** A model is judged on held-out images, with only the pose of
#    the board fitted. The errors are the distance in px between corner and
#    prediction, and the angle at the ray. Each is taken at the pose that minimises
#    it.
#
# A model with rays everywhere is also scored where the other has none. So there are
# two scores: on all corners with a ray of the model, and on *shared corners*, where
# Zhang and the general camera both have a ray.

# %% tags=["active-ipynb"]
# show_code(calibrated, fold_part, scores)

# %% [markdown]
# ## Images and corners

# %% tags=["active-ipynb"]
# show("ext_corners")

# %% [markdown]
# The first corner and the direction of the rows follow a rule. The x axis rotates
# clockwise into y in the image, and the first cell is bright where the board allows
# it. On a point-symmetric board the order may rotate by 180° between images. This
# changes only the pose of the board.
#
# {glue:text}`origin`
#
# ## Cameras from the same corners
#
# {glue:text}`zhang`
#
# {glue:text}`general`
#
# ## Residuals of held-out images
#
# {glue:text}`held_out`

# %% tags=["active-ipynb"]
# show("ext_residuals")

# %% [markdown]
# Neighbouring arrows that agree show distortion that the model does not represent.
# Arrows in random directions show the noise of the corners. For the general camera
# they include the noise of its rays, which come from a few boards each.
#
# ## The undistorted image

# %% tags=["active-ipynb"]
# show("ext_undistorted")

# %% [markdown]
# The number above each view is the RMS deviation of the board's corners from a
# perspective image of a flat lattice, after the best homography. It is in px of the
# corrected view, which magnifies the outer parts. The homography hides errors of the
# pose and of the centre. The angles of the cross-validation do not.
#
# ## Compared models

# %% tags=["active-ipynb"]
# show_table("ext_models", digits=3)

# %% [markdown]
# ### All corners
#
# The table above scores shared corners, where the general camera has rays. The next
# table scores each model on all corners.

# %% tags=["active-ipynb"]
# show_table("ext_every_corner", digits=3)

# %% [markdown]
# A model is better if two conditions hold. A one-sided Wilcoxon signed-rank test over
# the images gives p < 0.01. The ratio of the median errors is at least 1.05 over its
# whole 95 % interval. With six images or fewer, no such test can decide.

# %% [markdown]
# ## Limits
#
# - Errors on fitted images favour the general camera, which has many parameters. Only
#   held-out images compare the models.
# - The general camera has rays only at pixels that boards covered. Its accuracy is
#   that of the interpolation inside a cell. Large cells near the edge of a strongly
#   distorted image can bend more than their corners show.
# - The general camera is central. If rays do not meet in one point, as in many
#   mirrors and wide lenses, it distributes that error over its rays.
# - Every error includes the noise of the corners and the bending of the board,
#   equally for all models.
# - Images of one session share the board, the light and the lens temperature.
#   Cross-validation cannot detect common errors.
# - Corners come from one detector. Rejected images are excluded, and these are often
#   the difficult ones. A set with many rejections is judged on its easy part.

# %% [markdown]
# ## Try it yourself
#
# Open this page as a notebook (`make notebooks`), put an answer in place of `None`,
# and run the cell. {glue:text}`exercise`
#
# **1.** A focal length in px must be compared with the image size. How many degrees
# does the camera cover horizontally, from the left edge of the first pixel to the
# right edge of the last? Ignore the radial terms. Pixel centres are at integers.

# %% tags=["active-ipynb"]
# camera = exercise_camera(study)

# %% tags=["active-ipynb"]
# camera

# %% tags=["active-ipynb"]
# check(None, **field_of_view_task(camera))

# %% [markdown]
# **2.** Given are a corner of the board, its position on the board, the pose of the
# board (board to camera coordinates), and the detected pixel (`found`). Compute the
# residual, detected minus predicted, as $(\Delta u, \Delta v)$ in px. Use numpy alone:
# pose, equations 2.2 and 2.4, calibration matrix.

# %% tags=["active-ipynb"]
# corner = exercise_corner(study)

# %% tags=["active-ipynb"]
# corner

# %% tags=["active-ipynb"]
# check(None, **residual_task(camera, corner))
