# %% [markdown]
# # Six lessons on camera calibration, for teachers
#
# Each lesson takes 50 minutes and is independent. Lessons 1 to 3 introduce cameras
# and their calibration, and lessons 4 to 6 add patterns, single-viewpoint methods and
# a flexible mirror. Every exercise checks its own answer. Every lesson has a figure
# with a slider (mouse or arrow keys).

# %%
from chapters.guides.for_teachers.exercises import exercise_list, pages_with_exercises
from chapters.guides.for_teachers.report import stated_times
from repro.page import show, show_table, value

# Exercises are counted in the pages of the chapters; times are those of the README.
READS_PAGES = True

# %% tags=["active-ipynb", "remove-input"]
# pages = pages_with_exercises()

# %% tags=["active-ipynb"]
# value("pages", len(pages))

# %% tags=["active-ipynb"]
# value("exercises", sum(len(page.exercises) for page in pages))

# %% tags=["active-ipynb"]
# value("quick_time", stated_times()["quick"])

# %% tags=["active-ipynb"]
# value("report_time", stated_times()["report"])

# %% [markdown]
# ## Preparation
#
# ```console
# $ make quick                     # report/site-quick/index.html
# $ make lab                       # its notebooks in JupyterLab
# $ make answers EFFORT=quick      # report/answers, for the teacher
# $ make archive EFFORT=quick      # report/raxel-report-quick.zip
# ```
#
# `make quick` takes {glue:text}`quick_time` on two cores, the other commands seconds.
# The first run also installs everything and needs a network. The quick report has all
# pages but no verdicts, and lesson 6 uses one: `make report`
# ({glue:text}`report_time`) adds them.
#
# Readers need a browser and the archive, exercises the checkout and `make lab`. An
# exercise is a cell that begins with `check(None`. Run all cells, replace `None` by the
# answer, and run the cell again. A wrong answer gives a hint.
#
# `make answers` writes one sheet per lesson, with reasons and common mistakes.
#
# ## Lesson 1: rays instead of formulas
#
# **Goal.** Students describe a camera as a set of pixels with rays, and distinguish
# central from non-central cameras.
#
# **Page.** [2.3](../ch02_general_camera_model/s3_general_camera.ipynb). Students need
# vectors and projection.
#
# - **10 min.** A whole room in one image: find the viewing direction of single pixels
#   in [1.1.2](../ch01_introduction/s1_1_panorama.ipynb).
# - **15 min.** The zoo of [2.2](../ch02_general_camera_model/s2_camera_models.ipynb):
#   each group matches one camera to its image of the room.
# - **15 min.** Rotate the 3-D scenes of Figs. 2.1 and 2.2, then move the plane with
#   the slider: do the rays meet in one point?
# - **10 min.** Exercises.
#
# **Exercises.** [2.3](../ch02_general_camera_model/s3_general_camera.ipynb),
# exercises 1 and 2; [1.1.2](../ch01_introduction/s1_1_panorama.ipynb), exercise 1.
#
# **Misunderstanding.** "A fisheye is not central, because it bends lines." Curved
# lines do not show whether the rays meet in one point.

# %% tags=["active-ipynb"]
# show("ext_lesson_rays")

# %% [markdown]
# ## Lesson 2: calibration from three grids
#
# **Goal.** Students explain why three images of a flat grid in unknown poses
# determine the ray of every pixel.
#
# **Page.** [2.4](../ch02_general_camera_model/s4_generic_calibration.ipynb). Students
# need linear equations and rank.
#
# - **5 min.** Two grids in known poses: two points determine a ray. The slider shows
#   the effect of a wrong pose.
# - **15 min.** Three grids in unknown poses: derive one cell of Table 2.1 from three
#   collinear points.
# - **15 min.** The linear stage and its rank, then the pose from three points, in
#   [2.4.1](../ch02_general_camera_model/s4_1_linear_and_pose.ipynb).
# - **15 min.** Exercises in pairs.
#
# **Exercises.** [2.4](../ch02_general_camera_model/s4_generic_calibration.ipynb),
# exercises 1 and 2; [2.4.1](../ch02_general_camera_model/s4_1_linear_and_pose.ipynb),
# exercise 2.
#
# **Misunderstanding.** "Each grid gives two equations per pixel, and a ray has four
# unknowns, so two grids are enough." The poses are unknown, too.

# %% tags=["active-ipynb"]
# show("ext_lesson_grids")

# %% [markdown]
# ## Lesson 3: error and residual
#
# **Goal.** Students judge a method by an experiment and see that a small residual
# does not prove a small error.
#
# **Page.** [2.5.1](../ch02_general_camera_model/s5_1_synthetic_data.ipynb). Students
# need mean, standard deviation and median.
#
# - **5 min.** Predict on paper: ray error against field of view, for two methods.
# - **15 min.** Compare with the figure with OpenCV's fisheye model. Slider: up to
#   which field of view has the method with the smaller residual the larger ray error?
# - **15 min.** Exercises.
# - **15 min.** Groups repeat the figure with other numbers of trials and compare the
#   intervals: `make fig_2_3 TRIALS=20`.
#
# **Exercises.** [2.5.1](../ch02_general_camera_model/s5_1_synthetic_data.ipynb),
# exercises 1, 2 and 3.
#
# **Misunderstanding.** "The camera with the smaller residual is the better one."
# Flexible models follow the noise. More trials narrow the interval but do not reduce
# the error.

# %% tags=["active-ipynb"]
# show("ext_lesson_residual")

# %% [markdown]
# ## Lesson 4: decoded screen positions
#
# **Goal.** Students decode the screen position of a pixel by hand and predict the
# effect of monitor gamma.
#
# **Page.** [3.2.2](../ch03_planar_grids/s2_2_active_grids.ipynb). Students need sine
# and Fourier series.
#
# - **5 min.** On paper: how can a pixel find its screen position from twenty images
#   of a monitor?
# - **15 min.** Decode one pixel in pairs with Fig. 3.8: bits, cell, phase, position.
# - **15 min.** Exercises.
# - **15 min.** The ripple of gamma in [Appendix
#   A](../appendix_a/phase_and_harmonics.ipynb): which orders disturb with three, four
#   and six steps? Predict, then move the slider.
#
# **Exercises.** [3.2.2](../ch03_planar_grids/s2_2_active_grids.ipynb), exercises 1
# and 2; [Appendix A](../appendix_a/phase_and_harmonics.ipynb), exercise 2.
#
# **Misunderstanding.** "Six steps are better because they average more." The number
# of steps decides which orders cancel, and averaging does not remove the ripple.

# %% tags=["active-ipynb"]
# show("ext_lesson_steps")

# %% [markdown]
# ## Lesson 5: one centre
#
# **Goal.** Students treat a central fisheye as a pinhole camera and find which part
# of a method makes it accurate.
#
# **Page.** [4.1.1](../ch04_central_generic/s1_1_synthetic_pinhole.ipynb). Students
# need homographies and least squares.
#
# - **5 min.** On paper: a glass plane in front of a fisheye. Which image do its rays
#   draw on the plane?
# - **15 min.** The base grid as an image plane, with its exercises.
# - **15 min.** Four numbers from homographies in
#   [4.1.2](../ch04_central_generic/s1_2_linear_stage.ipynb): exercise 1 by hand.
# - **15 min.** Slider, then Fig. 4.2 in
#   [4.1.5](../ch04_central_generic/s1_5_simulated.ipynb): groups explain which method
#   is most accurate, before they read why.
#
# **Exercises.** [4.1.1](../ch04_central_generic/s1_1_synthetic_pinhole.ipynb),
# exercises 1 and 2; [4.1.2](../ch04_central_generic/s1_2_linear_stage.ipynb),
# exercise 1.
#
# **Misunderstanding.** "The more accurate method has better equations." Two methods
# can solve the same equations and differ tenfold by conditioning.

# %% tags=["active-ipynb"]
# show("ext_lesson_centre")

# %% [markdown]
# ## Lesson 6: a flexible mirror
#
# **Goal.** Students predict from the slope of a mirror how far its field of view
# widens.
#
# **Page.** [5.3.3a](../ch05_flexible_mirror/s3_3_calibration.ipynb). Students need
# derivatives and the law of reflection. Bring a plastic mirror, a ruler and a phone.
#
# - **5 min.** Clamp one edge of the mirror and push the other. Where does the view of
#   the phone widen?
# - **10 min.** Draw the slope from the clamp to the load and beyond, with
#   [5.1](../ch05_flexible_mirror/s1_model.ipynb).
# - **25 min.** Exercises in pairs: predict the fan of rays, then compare with the
#   slider and Fig. 5.10.
# - **10 min.** The scoreboard, "FOV at stage 3 is about twice that at stage 0" for
#   two rigs: why does the verdict depend on the rig?
#
# **Exercises.** [5.3.3a](../ch05_flexible_mirror/s3_3_calibration.ipynb), exercises 1
# and 2; [5.1](../ch05_flexible_mirror/s1_model.ipynb), exercise 2.
#
# **Misunderstanding.** "The ray turns by the angle of the mirror." It turns by twice
# that angle.

# %% tags=["active-ipynb"]
# show("ext_lesson_mirror")

# %% [markdown]
# ## All exercises
#
# The chapters have {glue:text}`exercises` exercises on {glue:text}`pages` pages.
# *Longest check* is the time to compute the expected answer.

# %% tags=["active-ipynb"]
# exercise_list(pages)

# %% [markdown]
# ## Experiments that a class can repeat
#
# `make fig_3_11 TRIALS=5` draws a figure with another number of trials. Its time is
# proportional to them.

# %% tags=["active-ipynb"]
# show_table("ext_class_runs")

# %% [markdown]
# ## Limits
#
# No class has tested the timetables. The misunderstandings do not come from
# classrooms.
