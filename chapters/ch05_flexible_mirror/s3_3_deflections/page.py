# %% [markdown]
# # 5.3.3 Three deflections: is the mirror found where it went?
#
# **Question.** A mirror is pushed three times by 5 mm, and calibrated after
# each push from two pictures of a chessboard. How far does the calibration say
# that it went, and how far are the camera's rays off after that?

# %%
from functools import partial

from chapters.ch05_flexible_mirror.s3_3_deflections.exercises import (
    depth_task,
    linear_task,
    ray_task,
)
from chapters.ch05_flexible_mirror.s3_3_deflections.results.prose import name_values
from chapters.ch05_flexible_mirror.s3_3_deflections.trials.run import (
    deflections_trial,
    of_deflection,
)
from chapters.ch05_flexible_mirror.s3_3_deflections.trials.tip import tip_trial
from chapters.shared.mirror_bench import BENCHES, SWEPT
from chapters.shared.mirror_errors import MirrorErrors
from chapters.shared.mirror_files import GEOMETRY_A, GEOMETRY_B
from repro.page.exercise import check
from repro.page.reader import compared, open_results, show, show_code, show_table
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

# %% tags=["active-ipynb"]
# show("fig_5_12")

# %% tags=["active-ipynb", "remove-input"]
# name_values(open_results)

# %% [markdown]
# **Findings.**
#
# - At the load the mirror is found where it went. On the bench the final
#   estimates of the three pushes are off by {glue:text}`off.1:.1f`,
#   {glue:text}`off.2:.1f` and {glue:text}`off.3:.1f` % (medians), the worst of
#   the three by {glue:text}`worst:.1f` %; the thesis has 7.76 %. They are all
#   within 10 % in {glue:text}`share.deflections:.0f` % of
#   {glue:text}`seeds` seeds. {glue:text}`refused` were refused before they came
#   through, {glue:text}`swinging` of them since the spline would swing at an end
#   of the mirror, the others since no corner was left there.
# - The linear estimate finds {glue:text}`linear.1:.2f`,
#   {glue:text}`linear.2:.2f` and {glue:text}`linear.3:.2f` of 5 mm on geometry
#   A, {glue:text}`b.linear.1:.2f` at stage 1 on B; the thesis 0.54 to 0.62. How
#   much, is a matter of distances: about $Z/(Z+D)$.
# - Rays do get worse. To the true rays it is {glue:text}`angle.0:.2f`° after the
#   primary stage and {glue:text}`angle.3:.2f`° after three deflections,
#   {glue:text}`growth:.1f` times as much; in the laboratory
#   {glue:text}`lab.angle.0:.3f`° and {glue:text}`lab.angle.3:.3f`°. To *measured*
#   rays, which the thesis compares with, the bench has
#   {glue:text}`measured.0:.2f`° and {glue:text}`measured.3:.2f`°: the measuring
#   error hides the growth.
# - Back-projection error with the pose that the camera finds is
#   {glue:text}`back.1:.2f` mm at stage 1 and {glue:text}`back.3:.2f` mm at stage
#   3, the residual {glue:text}`residual.1:.2f` and {glue:text}`residual.3:.2f` mm.
#   Onto the board's true pose it grows from {glue:text}`true.1:.2f` to
#   {glue:text}`true.3:.2f` mm.
# - A calibration leaves {glue:text}`left:.2f` of the back-projection error
#   that the deflection to stage 3 made, {glue:text}`lab.left:.2f` in the
#   laboratory: what the spline cannot follow is left.
# - The deflection is read where it is known worst: the load acts
#   {glue:text}`tip.beyond:.0f` mm beyond the last corner. From seed to seed what
#   is found there scatters {glue:text}`tip.ratio:.1f` times as much as among the
#   corners, {glue:text}`tip.load:.0f` against {glue:text}`tip.among:.0f` µm (SD).

# %% [markdown]
# ## What the thesis claims
#
# - Final estimates of the three deflections are within 7.76 % of 5 mm. The
#   linear ones are far too small, 2.69 to 3.10 mm, mostly since the board was
#   less than 300 mm from the mirror (Table 5.1).
# - The two positions of a monitor, found by its reflection in a platter, are
#   100.12 to 101.29 mm apart and turned by 0.33° at most; its stage travelled
#   100 mm (Table 5.2).
# - After three deflections rays are 0.23° from measured ones, "only marginally"
#   more than the 0.19° of the primary stage (Table 5.3). They differ least along
#   the clamped edge, most along the others (Fig. 5.11).
# - The load is nearer to the edge than any corner, so that what is found there
#   hangs on the spline between and beyond them.
# - Where the mirror is much curved, a small shift of the reflection point turns
#   the scene ray a lot, and errors on another board cannot be compared.
# - Most of the back-projection error of a deflection is gone after calibration.
#   What is left is largest along a free edge (Fig. 5.12). Back-projection error
#   and residual stay about the same at all stages (Table 5.4).

# %% [markdown]
# ## Model
#
# **Two steps.** *Linear*: the scene rays are taken to be those of before the
# deflection (5.28), as if the board were infinitely far away. Half way between
# them and the new viewing rays lie the normals, to which the surface fits
# linearly. *Final*: from there the surface is moved until scene rays pass the
# corners, whose places are known from the picture before,
#
# $$ \Gamma(S') = \left\| \left[V_r' \cdot (P - S')\right] V_r' + S' - P
# \right\| . \tag{5.29} $$
#
# The board's pose comes from the calibration before the deflection. So its
# error is carried on, and the residual does not show it.

# %% tags=["active-ipynb"]
# show_code(of_deflection)

# %% [markdown]
# **Four measures.** A *residual* is the distance of a corner from its scene
# ray after the fit. *Back-projection* is the distance, on another board,
# between a corner and the point where its ray meets the board. The thesis finds
# that board's pose with the same calibrated camera. A pose can make up for much
# that is wrong with rays: the shift and turn that all have in common. Here the
# true pose is known, and back-projection onto it is printed beside. *Angles to
# measured rays* hold the measuring error as well, that of an active grid in two
# places. Angles to the *true* rays are what counts.

# %% [markdown]
# ## Experiment
#
# Every seed draws boards, positions of the monitor and errors of corners and
# decoded points, which are as in rendered pictures
# ([calibration](s3_3_calibration.ipynb)). The mirror goes from 0 to 15 mm in
# three pushes; the board stands 260 mm from the mirror, held by hand in another
# place at each. Ninety corners or more are seen both before and after. After each
# push an active grid in two positions measures rays, and a board at 400 mm is
# back-projected. The method is the published one: distances along viewing rays,
# 7 x 3 functions, the clamp's position held. All is run on the *bench* and in the
# *laboratory*, with the same draws; the bench decides.


# %%
SEEDS = {"quick": 2, "full": 100}
FEWER = {"quick": 1, "full": 20}


@experiment(
    "table_5_1_runs",
    artefact="table_5_1",
    shards={"full": 2},
    inputs=GEOMETRY_A,
    needs=("sec_5_3_3_errors",),
)
def runs(effort, results):
    """Geometry A, on both benches."""
    return _plan(results, "A", BENCHES, SEEDS[effort])


@experiment(
    "table_5_1_swept",
    artefact="table_5_1",
    shards={"full": 2},
    inputs=GEOMETRY_A,
    needs=("sec_5_3_3_errors",),
)
def swept(effort, results):
    """Geometry A, from half to twice each of the bench's numbers."""
    return _plan(results, "A", SWEPT, FEWER[effort])


@experiment(
    "table_5_1_other",
    artefact="table_5_1",
    inputs=GEOMETRY_B,
    needs=("sec_5_3_3_errors",),
)
def other(effort, results):
    """Geometry B, on both benches."""
    return _plan(results, "B", BENCHES, FEWER[effort])


def _plan(results, geometry, benches, seeds):
    errors = {geometry: MirrorErrors.read(results["sec_5_3_3_errors"], geometry)}
    trial = partial(deflections_trial, errors=errors, benches=benches)
    settings = {name: bench._asdict() for name, bench in benches.items()}
    return Plan(trial, [{"geometry": geometry}], seeds, settings)


@experiment(
    "exp_c5_extrapolated_tip",
    artefact="table_5_1",
    inputs=GEOMETRY_A,
    needs=("sec_5_3_3_errors",),
)
def tips(effort, results):
    """How far the mirror went at the load and among the corners, on both benches."""
    return _tip_plan(results, BENCHES, SEEDS[effort])


@experiment(
    "exp_c5_extrapolated_tip_swept",
    artefact="table_5_1",
    inputs=GEOMETRY_A,
    needs=("sec_5_3_3_errors",),
)
def tips_swept(effort, results):
    """The same from half to twice each of the bench's numbers."""
    return _tip_plan(results, SWEPT, FEWER[effort])


def _tip_plan(results, benches, seeds):
    errors = {"A": MirrorErrors.read(results["sec_5_3_3_errors"], "A")}
    trial = partial(tip_trial, errors=errors, benches=benches)
    settings = {name: bench._asdict() for name, bench in benches.items()}
    return Plan(trial, [{"geometry": "A"}], seeds, settings)


# %% [markdown]
# ## Further figures

# %% tags=["active-ipynb"]
# show_table("table_5_1")

# %% tags=["active-ipynb"]
# show("ext_linear_ratio")

# %% tags=["active-ipynb"]
# show_table("table_5_2")

# %% tags=["active-ipynb"]
# show_table("table_5_3")

# %% tags=["active-ipynb"]
# show("fig_5_11")

# %% tags=["active-ipynb"]
# show("ext_angles_by_place")

# %% tags=["active-ipynb"]
# show_table("table_5_4")

# %% tags=["active-ipynb"]
# show("ext_tip_scatter")

# %% tags=["active-ipynb"]
# show("ext_ray_turns")

# %% tags=["active-ipynb"]
# show_table("ext_deflections_other")

# %% tags=["active-ipynb"]
# show_table("ext_deflections_swept")

# %% [markdown]
# ## Reading and limits
#
# **What survives.** The deflection comes out right, from a linear estimate that
# is far too small: also here that bias is one of the scene's nearness, and not
# of the method's second step. The monitor's travel is found to
# {glue:text}`shift.most:.1f` mm and {glue:text}`turn.most:.1f`° in the worst of
# four stages. Both are properties of one place, or of rigid things.
#
# **What does not.** That rays are hardly worse after three deflections is what an
# active grid says that is itself wrong by more. That error is least along
# the clamp is true of the bench at the first stages, in the median; at stage 3
# it is {glue:text}`clamped:.2f`° there and {glue:text}`free:.2f`° along the free
# edges, and single seeds mostly have another order at one stage or more. The
# published method holds the position of the clamp and not its slope: which way
# the mirror leaves the clamp is said by the corners next to it alone, and the
# more the mirror is bent, the fewer corners are seen there. The largest
# errors sit along a free edge beyond chance in {glue:text}`share.edges:.0f` %
# of the seeds; waves lie anywhere on a mirror. The thesis's mirror was strained
# along its cut edges, which these mirrors are not.
#
# **What hangs on the tip.** The scatter at the load is that of a spline carried on
# over {glue:text}`tip.beyond:.0f` mm, in the laboratory
# {glue:text}`lab.tip.ratio:.1f` times that among the corners. On the bench a few
# seeds make most of it, and at the ends of the sweep, with fewer seeds, the ratio
# is {glue:text}`tip.least:.1f` to {glue:text}`tip.most:.1f`. The claim asks for two.
# All that is so of how far the mirror *went*. Where it *is* scatters
# {glue:text}`tip.surface:.2f` times as much at the load as among the corners, since
# most of that error is one of the whole mirror, from the platter.
#
# **Curvature.** A mirror that turns by an angle turns the scene ray by twice that,
# so that on 1 mm of it the ray turns by twice the curvature. With the viewing ray
# that belongs to each place it turns by more, {glue:text}`curved.least:.1f` to
# {glue:text}`curved.most:.1f` times that on geometry A: a flat mirror, too, shows
# another direction at another place.
#
# **Constant, or hidden?** On the bench back-projection and residual are nearly
# the same at all stages, since the waves of the mirror make most of both, and a
# stiff spline leaves them where they are. In the laboratory they grow, from
# {glue:text}`lab.back.1:.2f` to {glue:text}`lab.back.3:.2f` mm and from
# {glue:text}`lab.residual.1:.2f` to {glue:text}`lab.residual.3:.2f` mm: a mirror
# that is bent more is followed less well by 7 x 3 functions.
#
# **The linear estimate.** The camera is {glue:text}`camera:.0f` mm from the
# middle of the mirror on A, {glue:text}`b.camera:.0f` mm on B, and $Z/(Z+D)$ is
# {glue:text}`formula:.2f` and {glue:text}`b.formula:.2f`. Ratios of 0.54 to 0.65
# need a board {glue:text}`ratio.low:.1f` to {glue:text}`ratio.high:.1f` times
# as far from the mirror as the camera is, on A {glue:text}`depth.low:.0f` to
# {glue:text}`depth.high:.0f` mm; the thesis says less than 300 mm in one place
# and about 400 mm in another (E-5.19). So its camera was near to its mirror.
# B was chosen for that, and says nothing on it.
#
# **The bench's own test.** Its two numbers were solved from two printed ones.
# Of the others, angles to measured rays are {glue:text}`measured.0:.2f`° at
# stage 0, where the thesis has 0.19°, and back-projection is
# {glue:text}`back.0:.2f` mm for 0.56 mm. So decoding errors alone are not what
# put 0.86 mm between the thesis's rays, or its grid was read with less noise for
# reference. Claims that turn with the factor are left undecided.
#
# **Refused seeds count as failures**, also where the linear estimate is asked to
# be too small in 95 % of the runs. It is in all that went on: the largest found
# {glue:text}`linear.most:.2f` of a deflection on the bench and
# {glue:text}`lab.linear.most:.2f` in the laboratory, where
# {glue:text}`lab.refused` seeds were refused.
#
# **A shape that is wrong, with a residual that is right.** On B, whose mirror is
# short and near, stage 3 is at the end of what the method can do. On the bench
# {glue:text}`b.refused` of {glue:text}`b.seeds` seeds are refused.
# {glue:text}`b.swinging` of them have corners in all knot intervals, and
# residuals like those of other stages. But corners reach so little into the last
# interval that the spline goes on beyond them as their misfit says: rays at the
# end would turn by more than five degrees if the mirror bent there as evenly as a
# sheet does. In the thesis's method nothing tells these. Of the seeds that come
# through, the true rays at stage 3 are {glue:text}`b.angle.3`° off in the median,
# {glue:text}`b.lab.angle.3`° in the laboratory.
#
# **Limits.** Corners and decoded points are redrawn with errors from rendered
# pictures, they are not found again in pictures of every seed. Which corners the
# mirror shows, which is which, and where its edges are, these runs know exactly;
# [runs from pictures](s3_3_rendered.ipynb) do not, and are few. The clamp's line
# is picked by hand to half a pixel. The waves are the same at all stages, as the
# sheet carries them along.

# %% [markdown]
# ## Compared with the published numbers

# %% tags=["active-ipynb"]
# compared()

# %% [markdown]
# ## Try it yourself
#
# Open this page as a notebook (`make lab`) and run all cells. Then put an
# answer in place of `None`, and run that cell again. Answers to 1 and 2 may be
# 3 % off.
#
# **1.** The board is 260 mm from the mirror, the camera
# {glue:text}`camera:.0f` mm. How many mm of a deflection of 5 mm does the linear
# estimate find, by $Z/(Z+D)$?

# %% tags=["active-ipynb"]
# check(None, **linear_task())

# %% [markdown]
# **2.** How far from the mirror, in mm, would the board have to be for the
# linear estimate to find 60 % of the deflection?

# %% tags=["active-ipynb"]
# check(None, **depth_task())

# %% [markdown]
# **3.** A scene ray is 0.2° wrong. By how many mm does it miss a board that
# faces it at 400 mm? Compare with the back-projection errors of Table 5.4.

# %% tags=["active-ipynb"]
# check(None, **ray_task())
