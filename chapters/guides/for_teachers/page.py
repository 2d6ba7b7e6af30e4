# %% [markdown]
# # For teachers: chapters 1 to 5 in class
#
# Eleven routes through the first five chapters, with pages, exercises,
# commands, questions to ask and wrong answers to expect. Each route stands
# alone, and takes 50 minutes, I and J 75. A to D make a short course on
# cameras and their calibration, E to H one on finding the corners that a
# calibration needs; I does without corners, J with a single centre, and K
# bends a mirror.

# %%
from chapters.guides.for_teachers.exercises.on_pages import (
    exercise_list,
    pages_with_exercises,
)
from chapters.guides.for_teachers.results import stated_times
from chapters.shared.run_times import rounded_seconds
from repro.page.reader import open_results, seconds, show_table, value

# The exercises are counted in the pages of the chapters; times are the README's.
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

# %% tags=["active-ipynb"]
# value("fov", rounded_seconds(seconds("fig_2_3_fov")))

# %% tags=["active-ipynb"]
# value("noise", rounded_seconds(seconds("fig_2_3_noise")))

# %% tags=["active-ipynb"]
# value("sweep", rounded_seconds(seconds("fig_3_11_noise")))

# %% tags=["active-ipynb"]
# value("trials", open_results("fig_2_3_fov").trials_per_condition)

# %% [markdown]
# ## Before the lesson
#
# ```console
# $ make quick                     # report/site-quick/index.html
# $ make lab                       # the notebooks of it in JupyterLab
# $ make answers EFFORT=quick      # report/answers: for you alone
# $ make archive EFFORT=quick      # report/raxel-report-quick.zip
# ```
#
# `make quick` takes {glue:text}`quick_time` on two cores, the others
# seconds. Do this at least a day before: the first run sets up everything,
# which takes a few minutes more and needs a network, and so does the first
# `make lab`. The quick report has all pages and few trials, so it shows
# values and gives no verdicts. For the verdicts, with which routes C, H, I, J
# and K end, use `make report` ({glue:text}`report_time`,
# `report/site/index.html`), `make notebooks` and `make archive`.
#
# Either report is read from the disk, and the archive is one file of it to
# hand out. Students who only read need a browser. For the exercises they
# need the checkout and `make lab`, because the library computes the right
# answers. An exercise is a cell that begins with `check(None`: run all
# cells once, put the answer in place of `None`, and run that cell again. A
# wrong answer gets a hint; the right one is computed when it is asked for.
# Notebooks that students have worked in are kept when new ones are made.
#
# The sheets of `make answers` have the answers of each route, computed,
# with a sentence on why, and the slips that are recognised. They lie in a
# folder of their own, outside the site, the archive and the notebooks, so
# handing those out gives nothing away.
#
# Students should know vectors and matrices, what a projection is, and a
# little Python. For routes B, C and F: least squares. For route H: what a
# significance test is. For route I: sines, and what a Fourier series is. For
# route J: homographies, and routes B and C. For route K: derivatives, and the
# law of reflection.
#
# ## Route A: rays instead of formulas
#
# *Aim.* Say what a camera is without a lens formula: pixels and their rays.
# Tell a central camera from one that is not.
#
# - **8 min.** A whole room in one picture, unwrapped. Where did each pixel
#   look? [Chapter 1](../ch01_introduction/s1_1_panorama.ipynb)
# - **15 min.** The zoo: in groups, one camera each. Which room picture is
#   whose? [2.2](../ch02_general_camera_model/s2_camera_models.ipynb)
# - **12 min.** Turn the 3-D scenes around. Do the rays meet?
#   [2.3](../ch02_general_camera_model/s3_general_camera.ipynb), Figs 2.1
#   and 2.2
# - **10 min.** Exercises. *2.3*
# - **5 min.** Each group: what can a formula not say about your camera?
#
# *Ask.* How many numbers does a pinhole need, and how many a table of rays?
# Can a picture be made free of distortion if the rays do not meet? Why can
# no plane in front of the camera catch a field of view of 180°?
#
# *Expect.* "A general camera has no model": it has one, with very many
# numbers. "A fisheye is not central, because lines are bent": bent lines
# say nothing about where the rays meet. In the exercise on Plücker
# coordinates: the sign of the moment.
#
# ## Route B: calibrate from three grids
#
# *Aim.* See that three pictures of a flat grid, in poses that nobody
# measured, determine the ray of every pixel; and which equations do it.
#
# - **8 min.** Two grids in known poses: join two points.
#   [2.3](../ch02_general_camera_model/s3_general_camera.ipynb)
# - **12 min.** Three unknown grids: three points on a line. One cell of
#   Table 2.1 by hand. [Table
#   2.1](../ch02_general_camera_model/s4_generic_calibration.ipynb)
# - **12 min.** The linear stage: what the rank says; then pose from three
#   points. [2.4.1](../ch02_general_camera_model/s4_1_linear_and_pose.ipynb)
# - **13 min.** Exercises, in pairs. *Table 2.1 and 2.4.1*
# - **5 min.** The six steps of Algorithm 1, from memory. *2.4.1*
#
# *Ask.* Why are two unknown grids not enough? What goes wrong if two grids
# are parallel? Three points of a triangle: how many places of the camera?
#
# *Expect.* "Each grid gives two equations, so two grids give four
# unknowns": the poses are unknown as well. "Eight solutions, so eight
# places": they come in pairs, one of each pair behind the camera. Counting
# rank by the number of rows.
#
# ## Route C: does it work?
#
# *Aim.* Judge a method by an experiment: a question, a measure, trials, an
# interval. See that a residual is not an error.
#
# - **5 min.** Predict on paper: two curves against the field of view.
# - **12 min.** Fig. 2.3, and what noise does.
#   [2.5.1](../ch02_general_camera_model/s5_1_synthetic_data.ipynb)
# - **10 min.** What if: another number of trials. *command below*
# - **10 min.** Exercises. *2.5.1*
# - **8 min.** Pictures instead of points: Table 2.2.
#   [2.5.2](../ch02_general_camera_model/s5_2_real_data.ipynb)
# - **5 min.** The scoreboard: one claim that holds, one that does not, and
#   why.
#
# ```console
# $ make fig_2_3 TRIALS=20
# ```
#
# draws the figure again with that many trials, beside the record. In the
# build of this page, {glue:text}`trials` trials took
# {glue:text}`fov` for the field of view and {glue:text}`noise` for the
# noise, added up over the jobs; time goes with the number of trials.
# Give groups different numbers and compare their intervals.
#
# *Ask.* Why does the residual grow in proportion to noise? Four times as
# many trials: what becomes of the interval? Two methods leave the same
# residual and have different rays; how? Which choice did the thesis not
# write down, and does it matter?
#
# *Expect.* "More trials make the error smaller": they make the interval
# narrower. "The smaller residual is the better camera": flexible models
# follow the noise. "A quarter of the noise for four grids": it is half.
#
# ## Route D: our own photographs
#
# *Aim.* Calibrate a telephone's camera, and find out how good it is on
# photographs that it has not seen.
#
# - **5 min.** What makes a set good: tilts, corners of the image,
#   sharpness. [Your own photographs](../your_photographs.md)
# - **15 min.** Groups print a chessboard, glue it to a flat thing, take
#   pictures, write `set.yaml`.
# - **5 min.** `raxel check SET`: one line says what is wrong.
# - **10 min.** `raxel calibrate SET --model auto --out camera.npz`.
# - **10 min.** Sets side by side; which model predicts better? Table 2.2 has
#   three lenses. [2.5.2](../ch02_general_camera_model/s5_2_real_data.ipynb)
# - **5 min.** Decide for a camera that nobody has brought. [Which
#   method?](choose_a_method.ipynb)
#
# `make report RECORDED=folder` gives every set of a folder a page, with
# exercises of its own; run it after the lesson. Switch off zoom and any
# processing that straightens the picture. Without a printer,
# `raxel render data/rigs/coolpix-fce8-zoom-2.yaml --out SET` makes a set.
#
# *Ask.* Why keep photographs out? The board is printed a little too small:
# what changes? Which part of the image has no ray, and whose fault is that?
#
# *Expect.* Boards all facing the camera; boards only in mid-image; the
# number of squares in the place of the number of inner corners; a sheet of
# paper that bends. "0.2 px on the fitted photographs, so we are done."
#
# ## Route E: which corner is which?
#
# *Aim.* See why order is harder than detection when a picture is bent, and
# how an algorithm that only looks at small windows keeps the order.
#
# - **5 min.** On paper: number the corners of a bent board. What did you
#   follow with your eyes?
# - **15 min.** CELECT by hand: four clicks, one window, the next anchor.
#   [3.1.2](../ch03_planar_grids/s1_2_celect.ipynb)
# - **10 min.** Exercises, in pairs. *3.1.2*
# - **15 min.** Groups, one condition each. Which stage fails?
#   [Conditions](../ch03_planar_grids/s3_2_conditions.ipynb)
# - **5 min.** Each group: how would a program notice that failure itself?
#
# *Ask.* Why does a larger window not always help? Why is the first corner
# special? One corner is detected four times: is that a fault of the detector?
#
# *Expect.* "It follows straight lines": it follows a line for half a square
# at most. "A failed board is an undetected corner": most are lost on the
# way, or merged. In the exercises: ten corners taken for ten squares.
#
# ## Route F: to a hundredth of a pixel
#
# *Aim.* Tell precision from bias, and see that choosing the best of many
# settings after the fact is no measurement.
#
# - **5 min.** How can a corner be found better than to a pixel? Guess a
#   number.
# - **15 min.** Saddle point and derivative method: windows and blur.
#   [3.1.3](../ch03_planar_grids/s1_3_localisation.ipynb)
# - **12 min.** Exercises. *3.1.3*
# - **7 min.** From where does the localiser still come home?
#   [3.3.1](../ch03_planar_grids/s3_1_robustness.ipynb), the basin
# - **5 min.** Between the corners: an error that is no noise.
#   [3.2.1](../ch03_planar_grids/s2_1_interpolation_bias.ipynb), Fig. 3.7
# - **6 min.** The winner by chance: throw a die for each setting, choose
#   the best per corner, throw again.
#
# *Ask.* What does blur do to an edge that is an arc? Which error does more
# pictures make smaller, and which not? Why is "the best setting for each
# corner" better than any setting?
#
# *Expect.* "A larger window is better, it averages more": not on a curved
# edge. "A full window of 9 px and a half window of 9 px are a detail": it
# decides how far a start may be off.
#
# ## Route G: until it breaks
#
# *Aim.* Plan a robustness experiment: one thing at a time, a limit that is
# defined beforehand, trials, failures counted.
#
# - **8 min.** Groups define "fails" for a detector of corners, in one
#   sentence with a number in it.
# - **15 min.** The five sweeps: noise, blur, size, bending, yaw.
#   [3.3.1](../ch03_planar_grids/s3_1_robustness.ipynb), Fig. 3.11
# - **10 min.** Exercises. *3.3.1, the first and the third*
# - **12 min.** A sweep with other trials. *command below*
# - **5 min.** Which limits are the method's, and which are the picture's?
#
# ```console
# $ make fig_3_11 TRIALS=5
# ```
#
# draws Fig. 3.11 with that many trials. In the build of this page the noise
# alone took {glue:text}`sweep`, added up over the jobs.
#
# *Ask.* Which constant of ours, not stated in the thesis, moves the limit
# of noise most? At which yaw must every method fail? All trials of a level
# share one picture: what do they say about other pictures?
#
# *Expect.* "It stands noise up to the limit": for this picture and these
# settings. "No failure in 50 trials means it never fails".
#
# ## Route H: is it better than the other?
#
# *Aim.* Compare two methods fairly on the same pictures, and say what the
# comparison does not show.
#
# - **8 min.** Four cameras, sixty grids: look at the pictures and predict.
#   [3.3.2](../ch03_planar_grids/s3_2_grid_sets.ipynb)
# - **15 min.** Who gets which picture right? Pairs, not totals. *3.3.2*
# - **12 min.** Exercises. *3.3.2, and what its result depends on*
# - **10 min.** Light, shadow, order of the clicks, border: one remark per
#   group. [Conditions](../ch03_planar_grids/s3_2_conditions.ipynb)
# - **5 min.** The scoreboard: a claim about rates, and its readings.
#
# *Ask.* Why does one count the pictures that only one method gets right?
# One method has four clicks from a human: is that fair, and to whom? What
# would have to be written down before the first run?
#
# *Expect.* "51 of 60 beats 26 of 60, so p is small": the pictures are the
# same, so the pairs decide. "OpenCV is OpenCV": today's is not that of 2009.
#
# ## Route I: every pixel reads its place
#
# *Aim.* Decode one pixel by hand, see what the gamma of a monitor does to
# its place and what six steps do about it, and judge a claim by its range
# and its measure.
#
# - **5 min.** On paper: twenty pictures of a monitor. How could each pixel
#   know where it looks?
# - **15 min.** One pixel by hand, in pairs: bits, cell, phase, place. Fig.
#   3.8 and the model.
#   [3.2.2](../ch03_planar_grids/s2_2_active_grids.ipynb)
# - **10 min.** Exercises. *3.2.2*
# - **15 min.** The ripple of gamma: three, four and six steps. Which orders
#   are left, and why? [Appendix
#   A](../appendix_a/phase_and_harmonics.ipynb)
# - **10 min.** Exercises. *Appendix A, the second and the third*
# - **20 min.** "Active grids stand noise": what does the row of noise in
#   Fig. 3.15 show, and why is the verdict what it is?
#   [3.3.3](../ch03_planar_grids/s3_3_active_grid_robustness.ipynb), with
#   its third exercise
#
# *Ask.* Why is each pattern of bits shown with its inverse? What becomes of
# the ripple when ten series are averaged? Whose error is most of the
# residual in Fig. 3.15? The thesis's range of noise is lost: up to which
# level would the claim hold, and who may choose the range, and when?
#
# *Expect.* A negative phase that is not turned into a whole period: the
# place is one cell too low. "Six steps are better because they average
# more": against the ripple it is the orders that count. "The standard
# deviation holds the error": it knows noise and no ripple. "The curves lie
# together, so the methods err alike": the second grid's error is in all of
# them. "The claim differs, so active grids are worse": a sine is flatter
# than an edge, which counts where there is much noise; the other rows are
# claims of their own.
#
# ## Route J: one centre is enough
#
# *Aim.* Turn a fisheye into a pinhole without a lens formula, and find out
# by steps which part of a method earns its success.
#
# - **5 min.** On paper: a pane of glass before a fisheye. What is the picture
#   that its rays draw on the pane?
# - **15 min.** The base grid as image plane, and its exercises.
#   [4.1.1](../ch04_central_generic/s1_1_synthetic_pinhole.ipynb)
# - **12 min.** Four numbers from two homographies: the first exercise by
#   hand. [4.1.2](../ch04_central_generic/s1_2_linear_stage.ipynb)
# - **15 min.** Fig. 4.2: who wins? Groups write down why, before they look
#   at the steps. [4.1.5](../ch04_central_generic/s1_5_simulated.ipynb)
# - **15 min.** A centre that may move: why the lowest residual is the wrong
#   place. [4.1.4](../ch04_central_generic/s1_4_bundle_adjustment.ipynb),
#   with its exercises
# - **8 min.** Do the rays of a real mirror meet? [Central or
#   not](../ch04_central_generic/ext_central_or_not.ipynb)
# - **5 min.** The scoreboard: a claim whose two readings part ways.
#
# *Ask.* Why do two grids parallel to each other not tell the centre? What
# does a camera lose that gets the nearest centre though it has none? Two
# methods solve the same equations and differ tenfold: where is the difference?
#
# *Expect.* "The fisheye's picture is undistorted": the picture on the pane
# is. "The adjusted centre has the smaller residual, so it is better": noise
# is made smaller, too. "p is large, so the camera is central": no departure
# larger than the bound was there to be seen.
#
# ## Route K: bend a mirror
#
# *Aim.* Predict from one slope how far a view widens, check it against a rig
# whose truth is known, and say what the prediction left out.
#
# You need a plastic mirror of a hand's size or more, a ruler, and a telephone.
#
# - **5 min.** Hold one edge of the mirror to the table, push the other, and look
#   at the telephone's picture. What comes into view, at which edge of it?
# - **10 min.** On paper: draw the sheet's slope, from the clamp to the load and
#   beyond. How far does the ray at the load turn?
#   [5.1](../ch05_flexible_mirror/s1_model.ipynb), with its second exercise
# - **25 min.** Predict and check: the fan of rays at 15 mm, in pairs, from the first
#   two exercises. Then the figure. Groups name what the prediction left out.
#   [5.3.3](../ch05_flexible_mirror/s3_3_calibration.ipynb), Fig. 5.10
# - **5 min.** The mirror was bent: what is left of its calibration, and what is
#   needed anew? [5.2](../ch05_flexible_mirror/s2_method.ipynb), Fig. 5.4, and
#   [a film](../ch05_flexible_mirror/s3_3_repeatability.ipynb)
# - **5 min.** The scoreboard: "twice the field of view", on two geometries. Why
#   does it hang on the rig?
#
# *Ask.* Which rays do not turn at all when the mirror is bent? Pushed from the
# other side, hollow: what becomes of the fan, and when does it turn inside out?
# Twice the deflection: twice the widening? Where would you push to get the
# widest view from a push of 5 mm, and what breaks first?
#
# *Expect.* The mirror's angle in the place of the ray's, which is twice that. The
# mean slope, deflection over length, in the place of that at the load. "Beyond
# the load it is bent most": there it is straight. "The view is twice as wide, so
# the picture holds twice as much": each pixel then has half of the room.
#
# ## Exercises and how long they run
#
# The pages of chapters 1 to 5 and of Appendix A have
# {glue:text}`exercises` exercises that check their answers, on
# {glue:text}`pages` pages. *Longest check* is the time to compute the right
# answer, measured when this page was built, without the start of the
# notebook and its imports.

# %% tags=["active-ipynb"]
# exercise_list(pages)

# %% [markdown]
# ## Experiments that a class can repeat


# %% tags=["active-ipynb"]
# show_table("ext_class_runs")

# %% [markdown]
# Seconds of every experiment stand in its log, below its figure.
#
# ## Limits
#
# The minutes are a plan; no class has been timed with it. The wrong answers
# are those that the hints were written for and those that the equations
# invite; they were not collected in classrooms.
