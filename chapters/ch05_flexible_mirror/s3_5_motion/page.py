# %% [markdown]
# # 5.3.5 Motion: a cylinder that moves before a bent mirror
#
# **Question.** A cylinder with 25 marks is moved sideways before a bent, calibrated
# mirror, 25 mm at a time. From the pictures alone: how did it turn, how far did it
# go, and how large is it? What of that can rays tell at all?

# %%
from functools import partial

from chapters.ch05_flexible_mirror.s3_5_motion.exercises import (
    alike_task,
    parallax_task,
    scale_task,
)
from chapters.ch05_flexible_mirror.s3_5_motion.results.prose import name_values
from chapters.ch05_flexible_mirror.s3_5_motion.trials.motion import pairwise
from chapters.ch05_flexible_mirror.s3_5_motion.trials.run import (
    SETTINGS,
    motion_trial,
    told,
)
from chapters.shared.mirror_bench import BENCHES, LEVEL, SWEPT
from chapters.shared.mirror_errors import MirrorErrors
from chapters.shared.mirror_files import GEOMETRY_A, GEOMETRY_C
from chapters.shared.mirror_plans import UNSEEN
from repro.page.exercise import check
from repro.page.reader import compared, open_results, show, show_code, show_table
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

# %% tags=["active-ipynb"]
# show("ext_motion_scale")

# %% tags=["active-ipynb", "remove-input"]
# name_values(open_results)

# %% [markdown]
# **Findings.**
#
# - The geometry is good enough where lengths are known. With the *true* mirror and the
#   length of each step given, the cylinder's turn is {glue:text}`true.given.first`° off
#   after one step and {glue:text}`true.given.last`° after five at the second level
#   (medians of {glue:text}`seeds` seeds; it did not turn). Its radius is
#   {glue:text}`true.given.radius` % off.
# - The rest of the error comes from the calibration. Steps found one by one with the
#   published calibration and added up end {glue:text}`published.open.off` mm beside the
#   truth at the second level and {glue:text}`lab.published.open.off` mm at the
#   low-noise level; the thesis has 4.05 mm. Of the seeds at the second level
#   {glue:text}`refused` have no motion, and {glue:text}`no_shape` more no cylinder.
# - Two pictures do not determine a length. Exact rays of a smooth mirror bent by 15 mm
#   leave a step of 25 mm uncertain by {glue:text}`lab.told.3` % of itself and 125 mm by
#   {glue:text}`lab.told.far.3` %, whatever the method. Six pictures at once leave
#   {glue:text}`lab.true.six.told` % of 125 mm.
# - A scale can be precise and wrong. With the published calibration the same six
#   pictures of the low-noise level find {glue:text}`lab.published.six.share` of the
#   length, with a stated standard deviation of {glue:text}`lab.published.six.told` %. A
#   flat mirror determines no length; at stage 0 pairs find {glue:text}`lab.times.0`
#   times the true one there, in most seeds nearly the same.

# %% [markdown]
# ## What the thesis claims
#
# - A bent mirror's rays have no common centre, so that motion follows from the
#   generalised essential matrix, (5.30).
# - Steps found from pair to pair and added up agree with the truth, 4.05 mm off after
#   125 mm, when their mean is scaled to 25 mm (Table 5.7, Fig. 5.20).
# - Rays that do not meet in one point tell the scale. It gets unreliable as the mirror
#   gets flat: the mean step comes out as 31.34 mm.
# - The cylinder's radius is 58.96 mm scaled and 73.90 mm unscaled, of 62.98 mm. All
#   reconstructed points but one lie within 3 mm of the cylinder (Fig. 5.21).

# %% [markdown]
# ## Model
#
# **Rays.** A pixel's scene ray starts at a point $S$ of the mirror in the direction
# $V$. As a line it has Plücker coordinates $L = (V,\; S \times V)$. If points move by
# $X_2 = R X_1 + t$, the two lines to one point meet:
#
# $$ L_2^T \mathcal{E} L_1 = 0, \qquad
# \mathcal{E} = \begin{pmatrix} [t]_\times R & R \\ R & 0 \end{pmatrix}.
# \tag{5.30} $$
#
# That is linear in $\mathcal{E}$ and needs 17 points. What is minimised after that is
# how far the rays of each pair miss each other, in standard deviations of the noise,
# over $R$ and $t$.
#
# **A turn for a shift.** The cylinder is {glue:text}`way` mm from the point that the
# rays come nearest to. A step of 25 mm is seen there under {glue:text}`alike`°, much
# as a turn of the camera would be. What tells them apart is that the nearest mark
# moves by {glue:text}`parallax`° more than the farthest. Rays that are wrong by more
# than that, and differently from place to place, make a turn out of a shift.
#
# **The length.** Were all rays to pass through one point, $t$ could be stretched at
# will. Only as far as they pass it, here {glue:text}`lab.spread.3` mm (root mean
# square), is there a length at all. How well noise leaves it known, before any
# method is tried, is read from the Fisher information of the rays about the turn,
# the direction and the logarithm of the length. The inverse's diagonal holds the
# variances that no unbiased method beats.

# %% tags=["active-ipynb"]
# show_code(told)

# %% [markdown]
# ## Experiment
#
# The mirror is calibrated up to 15 mm as in [three
# deflections](s3_3_deflections.ipynb), stage by stage as published; beside it stands
# the true mirror. A cylinder of 62.98 mm stands {glue:text}`away:.0f` mm from the
# mirror, placed by hand, and is moved by 25 mm five times, without turning. It has 25
# marks, which the true camera sees in all six places, with Gaussian noise of 0.2 px
# along each axis. Which mark is which is known.
#
# Each pair of pictures is searched from samples of eight, then adjusted. Motions with
# most points behind the mirror come last. *Open*: the length of each step is found from
# the rays, and all are multiplied so that their mean is 25 mm, as in the thesis.
# *Given*: each step's length is known. *Six pictures at once*: one bundle of poses and
# points, lengths open. It begins at the steps with lengths given: the search for a
# first estimate is not part of it. All is run at three error levels; the second one
# decides.

# %% tags=["active-ipynb"]
# show_code(pairwise)


# %%
SEEDS = {"quick": 1, "full": 20}
FEWER = {"quick": 1, "full": 10}


@experiment(
    "table_5_7_runs",
    artefact="table_5_7",
    shards={"full": 2},
    inputs=GEOMETRY_A,
    needs=("sec_5_3_3_errors",),
)
def runs(effort, results):
    """Geometry A, at all levels, with both cameras."""
    return _plan(results, _first(LEVEL, effort), SEEDS[effort], alone=False)


@experiment(
    "table_5_7_swept",
    artefact="table_5_7",
    inputs=GEOMETRY_A,
    needs=("sec_5_3_3_errors",),
)
def swept(effort, results):
    """Geometry A, from half to twice the primary level's numbers, as published."""
    benches = _first("half the factor", effort)
    return _plan(results, benches, FEWER[effort], alone=True)


@experiment(
    "table_5_7_longer",
    artefact="table_5_7",
    inputs=GEOMETRY_C,
    needs=("sec_5_3_3_errors",),
)
def longer(effort, results):
    """Geometry C, at the primary level."""
    level = {LEVEL: BENCHES[LEVEL]}
    return _plan(results, level, SEEDS[effort], alone=False, geometry="C")


def _first(name, effort):
    """All benches of a kind, at quick the one of a name."""
    every = SWEPT if name in SWEPT else BENCHES
    return every if effort == "full" else {name: every[name]}


def _plan(results, benches, seeds, alone, geometry="A"):
    errors = {geometry: MirrorErrors.read(results["sec_5_3_3_errors"], geometry)}
    trial = partial(motion_trial, errors=errors, benches=benches, alone=alone)
    settings = SETTINGS | {name: bench._asdict() for name, bench in benches.items()}
    return Plan(trial, [{"geometry": geometry}], seeds, settings, UNSEEN)


# %% [markdown]
# ## Further figures

# %% tags=["active-ipynb"]
# show_table("table_5_7")

# %% tags=["active-ipynb"]
# show("fig_5_20")

# %% tags=["active-ipynb"]
# show("fig_5_21")

# %% [markdown]
# ## Reading and limits
#
# **Why the steps fail.** Rays of the published calibration are
# {glue:text}`published.ray`° off at the second level and
# {glue:text}`lab.published.ray`° at the low-noise level. What distinguishes a shift
# from a turn is {glue:text}`parallax`°. So the first turn at the second level,
# {glue:text}`published.open.first`°, is about the {glue:text}`alike`° under which the
# step is seen: the shift was taken for a turn. The cylinder's distance, the thesis's
# field of view and how its marks were chosen are not stated; a nearer cylinder is
# easier. Ours was placed so that its marks stay in view, and not moved after the
# results.
#
# **What can be observed.** Turn and direction can, and the shape up to scale. Two
# pictures hardly determine a length, and pairs that are added up cannot make up for it:
# each is open by itself, and one runs away now and then. With the true mirror at the
# low-noise level the mean step is found as {glue:text}`lab.true.open.mean` mm. That it
# is {glue:text}`published.open.mean` mm at the second level, calibrated, where the
# thesis has 31.34 mm, means nothing: seeds have from {glue:text}`least` to
# {glue:text}`most` mm. Bending more is no help: at 5, 10 and 15 mm the SD of a step is
# {glue:text}`lab.told.1`, {glue:text}`lab.told.2` and {glue:text}`lab.told.3` % of it.
# The waves of the second level help more: its uneven mirror leaves {glue:text}`told.3`
# % at 15 mm. Six pictures of the same marks, adjusted together, hold one length in many
# ways. The thesis's sentence on metric scale calls for that experiment. It needs rays
# that are as right as they are precise: with the published calibration the residuals
# are several times the noise, and the length that fits them best is another.
#
# **Does scatter fall with bending?** Of the logarithm of the scale it is a factor of
# {glue:text}`scatter.0`, {glue:text}`scatter.1`, {glue:text}`scatter.2` and
# {glue:text}`scatter.3` at stages 0 to 3 at the second level, where a seed without a
# motion counts as a factor of 100, as in the claim. At the low-noise level it rather
# rises, from {glue:text}`lab.scatter.0` to {glue:text}`lab.scatter.3`: a flat mirror's
# scale is made by the calibration's error, which is much the same in every seed. So a
# scale that is repeated is not one that is known.
#
# **A common centre.** Rays pass the point nearest to them by
# {glue:text}`lab.spread.1`, {glue:text}`lab.spread.2` and {glue:text}`lab.spread.3` mm
# at 5, 10 and 15 mm of deflection. So (5.30) applies, and holds to rounding without
# noise. That a camera is not central does not mean that it tells a length.
#
# **Limits.** A claim judged seed by seed rests on {glue:text}`seeds` seeds, its sweep
# on fewer at each end; its verdict is the same at all of them. Calibrations see redrawn
# corners. Claims are judged on completed runs; where the true mirror fails a claim as
# well, the geometry decides, and it is not comparable.

# %% [markdown]
# ## Compared with the published numbers

# %% tags=["active-ipynb"]
# compared()

# %% [markdown]
# ## Try it yourself
#
# Open this page as a notebook (`make lab`) and run all cells. Then put an answer in
# place of `None`, and run that cell again. Answers may be 2 % off.
#
# **1.** A cylinder is 700 mm from where rays come from, and moves 25 mm across.
# Under which angle, in degrees, is the step seen?

# %% tags=["active-ipynb"]
# check(None, **alike_task())

# %% [markdown]
# **2.** Its farthest marks are 36 mm farther away than its nearest. By how many
# degrees do they move less? Compare with the errors of the rays above.

# %% tags=["active-ipynb"]
# check(None, **parallax_task())

# %% [markdown]
# **3.** The thesis finds a mean step of 31.34 mm, which was 25 mm, and a radius of
# 73.90 mm. Which radius, in mm, is that when the steps are scaled to what they were?

# %% tags=["active-ipynb"]
# check(None, **scale_task())
