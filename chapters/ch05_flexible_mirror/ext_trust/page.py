# %% [markdown]
# # How far can an updated calibration be trusted?
#
# **Question.** A mirror is bent, and its calibration is updated from one
# picture of a grid before and one after. Each update begins with the one
# before it, so errors are handed on. How fast do they grow, what holds them
# down, and does the calibration itself say how good it is?

# %%
from chapters.ch05_flexible_mirror.ext_trust.exercises import (
    check_task,
    handed_on_task,
    widening_task,
)
from chapters.ch05_flexible_mirror.ext_trust.results import name_values
from chapters.ch05_flexible_mirror.ext_trust.trials.course import (
    bundled,
    known_viewer_trial,
    own_space_trial,
    trust_trial,
)
from chapters.ch05_flexible_mirror.ext_trust.trials.lesson import field_of_view
from chapters.ch05_flexible_mirror.ext_trust.trials.scene import SETTINGS
from chapters.ch05_flexible_mirror.ext_trust.trials.sweeps import (
    prior_trial,
    support_trial,
)
from chapters.shared.mirror_rigs import mirror_rig
from repro.page.exercise import check
from repro.page.reader import open_results, show, show_code, show_table
from repro.run.experiment import experiment
from repro.run.outcomes import Plan, crossed

RIGS = (
    "data/rigs/flexible-mirror-a.yaml",
    "data/rigs/flexible-mirror-a-monitor.yaml",
    "data/rigs/flexible-mirror-b.yaml",
    "data/rigs/flexible-mirror-b-monitor.yaml",
)
SEEDS = {"quick": 1, "full": 20}
FEWER = {"quick": 1, "full": 8}
SURFACES = {"geometry": ("A", "B"), "aberration_um": (0.0, 10.0)}

# %% tags=["active-ipynb"]
# show("ext_mirror_trust_figure")

# %% tags=["active-ipynb", "remove-input"]
# name_values(open_results)

# %% [markdown]
# **Findings.**
#
# - On geometry A {glue:text}`A.met` of {glue:text}`targets` targets are met
#   by the median of {glue:text}`seeds` seeds, on B {glue:text}`B.met`; see the
#   [table](#ext_mirror_targets).
# - Errors grow. On the smooth mirror of A the mean ray is
#   {glue:text}`A.smooth.prior.angle1` degrees off after the first deflection
#   and {glue:text}`A.smooth.prior.angle3` after the third.
# - All stages adjusted together take most of the growth away:
#   {glue:text}`A.smooth.prior.bundle.angle3` degrees at stage 3, on B
#   {glue:text}`B.smooth.prior.bundle.angle3` instead of
#   {glue:text}`B.smooth.prior.angle3`.
# - What the bundle says of its own rays is about right. Squared errors at
#   stage 3 are {glue:text}`A.own_space` (A) and {glue:text}`B.own_space` (B)
#   times what it predicts where the mirror is one of its splines. Of a sheet
#   by physics, which none of them is, it is {glue:text}`A.smooth.among3` and
#   {glue:text}`B.smooth.among3` times among the corners, and over the whole
#   mirror {glue:text}`A.smooth.whole3` and {glue:text}`B.smooth.whole3`.
# - Where it promises too much, at stage 1 of the smooth B
#   ({glue:text}`B.smooth.among1`), it is the viewer. With one that is exactly
#   known it is {glue:text}`B.known_viewer`.
# - A stage by itself knows less well how good it is. With its own misfit
#   counted, squared errors at stage 1 are {glue:text}`A.smooth.stage1` (A) and
#   {glue:text}`B.smooth.stage1` (B) times the prediction on a smooth mirror,
#   and {glue:text}`A.uneven.stage1` and {glue:text}`B.uneven.stage1` times on
#   an uneven one.
# - Residuals do not warn. Where corners reach into no more than
#   {glue:text}`support.few` of the last knot interval, rays at the free edge
#   of A are {glue:text}`support.few.plain.edge_deg` degrees off without
#   the prior instead of {glue:text}`support.all.plain.edge_deg`, and the
#   residual stays at {glue:text}`support.few.plain.residual_mm` mm. Of
#   {glue:text}`support.seeds` seeds {glue:text}`support.few.refused` are
#   refused there, and {glue:text}`support.refused` where no corner is left in
#   the interval.

# %% [markdown]
# ## What the thesis claims
#
# Nothing of this. It reports the deflection that was found, residuals, and
# back-projection with the pose that the calibration itself finds (5.3.3).
# None of the three shows a wrong shape, as 5.3.3 here shows. It says that
# errors are expected to add up over deflections, and leaves open how to know.

# %% [markdown]
# ## Model
#
# **Inverse depth.** The thesis's spline is the distance along viewing rays.
# Here it is one over the depth, $\rho = 1/S_z$: a plane is then linear in the
# picture, so that a mirror that is nearly flat is nearly free of bias. The
# clamp holds position and slope.
#
# **All stages at once.** Each board is seen before and after a deflection, so
# it ties two shapes together. Splines of all stages and poses of all boards
# are adjusted to all corners, each told in standard deviations of its place
# in the picture; the first shape is fixed. So a later picture corrects an
# earlier shape, which stage by stage it cannot.

# %% tags=["active-ipynb"]
# show_code(bundled)

# %% [markdown]
# **Covariance.** The normal matrix at the end gives the covariance of all
# coefficients, and so a standard deviation for each of the two components of
# a ray's direction. A real sheet is none of the splines. What the residuals
# have beyond the corners' noise is *misfit*: it widens the covariance, and
# what no spline can follow is added to each ray. *Coverage* is the mean of
# squared errors over squared predictions, 1 where a prediction is right.
#
# **A prior on bending.** The change of the second derivative from one knot
# interval to the next is taken to be small, as a beam's is, with a standard
# deviation in mm: twice the bow that it makes over an interval. Its size was
# chosen on {glue:text}`prior.seeds` seeds of its own by one rule, least ray
# error at stage 3 over both geometries, smooth and uneven:
# {glue:text}`prior.mm` mm, for all that this page shows.
#
# **Support.** Corners per knot interval are counted. An outermost interval
# without any is refused, unless the clamp or a prior carries it; one that
# corners reach into by less than 60 % is flagged. And the prior is put upon
# the finished shape, weighed by its covariance with the misfit: where rays at
# an end then turn by more than 3 degrees, nothing but the misfit of the last
# corners has made the shape there, and it is flagged; from 5 degrees on it is
# refused.

# %% [markdown]
# ## Experiment
#
# Both mirror rigs, corners with 0.2 px and decoded points with 0.01 mm of
# Gaussian noise. Camera and first shape are calibrated as in 5.3.3: boards,
# two places of a monitor, platter, clamp line. Then three deflections of 5 mm
# with a board 260 mm from the mirror, elsewhere each time; three steps back
# before a board that stays; and 15 mm at a stroke. The mirror is a sheet by
# physics, smooth or uneven by 10 µm. Error is what the rays are off from the
# true ones, over the whole mirror.


# %%
@experiment(
    "ext_mirror_trust_runs",
    artefact="ext_mirror_trust_figure",
    shards={"full": 2},
    inputs=RIGS,
)
def trust_runs(effort):
    """Three stages, there and back, and all together; with the prior and without."""
    return Plan(trust_trial, crossed(**SURFACES), SEEDS[effort], SETTINGS)


# %%
@experiment("ext_mirror_own_space", artefact="ext_mirror_coverage_table", inputs=RIGS)
def own_space(effort):
    """Mirrors that are splines: do predicted errors cover the true ones?"""
    return Plan(own_space_trial, crossed(geometry=("A", "B")), SEEDS[effort], SETTINGS)


# %%
@experiment(
    "ext_mirror_known_viewer", artefact="ext_mirror_coverage_table", inputs=RIGS
)
def known_viewer(effort):
    """The bundle's prediction where the viewer is exact, on geometry B."""
    return Plan(known_viewer_trial, crossed(geometry=("B",)), FEWER[effort], SETTINGS)


# %%
@experiment(
    "ext_mirror_support_runs", artefact="ext_mirror_support_figure", inputs=RIGS
)
def support_runs(effort):
    """Fewer and fewer corners next to the free edge."""
    return Plan(support_trial, crossed(geometry=("A", "B")), FEWER[effort], SETTINGS)


# %%
@experiment("ext_mirror_prior_runs", artefact="ext_mirror_prior_figure", inputs=RIGS)
def prior_runs(effort):
    """Every strength of the prior, on seeds of its own."""
    return Plan(prior_trial, crossed(**SURFACES), FEWER[effort], SETTINGS)


# %% [markdown]
# ## The targets

# %% tags=["active-ipynb"]
# show_table("ext_mirror_targets")

# %% [markdown]
# Beside the residual, {glue:text}`A.residual` mm on A, stand the errors that
# it does not show: back-projection onto a board at 400 mm is
# {glue:text}`A.back_own` mm off with the pose that the calibration itself
# finds, and {glue:text}`A.back_true` mm with the true one. There and back
# the load's height is {glue:text}`A.loop` mm off: that the camera comes back
# to where it began says little of how good it was on the way. One step of
# 15 mm at a stroke misses {glue:text}`A.single` % of it; without the prior
# {glue:text}`A.plain.single_refused` of {glue:text}`seeds` seeds on A and
# {glue:text}`B.plain.single_refused` on B refuse it, since corners that both
# pictures show do not reach the free edge. Corners that the second picture
# alone shows have their places as well, once the board has its pose: with
# them it is {glue:text}`A.single_all` % (A) and {glue:text}`B.single_all` %
# (B). That row was no target beforehand; it was added after the one above it
# had been missed.

# %% [markdown]
# ## Does it know how good it is?

# %% tags=["active-ipynb"]
# show("ext_mirror_coverage_figure")

# %% tags=["active-ipynb"]
# show_table("ext_mirror_coverage_table")

# %% [markdown]
# ## What corners at the free edge are worth

# %% tags=["active-ipynb"]
# show("ext_mirror_support_figure")

# %% [markdown]
# With the prior an interval without any corner is carried on:
# {glue:text}`support.none.prior.edge_deg` degrees off at the edge, where
# {glue:text}`support.none.prior.predicted_deg` are predicted. It is
# flagged, and no measurement.

# %% [markdown]
# ## How strong a prior?

# %% tags=["active-ipynb"]
# show("ext_mirror_prior_figure")

# %% [markdown]
# Over all conditions the chosen prior makes rays at stage 3 better by
# {glue:text}`prior.gain` % on its own seeds: next to nothing where
# corners reach the edge. What it is for is the edge without them. A strong
# one, 0.01 mm, biases the shape.

# %% [markdown]
# ## Reading and limits
#
# **Drift.** Stage by stage, the board's pose comes from the shape before, and
# the new shape from that pose. An error of the one goes into the other, and
# nothing in the next picture can tell it from a deflection. The bundle sees
# all pictures at once, and each shape twice.
#
# **Misfit, not noise.** On both sheets, residuals are larger than the
# corners' noise makes them: seven splines along the sheet are not a bent
# sheet, and less so one that is uneven. More corners do not help there; the
# misfit term says so. It is told from residuals among the corners, so it
# knows nothing of what lies beyond them.
#
# **The viewer** is taken to be as its own calibration found it, from twelve
# boards. Its error turns the first shape, which is held fixed or known to a
# covariance that does not count it, and all others after that. On B, where
# the mirror is near and what noise leaves at stage 1 is small, that is what
# the prediction misses: with an exact viewer coverage at stage 1 is
# {glue:text}`B.known_viewer` ({glue:text}`known_viewer.seeds` seeds) instead of
# {glue:text}`B.smooth.among1`. No misfit shows it, since all pictures have it
# alike; more boards for the viewer make it smaller.
#
# **What a stage cannot know.** Its prediction counts noise, pose and its own
# misfit, and takes the shape before to be true. How much neighbouring corners
# are moved alike is one number for all mirrors, and another for each mirror
# in truth. Of a chain of updates, ask the bundle.
#
# **The prior** says what a beam does, and the sheets here are beams. That it
# helps on a real mirror is not shown.
#
# **Limits.** Errors are independent and Gaussian, and no picture is rendered:
# nothing here says what wrong matches, blur or a biased corner do. The
# factors by which misfit counts were chosen on sheets of the same kind in
# other poses. Where the mirror's edges are, is known exactly. The same from
# [rendered pictures](s3_3_rendered.ipynb), with nothing drawn, is held against
# twice these targets.

# %% [markdown]
# ## Compared with the published numbers
#
# The thesis prints no uncertainty of a shape or of a ray. What it prints of
# residuals and back-projection is in 5.3.3. The targets of this page are
# aims that were set before the first run, and no numbers of the thesis.

# %% [markdown]
# ## Try it yourself
#
# Open this page as a notebook (`make lab`) and run all cells. Then put an
# answer in place of `None`, and run that cell again.
#
# **A lesson: bend a mirror, predict the field of view, check it.** The sheet
# of geometry A is clamped at one edge and pushed by 5 mm at 150 mm from
# there. Beyond the load it stays straight. The field of view is the angle
# between the scene rays that leave the mirror at the clamp and at the free
# edge. In class: a plastic mirror, a ruler, a telephone; draw the slope of
# the sheet first.
#
# **1.** By how many degrees does the field widen, if all that counts is how
# far the mirror turns at its free edge? Use (5.1).

# %% tags=["active-ipynb"]
# check(None, **widening_task())

# %% [markdown]
# **2.** Check it: by how many degrees does the field of the rig widen? The
# camera at a deflection is `mirror_rig("A").camera(5.0)`. Which way is the
# prediction off, and what has it left out? (The calibrations above find the
# field of A wrong by {glue:text}`A.field_error` degrees at stage 3, the
# median of the seeds: the ends of the sheet are where they are worst.)

# %% tags=["active-ipynb"]
# show_code(field_of_view)

# %% tags=["active-ipynb"]
# check(None, **check_task())

# %% [markdown]
# **3.** Three updates follow each other, each with an error of its own of
# one size, which it hands on. How many times that size is the error after
# the third? Compare with the first figure: does it grow like this, or faster?

# %% tags=["active-ipynb"]
# check(None, **handed_on_task())
