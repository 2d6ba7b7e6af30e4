# %% [markdown]
# # Which method for my camera?
#
# **Question.** Four ways of calibration: what does each one need, and what
# does it leave as error in this repository's own experiments? Two things
# decide most of it: whether all rays meet in one point, and how far the
# lens is from a pinhole.

# %%
from chapters.guides.choose_a_method.results.prose import motion_facts, named
from chapters.guides.choose_a_method.trials import (
    DETECTOR_RECORD,
    SCORED,
    STATED,
    STATED_RECORD,
    VIEWS,
    recorded_scores,
    score_rig,
    stated_errors,
)
from chapters.shared.records import record
from chapters.shared.zoom_rigs import ZOOM_RIGS
from repro.page.reader import results_behind, show_table, value
from repro.run.experiment import experiment
from repro.run.outcomes import Plan


# %%
@experiment(
    "ext_benchmark_scores", artefact="ext_methods", shards={"full": 3}, inputs=ZOOM_RIGS
)
def ext_benchmark_scores(effort):
    """Small rendered sets, scored as raxel score does."""
    conditions = [{"rig": name} for name in SCORED[effort]]

    def trial(condition, rng):
        return score_rig(condition["rig"], VIEWS[effort], rng)

    return Plan(trial, conditions, 1, {"views": VIEWS[effort]})


@experiment(
    "ext_detector_record",
    artefact="ext_detectors_in_short",
    inputs=("data/records/detectors.json",),
)
def ext_detector_record(effort):
    """What the record of detectors holds; nothing is measured again."""
    return Plan(
        lambda condition, rng: recorded_scores(condition),
        [{"set": one["name"]} for one in record(DETECTOR_RECORD)["sets"]],
        1,
    )


@experiment(
    "ext_stated_record",
    artefact="ext_stated_errors",
    inputs=("data/records/stated.json",),
)
def ext_stated_record(effort):
    """What the record of stated errors holds; nothing is measured again."""
    return Plan(
        lambda condition, rng: stated_errors(condition),
        [{"quantity": name} for name in STATED],
        1,
        {"command": record(STATED_RECORD)["command"]},
    )


# %% tags=["active-ipynb", "remove-input"]
# found = named(results_behind("ext_methods"))

# %% tags=["active-ipynb", "remove-input"]
# found |= motion_facts(results_behind("ext_known_motion")["fig_2_2_error"])

# %% tags=["active-ipynb"]
# for name, text in found.items(): value(name, text)

# %% tags=["active-ipynb"]
# show_table("ext_methods", digits=3)

# %% [markdown]
# *Residual, clean*: mean distance to points without noise, in px of the
# source image. *Ray error*: angle to the true rays after the best rotation;
# for the sets of the converter where the generic camera has rays. *Kept
# out*: RMS in pictures that the calibration did not see, at the board's best
# pose. *Corrected view*: what is left of distortion in the corrected view of
# such pictures, as in Table 2.2; there a corner without a ray counts for the
# other methods alone. *Scatter of steps*: of equal steps of a stage.
# *Generic*, where simulated and on the sets of the converter: its linear stage
# is the well conditioned one; the findings of 2.5.1 and 2.5.2 quote the one as
# printed.
#
# ## Findings
#
# - **At 60°**, simulated, Zhang's formula leaves smaller ray errors than the
#   generic camera ({glue:text}`zhang.ray_deg.60`° against
#   {glue:text}`general.ray_deg.60`°): its few numbers average the noise over
#   all corners. OpenCV's fisheye model is as good
#   ({glue:text}`peer.ray_deg.60`°, with an interval that overlaps Zhang's).
# - **At 120°**, simulated, Zhang's formula cannot follow a fisheye
#   ({glue:text}`zhang.ray_deg.120`° against
#   {glue:text}`general.ray_deg.120`° of the generic camera and
#   {glue:text}`peer.ray_deg.120`° of OpenCV's fisheye model).
# - **OpenCV's fisheye model** comes near a ray for every pixel on a rendered
#   lens of 183° that follows its formula: from boards that stay away from
#   the rim it leaves {glue:text}`fisheye.opencv_fisheye.inner` in pictures
#   kept out, the generic camera {glue:text}`fisheye.generic.inner`. And it
#   sees farther than the boards. Its fit does not always converge: with
#   boards to the rim it leaves {glue:text}`fisheye.opencv_fisheye.all`. Look
#   at its residual.
# - **On real cameras** it may fail where the generic camera does not: on
#   {glue:text}`record.name`, {glue:text}`record.widest`° from the axis, it
#   leaves {glue:text}`record.opencv_fisheye`, the generic camera
#   {glue:text}`record.generic`.
# - **A lens formula or smooth rays**, the last two of the methods below, are
#   not in this table. They are compared on cameras with a known truth in [A
#   lens formula where one
#   fits](../ch04_central_generic/ext_lens_formula.ipynb) and [Smooth
#   rays](../ch04_central_generic/ext_smooth_rays.ipynb).
# - **The generic camera** needs no formula and answers only where boards
#   were: {glue:text}`fisheye.boards.all` placed pictures give rays to
#   {glue:text}`fisheye.share.all` of the image circle,
#   {glue:text}`fisheye.boards.inner` to {glue:text}`fisheye.share.inner`.
#
# How the number of pictures and their places decide that is on the page [A
# fisheye in ten minutes](fisheye_in_ten_minutes.ipynb).

# %% [markdown]
# ## The methods
#
# - **Zhang** {cite}`zhang2000`: a pinhole with two radial terms. A handful
#   of parameters from a board held at several tilts.
#   `raxel calibrate SET --model zhang`
# - **Lens formulas** ([A lens formula where one
#   fits](../ch04_central_generic/ext_lens_formula.ipynb)): Kannala-Brandt
#   {cite}`kannala2006` for fisheyes, the unified sphere for mirrors, both
#   decentred. They find their own start, and whether the entrance pupil
#   moves. `raxel calibrate SET --model kannala-brandt`, or `unified`
# - **OpenCV fisheye** {cite}`kannala2006`: the angle from the axis is a
#   polynomial of the radius; eight parameters. It is here as a peer:
#   `raxel.calibration.parametric.opencv_fisheye`, in Python only.
# - **Generic, unknown poses** ({cite}`sturm2004`;
#   [section 2.4](../ch02_general_camera_model/s4_generic_calibration.ipynb)):
#   every pixel gets a ray of its own. All rays meet in one point. The poses
#   of the boards are found on the way.
#   `raxel calibrate SET --model generic`
# - **CGSP and smooth rays**: the generic camera by the method of [chapter
#   4](../ch04_central_generic/s1_2_linear_stage.ipynb), and a lens formula
#   with a [smooth field of
#   rays](../ch04_central_generic/ext_smooth_rays.ipynb) on it.
#   `raxel calibrate SET --model cgsp`, or `spline`
# - **General, known motion** ([section
#   2.3.3](../ch02_general_camera_model/s3_general_camera.ipynb)): every
#   pixel gets a ray of its own, and the rays need not meet. The motion of
#   the target between its poses is *given*. This is
#   `raxel.calibration.rays_from_known_motion`, in Python only.
#
# `raxel calibrate SET --model auto` makes all of them but OpenCV's and known
# motion predict photographs that they have not seen, and keeps the best one.
# A corner that a model has no ray for counts as 5 px.

# %% [markdown]
# ## Decide
#
# **1. Do all rays meet in one point?** They nearly do in a lens on its own,
# and in a mirror of the right shape in the right place. They do not in a
# mirror that is not, in several plane mirrors, in a reflecting ball, or
# behind water. [The camera
# zoo](../ch02_general_camera_model/s2_camera_models.ipynb) shows which is
# which.
#
# - *No*: known motion, question 4. Zhang's and the generic method would
#   give you a camera, but a wrong one. A fisheye whose entrance pupil moves
#   along its axis is the exception: a lens formula can hold that.
# - *Yes, or I do not know*: question 2. Three active grids or more can tell
#   ([Central or not](../ch04_central_generic/ext_central_or_not.ipynb)).
#
# **2. How wide is the view?** The noise of the simulated pixels is
# {glue:text}`noise` px, and the angle is on the image diagonal of an ideal
# fisheye.
#
# - *About 60°*: Zhang leaves a ray error of
#   {glue:text}`zhang.ray_deg.60`°, OpenCV fisheye
#   {glue:text}`peer.ray_deg.60`°, the generic method
#   {glue:text}`general.ray_deg.60`°. Begin with Zhang.
# - *About 120°*: Zhang {glue:text}`zhang.ray_deg.120`°, OpenCV fisheye
#   {glue:text}`peer.ray_deg.120`°, generic
#   {glue:text}`general.ray_deg.120`°. Try `--model auto`, and OpenCV's
#   model in Python. The simulated lens follows a formula that this model
#   holds; your lens may not.
# - *About 150°*: Zhang {glue:text}`zhang.ray_deg.150`°, OpenCV fisheye
#   {glue:text}`peer.ray_deg.150`°, generic
#   {glue:text}`general.ray_deg.150`°. Near the edge, boards must be taken
#   close and tilted; a board seen at a grazing angle says little.
# - *180° or more*: no pinhole has such rays at all. A lens formula, which
#   needs no guess; generic; or OpenCV's fisheye model, from boards that stay
#   away from 90°: it left {glue:text}`fisheye.opencv_fisheye.inner` in
#   pictures kept out, the generic camera
#   {glue:text}`fisheye.generic.inner`.
#
# The distance from the pinhole counts, not the angle alone: a wide lens that
# keeps lines straight is a case for Zhang.
#
# **3. What will the camera be used for?** A small residual is not yet a
# good ray ([section
# 2.5.1](../ch02_general_camera_model/s5_1_synthetic_data.ipynb)), so look
# at the quantity that your work uses.
#
# - *Straight lines in pictures*. A rendered fisheye converter at three zoom
#   settings, {glue:text}`pictures` pictures each; errors of the corrected
#   view, in pictures kept out:
#
#   - Set 1, least distorted: Zhang {glue:text}`zhang.zoom.1` px, OpenCV fisheye
#     {glue:text}`peer.zoom.1` px, generic {glue:text}`general.zoom.1` px.
#   - Set 2, between: Zhang {glue:text}`zhang.zoom.2` px, OpenCV fisheye
#     {glue:text}`peer.zoom.2` px, generic {glue:text}`general.zoom.2` px.
#   - Set 3, most distorted: Zhang {glue:text}`zhang.zoom.3` px, OpenCV fisheye
#     {glue:text}`peer.zoom.3` px, generic {glue:text}`general.zoom.3` px.
#
# - *Poses and motion*. Equal steps of a stage, recovered by the third
#   camera, scatter by {glue:text}`zhang.stage` mm with Zhang, by
#   {glue:text}`peer.stage` mm with OpenCV's fisheye model, and by
#   {glue:text}`general.stage` mm with the generic method.
# - *Every pixel must have a ray*. Zhang gives one to every pixel where its
#   formula can be inverted, seen by a board or not, right or not. The
#   generic method answers only where boards were.
#
# **4. Is there a stage?** For known motion, what you know of the motion is
# what you get. Compare the table with what your stage, rail or robot arm is
# good for. A ruler and a steady hand are good for about a millimetre, which
# costs {glue:text}`motion.translation`° here.

# %% tags=["active-ipynb"]
# show_table("ext_known_motion")

# %% [markdown]
# ## Will the board be found?
#
# A calibration is as good as its corners. Three detectors that need no
# clicks, on pictures in mirrors, fisheyes and bad light, and on photographs:

# %% tags=["active-ipynb"]
# show_table("ext_detectors_in_short")

# %% [markdown]
# The record of the photographs is `data/records/detectors.json`. It names each
# set, its origin and its licence.
#
# **Where no board is found**, or the camera shows it in pieces, a monitor
# can be the target. It shows coded patterns, and every pixel reads its own
# place on it ([active
# grids](../ch03_planar_grids/s2_2_active_grids.ipynb)): no corners, but
# twenty pictures or more for each pose, while nothing moves. Zhang's method
# takes a spread of its pixels, the generic method all. [Against
# chessboards](../ch03_planar_grids/s3_3_active_grid_robustness.ipynb) it is
# weak where there is much noise. [Your own
# photographs](../your_photographs.md) says how to show it. No table of this
# page was made with one.
#
# ## Stated errors
#
# Corners, places of an active grid and calibrated parameters come with standard
# deviations. The table compares them with the errors that occurred.

# %% tags=["active-ipynb"]
# show_table("ext_stated_errors", digits=3)

# %% [markdown]
# All cases are in the record `data/records/stated.json`, with what the library
# reports where an assumption fails: two cameras, a bent board, a rolling shutter.
#
# ## Cost
#
# | Method | Images, at least | Capture |
# |---|---:|---|
# | Zhang | 2 | board in the hand, tilted; any part of the image |
# | OpenCV fisheye | 2 | as Zhang; no board near 90° from the axis |
# | Generic, unknown poses | 3 | as Zhang; boards overlap and together cover the image |
# | General, known motion | 2 | measured stage; every pixel sees the target each time |
#
# The rendered sets above have {glue:text}`pictures` images each, and should be
# the model: the least number determines the camera badly. [Your own
# photographs](../your_photographs.md) says how to take them. A formula is fitted in
# seconds; a table of rays takes longer, with the image's size and the number of
# boards.
#
# ## What is not known
#
# - **Cameras whose rays do not meet**, without a known motion: a pupil that
#   moves along the axis is fitted to boards, and the lines of single pixels
#   can be freed from their centre when active grids were shown. For crossed
#   slits, several mirrors or a reflecting ball the library has models to
#   render with, and nothing that calibrates them from unknown poses.
# - **Parametric models other than these.** The zoo has more fisheye and
#   mirror models. They are rendered, and not fitted to photographs.
# - **Boards or a monitor**: no camera of this page was calibrated from both,
#   so which gives better rays is not said here.
# - **Wrong boards.** No experiment uses a bent board or one of the wrong
#   size. The equations say that a pitch wrong by a common factor scales all
#   lengths and leaves the rays of a central camera alone. They promise
#   nothing for a bent board, or for a pitch that differs between columns
#   and rows.
# - **Nearly central cameras.** What it costs a centre and the corrected
#   pictures when rays miss each other was measured for two rigs
#   ([4.3.2](../ch04_central_generic/s3_2_results.ipynb)); a rule for other
#   cameras is not known.
