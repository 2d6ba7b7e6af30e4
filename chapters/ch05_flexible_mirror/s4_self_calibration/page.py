# %% [markdown]
# # 5.4 Self-calibration: can the target be left out?
#
# **Question.** A mirror is bent before a scene that nobody measured. Can the camera be
# calibrated from the pictures before and after alone, and can a scene be told in three
# dimensions by bending the mirror?

# %%
from functools import partial

from chapters.ch05_flexible_mirror.s4_self_calibration.exercises import (
    bias_task,
    depth_task,
)
from chapters.ch05_flexible_mirror.s4_self_calibration.results.prose import name_values
from chapters.ch05_flexible_mirror.s4_self_calibration.trials.course import (
    Extent,
    course_trial,
)
from chapters.ch05_flexible_mirror.s4_self_calibration.trials.known import known_trial
from chapters.ch05_flexible_mirror.s4_self_calibration.trials.pictures import (
    pictures_trial,
)
from chapters.ch05_flexible_mirror.s4_self_calibration.trials.ways import ways_trial
from chapters.shared.mirror_bench import BENCHES, SWEPT
from chapters.shared.mirror_errors import MirrorErrors
from chapters.shared.mirror_files import GEOMETRY_A, GEOMETRY_B, SMALL_A
from raxel.calibration.mirror.self_calibration import linear_update, one_depth_update
from repro.page.exercise import check
from repro.page.reader import compared, open_results, show, show_code, show_table
from repro.run.experiment import experiment
from repro.run.outcomes import Plan, crossed

# %% tags=["active-ipynb"]
# show("fig_5_24")

# %% tags=["active-ipynb", "remove-input"]
# name_values(open_results)

# %% [markdown]
# **Findings.**
#
# - Linear self-calibration is no calibration beyond one small push. As 5.4 tells it,
#   with features across the middle and near ones at the end that bends, it finds
#   {glue:text}`lab.told.1`, {glue:text}`lab.told.2` and {glue:text}`lab.told.3` mm of
#   three pushes of 5 mm in the laboratory, much as [Table 5.9](#table_5_9) has it. On
#   the bench it is {glue:text}`told.1`, {glue:text}`told.2` and {glue:text}`told.3` mm,
#   and {glue:text}`told.refused` of {glue:text}`seeds` seeds are refused. After the
#   third push rays are {glue:text}`lab.told.deg.3`° and {glue:text}`told.deg.3`° off;
#   with boards {glue:text}`lab.board.deg.3`° and {glue:text}`board.deg.3`°.
# - Matching is not what limits it. In rendered pictures, from some
#   {glue:text}`lab.matches` SIFT matches in two steps, {glue:text}`lab.sift.deflection`
#   mm of one push are found in the laboratory and {glue:text}`sift.deflection` on the
#   bench; from about as many drawn features, most of which both steps show,
#   {glue:text}`lab.many.deflection` and
#   {glue:text}`many.deflection`. With a tenth of these the bench's rays are
#   {glue:text}`drawn.angle`° off in place of {glue:text}`many.angle`°.
# - Feeding triangulated points back, as 5.4 suggests, changes nothing. Of 2.5 mm before
#   a scene 0.8 m away the linear stage finds {glue:text}`near.linear` mm, the loop
#   after six rounds {glue:text}`near.feedback6`: points lie where the wrong shape puts
#   them, and agree with it.
# - Straight edges as 6.3.3 words them make it worse, {glue:text}`near.edges` mm: before
#   this mirror a straight line and its picture are in no plane. With one line in space
#   for each edge, seen in both pictures, it is {glue:text}`near.lines` mm, which is no
#   gain.
# - One unknown depth for the whole scene, with a sheet that bends evenly, is this
#   page's own idea. It fails, too: {glue:text}`near.one_depth` mm with the published
#   model, and with the clamp's slope held {glue:text}`near.one_depth_held`. The depth
#   that fits best is the nearest or the farthest that is looked for
#   ([every way](#ext_self_ways)): how far away the scene is hardly shows.
# - Stereo between bent states: with calibrated mirrors depths in the far scene are
#   {glue:text}`found.deflected` % off, with a baseline of 100 mm
#   {glue:text}`found.baseline` %. With the *true* mirror and the same noise it is
#   {glue:text}`true.deflected` %: calibration spoils it, not the baseline alone.
# - A calibration by the general method, made anew after a push, is nearer to the true
#   rays than that from boards in {glue:text}`pays.1` % of the seeds after the first
#   push and {glue:text}`pays.3` % after the third, with {glue:text}`anew.3`° in place
#   of {glue:text}`board.deg.3`°; in the laboratory {glue:text}`lab.pays.1` and
#   {glue:text}`lab.pays.3` %, with {glue:text}`lab.anew.3`° in place of
#   {glue:text}`lab.board.deg.3`°.
# - With a known static scene errors do not accumulate: over eight steps they change by
#   {glue:text}`known.slope` % for a step, with boards whose poses are found by
#   {glue:text}`boards.slope` %.

# %% [markdown]
# ## What the thesis claims
#
# - From a distant scene the linear stage finds more of a deflection than from a near
#   board at stages 1 and 2, and as little at stage 3 (Table 5.9).
# - Features that cluster bend the mirror upright, more at each stage, and new near
#   ones give its profile an inflexion (Fig. 5.24).
# - Stereo between deflected states is very inaccurate, most so at the clamp
#   (Fig. 5.25). From four states a scene spreads by metres, but centroids are in
#   order (Fig. 5.26).
# - So linear self-calibration is of no use beyond one small push. With a known static
#   scene no error accumulates (5.5).

# %% [markdown]
# ## Model
#
# A feature is seen along a known ray before, with direction $V_r$, and at another pixel
# after. If it is infinitely far away, its new ray has the same direction (5.28), the
# normal lies half way between that and the way back along the viewing ray, and the
# shape follows linearly.
# At a depth $Z$ only about $Z/(Z+D)$ of the deflection is found, with the viewer $D$
# before the mirror. Residuals do not tell: a smaller deflection and a farther scene fit
# alike.

# %% tags=["active-ipynb"]
# show_code(linear_update)

# %% [markdown]
# The own idea moves all points to one depth along their rays, and takes the depth at
# which the refined mirror, under a prior on even bending, fits best.

# %% tags=["active-ipynb"]
# show_code(one_depth_update)

# %% [markdown]
# ## Experiment
#
# A wall is 5 m before the mirror, a plane 3.98 m, an object 4.95 m, as in Fig. 5.26.
# Features are drawn evenly, or nine in ten in the middle fifth of the mirror's height;
# and near ones may lie, 1.2 m away, where only the bent mirror looks. *Sag* is how far
# both sides of the mirror lie beyond its middle, at the load, more than they should.
# Over 5 mm no far feature is left in the last knot interval: of
# {glue:text}`seeds` seeds {glue:text}`whole` are refused in one step. So each push is
# self-calibrated in two. Primary stage, benches and the published method are those of
# [three deflections](s3_3_deflections.ipynb). What single steps can do is shown with a
# mirror that is known before.
#
# For {glue:text}`pictures` runs on each bench no feature is drawn: a printed wall and
# a printed plane are rendered in the mirror before a push, half way and after it, and
# features are found and matched by SIFT. What does not follow a smooth warp is left
# out. The primary stage before them has drawn errors as everywhere.

# %%
SEEDS = {"quick": 1, "full": 20}
SWEPT_SEEDS = {"quick": 1, "full": 10}
OTHER_SEEDS = {"quick": 1, "full": 8}
PICTURES = {"quick": 1, "full": 3}
# At quick size one push, and neither the sweep, nor geometry B, nor pictures.
EXTENT = {"quick": Extent(pushes=1, anew=False), "full": Extent()}
WITHOUT_ANEW = Extent(anew=False)


@experiment(
    "table_5_9_runs",
    artefact="table_5_9",
    shards={"full": 2},
    inputs=GEOMETRY_A,
    needs=("sec_5_3_3_errors",),
)
def runs(effort, results):
    """Geometry A, on both benches."""
    return _plan(results, "A", BENCHES, SEEDS[effort], EXTENT[effort])


@experiment(
    "table_5_9_swept",
    artefact="table_5_9",
    inputs=GEOMETRY_A,
    needs=("sec_5_3_3_errors",),
)
def swept(effort, results):
    """Geometry A, from half to twice each of the bench's numbers."""
    benches = SWEPT if effort == "full" else {}
    return _plan(results, "A", benches, SWEPT_SEEDS[effort], WITHOUT_ANEW)


@experiment(
    "table_5_9_other",
    artefact="table_5_9",
    inputs=GEOMETRY_B,
    needs=("sec_5_3_3_errors",),
)
def other(effort, results):
    """Geometry B, on both benches."""
    benches = BENCHES if effort == "full" else {}
    return _plan(results, "B", benches, OTHER_SEEDS[effort], WITHOUT_ANEW)


def _plan(results, geometry, benches, seeds, extent):
    errors = {geometry: MirrorErrors.read(results["sec_5_3_3_errors"], geometry)}
    trial = partial(course_trial, errors=errors, benches=benches, extent=extent)
    settings = {name: bench._asdict() for name, bench in benches.items()}
    return Plan(trial, [{"geometry": geometry}], seeds, settings)


@experiment(
    "ext_self_pictures_runs",
    artefact="ext_self_pictures",
    inputs=SMALL_A,
    needs=("sec_5_3_3_errors",),
)
def pictures(effort, results):
    """One push seen in rendered pictures, on both benches."""
    errors = {"A": MirrorErrors.read(results["sec_5_3_3_errors"], "A")}
    benches = BENCHES if effort == "full" else {}
    trial = partial(pictures_trial, errors=errors, benches=benches)
    return Plan(trial, [{"geometry": "A"}], PICTURES[effort])


@experiment("ext_self_ways_runs", artefact="ext_self_ways", inputs=GEOMETRY_A)
def ways(effort):
    """One step without a target, by every way, before two scenes."""
    conditions = crossed(geometry=["A"], depth_mm=[0.0, 800.0])
    return Plan(ways_trial, conditions, SEEDS[effort])


@experiment("exp_c5_known_scene", artefact="sec_5_5", inputs=GEOMETRY_A)
def known(effort):
    """Eight steps before a scene that is known, and before boards."""
    return Plan(known_trial, [{"geometry": "A"}], {"quick": 1, "full": 40}[effort])


# %% [markdown]
# ## Further figures

# %% tags=["active-ipynb"]
# show_table("table_5_9")

# %% tags=["active-ipynb"]
# show_table("ext_self_features")

# %% tags=["active-ipynb"]
# show("ext_self_pictures")

# %% tags=["active-ipynb"]
# show_table("ext_self_pictures_table")

# %% tags=["active-ipynb"]
# show("ext_self_feedback")

# %% tags=["active-ipynb"]
# show_table("ext_self_ways")

# %% tags=["active-ipynb"]
# show("fig_5_25")

# %% tags=["active-ipynb"]
# show("fig_5_26")

# %% tags=["active-ipynb"]
# show("fig_5_27")

# %% tags=["active-ipynb"]
# show_table("ext_self_anew")

# %% tags=["active-ipynb"]
# show_table("ext_self_swept")

# %% [markdown]
# ## Reading and limits
#
# **Where the error comes from.** With features spread evenly and all far, the
# laboratory finds {glue:text}`lab.even.1`, {glue:text}`lab.even.2` and
# {glue:text}`lab.even.3` mm; with boards the same seeds have {glue:text}`lab.board.1`,
# {glue:text}`lab.board.2` and {glue:text}`lab.board.3` mm. The finite depth takes its
# share, and each step starts from the rays of the last. On the bench, whose mirror has
# waves, wrong coefficients at the end of the mirror grow from step to step: even so
# {glue:text}`even.refused` of {glue:text}`seeds` seeds are refused, and after the third
# push only {glue:text}`even.reach` have a shape that still reaches the load. Residuals
# tell nothing of this, for there are none. More features help most
# ([pictures](#ext_self_pictures_table)): the runs of three pushes have few.
#
# **What survives of 5.4.** That stages 1 and 2 are nearer than a board's linear
# estimates is so in the laboratory, and on the bench in the median; there it changes
# with the waves ([shares](#ext_self_swept)), and stays undecided. That they get worse
# from push to push is so for most seeds in the laboratory. That the third is as far
# off as a board's linear estimate is chance: those of boards get better from push to
# push while these get worse. Clustered features do bend the mirror upright, by
# {glue:text}`lab.clustered.sag` mm at stage 3 in the laboratory, even ones by
# {glue:text}`lab.even.sag` mm; on the bench only {glue:text}`sides` of
# {glue:text}`seeds` seeds have a shape whose sides can be measured then. Near features
# give an inflexion at both stages in {glue:text}`near.inflected` % of the seeds, and
# without them it is there at both in {glue:text}`even.inflected` % (laboratory:
# {glue:text}`lab.near.inflected` and {glue:text}`lab.even.inflected` %). On the bench
# that is no comparison: only {glue:text}`near.reach` and {glue:text}`even.reach` seeds
# have a shape that reaches the load at stage 3, and the others count as without an
# inflexion. One curve that bends back names no cause. That the method is of no use
# beyond a push stands, and more than its test says: on the bench the test counts seeds
# that were refused, here or with boards, as misses.
#
# **The baseline between bent states.** 5.4 takes it for several millimetres. But after
# a push a feature is seen at another place of the mirror: the two places are
# {glue:text}`lab.apart` mm apart in the median, far more than the push. So stereo from
# 100 mm is better by less than the lengths suggest. At the clamp nothing is told: the
# standard deviation of a depth in the first of eight strips is {glue:text}`edge` times
# that in the last, which misses the ledger's ten. It hangs on the strips' width; with
# sixteen it is {glue:text}`finer` times.
#
# **Scenes from bent states.** The calibrated mirror puts the plane, the object and the
# wall at {glue:text}`found.plane.ratio`, {glue:text}`found.object.ratio` and
# {glue:text}`found.wall.ratio` of their depths, in the right order in
# {glue:text}`ordered` % of the seeds, and spreads the wall over
# {glue:text}`found.wall.spread` m. The true one has {glue:text}`true.plane.ratio`,
# {glue:text}`true.object.ratio` and {glue:text}`true.wall.ratio`, with features picked
# to half a pixel. The order of 5.4 is one draw: wall and object stand nearly as far
# away as each other.
#
# **When to calibrate anew.** From boards rays are {glue:text}`lab.board.deg.1`°,
# {glue:text}`lab.board.deg.2`° and {glue:text}`lab.board.deg.3`° off after the three
# pushes in the laboratory, by a primary stage made anew {glue:text}`lab.anew.1`°,
# {glue:text}`lab.anew.2`° and {glue:text}`lab.anew.3`°; on the bench
# {glue:text}`board.deg.1`°, {glue:text}`board.deg.2`° and {glue:text}`board.deg.3`°
# beside {glue:text}`anew.1`°, {glue:text}`anew.2`° and {glue:text}`anew.3`°. And
# {glue:text}`board.refused` of {glue:text}`seeds` seeds of the bench are refused on
# the way, and count for it. What six pushes do is on
# [repeatability](s3_3_repeatability.ipynb).
#
# **Geometry B**, {glue:text}`b.seeds` seeds: as told,
# {glue:text}`b.lab.told.1`, {glue:text}`b.lab.told.2` and {glue:text}`b.lab.told.3` mm
# in the laboratory and {glue:text}`b.told.1`, {glue:text}`b.told.2` and
# {glue:text}`b.told.3` mm on the bench; depths between bent states
# {glue:text}`b.found.deflected` % off, from 100 mm {glue:text}`b.found.baseline` %. By
# boards {glue:text}`b.board.refused` seeds are refused before the end on the bench, so
# that what needs all stages of that has no value on B.
#
# **Limits.** Drawn features have the errors of corners, and no wrong matches. Where the
# mirror's edges are in each picture is known exactly, with SIFT as well. Where the
# near features lie and how features cluster, the thesis does not say. The ends of the
# bench's sweep are run with {glue:text}`swept.seeds` seeds each: enough to tell a
# verdict that turns over, too few for a share. Claims are held against
# {glue:text}`seeds` seeds of three pushes and carry the mark of few seeds; that errors
# do not accumulate, against {glue:text}`known.seeds` runs of eight steps.

# %% [markdown]
# ## Compared with the published numbers

# %% tags=["active-ipynb"]
# compared()

# %% [markdown]
# ## Try it yourself
#
# Open this page as a notebook (`make lab`) and run all cells. Then put an answer in
# place of `None`, and run that cell again. The answer to 1 may be 2 % off, that to 2
# 3 %.
#
# **1.** The camera is 400 mm before the mirror, the scene 4 m. How many mm of a push of
# 5 mm does the linear stage find?

# %% tags=["active-ipynb"]
# check(None, **bias_task())

# %% [markdown]
# **2.** Two states are 5 mm apart, across the line of sight. A ray is off by a pixel,
# 0.008°. By how many mm is the depth of a point at 4 m off?

# %% tags=["active-ipynb"]
# check(None, **depth_task())
