# %% [markdown]
# # Choice of a calibration method
#
# **Question.** A lens can be calibrated with a parametric model or with a ray for
# every pixel, and each choice has its own failures. Given the camera and its use,
# which method is accurate, what does it need, and where does it give no answer?

# %%
from chapters.guides.choose_a_method.experiment import (
    DETECTOR_RECORD,
    SCORED,
    STATED,
    STATED_RECORD,
    VIEWS,
    recorded_scores,
    score_rig,
    stated_errors,
)
from chapters.guides.choose_a_method.report import named
from chapters.shared.general import ZOOM_RIGS
from chapters.shared.records import record
from repro.page import results_behind, show_table, value
from repro.run import Plan, experiment


# %%
@experiment("ext_benchmark_scores", artefact="ext_methods", inputs=ZOOM_RIGS)
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

# %% tags=["active-ipynb"]
# for name, text in found.items(): value(name, text)

# %% tags=["active-ipynb"]
# show_table("ext_methods", digits=3)

# %% [markdown]
# *Residual, clean*: mean distance to noise-free points, in px of the source image.
# *Ray error*: angle to the true rays after the best rotation, for the sets of the
# converter at pixels where the generic camera has rays. *Held-out*: RMS error in
# images that the calibration did not use, at the best board pose. *Corrected view*:
# remaining distortion in the corrected view of such images, as in Table 2.2. *Scatter
# of steps*: standard deviation of equal steps of a stage. *Generic*: for simulated
# cameras and the converter, its well-conditioned linear stage.
#
# ## Findings
#
# 1. **Narrow lens (60°).** Zhang's model leaves a ray error of
#    {glue:text}`zhang.ray_deg.60`°, the generic camera
#    {glue:text}`general.ray_deg.60`°. A few parameters average the noise of all
#    corners.
# 2. **Wide lens (120° and more).** Zhang's model cannot follow a fisheye: its ray
#    error exceeds that of the generic camera. OpenCV's fisheye model is the most
#    accurate in simulation, where the lens follows its formula exactly.
# 3. **Real lenses.** OpenCV's fisheye model can fail where the generic camera works.
#    On the widest recorded lens it leaves {glue:text}`record.opencv_fisheye`, the
#    generic camera {glue:text}`record.generic`.
# 4. **Coverage.** The generic camera has rays only where boards were:
#    {glue:text}`fisheye.share.all` of the image circle with boards up to the edge,
#    {glue:text}`fisheye.share.inner` without.
#
# [Calibration of a fisheye in ten minutes](fisheye_in_ten_minutes.ipynb) gives a plan
# for the positions of the boards.

# %% [markdown]
# ## Methods
#
# - **Zhang** {cite}`zhang2000`: pinhole with two radial terms, from a board at
#   several tilts. `raxel calibrate SET --model zhang`
# - **Parametric models**
#   ([comparison](../ch04_central_generic/ext_lens_formula.ipynb)): Kannala-Brandt
#   {cite}`kannala2006` for fisheyes, the unified sphere for mirrors, both decentred.
#   They need no initial values and estimate an entrance-pupil shift.
#   `raxel calibrate SET --model kannala-brandt`, or `unified`
# - **OpenCV fisheye** {cite}`kannala2006`: the radius is a polynomial of the angle
#   from the axis. Its fit does not always converge. It is included for comparison:
#   `raxel.calibration.parametric.opencv_fits`, in Python only.
# - **Generic, unknown poses** ({cite}`sturm2004`; [section
#   2.4](../ch02_general_camera_model/s4_generic_calibration.ipynb)): a per-pixel ray
#   model with a single viewpoint. The board poses are estimated.
#   `raxel calibrate SET --model generic`
# - **CGSP and smooth rays**: the generic camera by the method of [chapter
#   4](../ch04_central_generic/s1_2_linear_stage.ipynb), and a parametric model with a
#   [B-spline ray field](../ch04_central_generic/ext_smooth_rays.ipynb).
#   `raxel calibrate SET --model cgsp`, or `spline`
# - **General, known motion** ([section
#   2.3.3](../ch02_general_camera_model/s3_general_camera.ipynb)): a per-pixel ray
#   model without a single viewpoint. The motion of the target is *given*.
#   `raxel.calibration.rays_from_known_motion`, in Python only.
#
# `raxel calibrate SET --model auto` fits all of them except OpenCV's and known
# motion. It keeps the model with the smallest error on held-out images, where a corner
# without a ray counts as 5 px.

# %% [markdown]
# ## Decision
#
# **1. Is the camera central?** A single lens is nearly central, and so is a mirror of
# the right shape in the right position. Other mirrors and a camera behind water are
# not. [The camera zoo](../ch02_general_camera_model/s2_camera_models.ipynb) shows
# examples.
#
# - *No*: known motion, question 4. Zhang's and the generic method give a wrong camera.
#   A parametric model includes the entrance-pupil shift of a fisheye.
# - *Yes or unknown*: question 2. Three or more active grids allow a
#   [test](../ch04_central_generic/ext_central_or_not.ipynb).
#
# **2. How wide is the field of view?** Angles are measured along the image diagonal.
#
# - *About 60°, or a wide lens that keeps lines straight*: begin with Zhang.
# - *About 120°*: `--model auto`.
# - *About 150°*: as 120°. Near the edge, take boards close and tilted: a board at a
#   grazing angle constrains little.
# - *180° or more*: as 150°. No pinhole model has such rays, and OpenCV's fisheye model
#   needs boards away from 90°.
#
# **3. What is the camera used for?** A small residual does not prove accurate rays
# ([section 2.5.1](../ch02_general_camera_model/s5_1_synthetic_data.ipynb)), so
# compare the quantity that matters.
#
# - *Straight lines in images*: rows "corrected view". Zhang's error grows with the
#   distortion.
# - *Poses and motion*: row "scatter of steps".
# - *A ray for every pixel*: a formula has one wherever it is invertible, correct or
#   not. The generic method has one only where boards were.
#
# **4. Is the motion known?** The accuracy of the motion limits the result. The table
# gives the ray error for a wrong motion. A ruler achieves about 1 mm.

# %% tags=["active-ipynb"]
# show_table("ext_known_motion")

# %% [markdown]
# ## Detection of the board
#
# The table compares three automatic detectors on images with mirrors, fisheyes and
# poor light, rendered and real.

# %% tags=["active-ipynb"]
# show_table("ext_detectors_in_short")

# %% [markdown]
# The record `data/records/detectors.json` names each set of real images, its origin
# and its licence.
#
# **If no board is detected**, a monitor can be the target. It displays phase-shift
# structured light, an [active grid](../ch03_planar_grids/s2_2_active_grids.ipynb),
# and every pixel decodes its screen position. Each pose takes 20 images or more.
# Active grids are [weak at high
# noise](../ch03_planar_grids/s3_3_active_grid_robustness.ipynb).
#
# ## Predicted and actual errors
#
# The table compares predicted standard deviations with actual errors.

# %% tags=["active-ipynb"]
# show_table("ext_stated_errors", digits=3)

# %% [markdown]
# The record `data/records/stated.json` contains all cases.
#
# ## Cost
#
# | Method | Images, at least | Capture |
# |---|---:|---|
# | Zhang | 2 | board in the hand, tilted; any part of the image |
# | OpenCV fisheye | 2 | as Zhang; no board near 90° from the axis |
# | Generic, unknown poses | 3 | as Zhang; boards overlap and cover the image |
# | General, known motion | 2 | measured stage; every pixel sees the target each time |
#
# The minimum determines the camera badly, so take more. [Your own
# images](../your_photographs.md) describes the capture. A parametric fit takes
# seconds, a per-pixel ray model longer.
#
# ## Limits
#
# - **Non-central cameras without known motion.** Boards determine an entrance-pupil
#   shift, and active grids determine single rays without a common centre. Crossed
#   slits, several mirrors or a reflecting ball are not calibrated from unknown poses.
# - **Board or monitor.** No camera of this page was calibrated with both.
# - **Wrong boards.** No experiment uses a bent board or one of the wrong size. A wrong
#   pitch scales all lengths and leaves the rays of a central camera unchanged.
# - **Nearly central cameras.** The effect of rays that miss the centre was measured
#   for two rigs ([4.3.2](../ch04_central_generic/s3_2_results.ipynb)).
