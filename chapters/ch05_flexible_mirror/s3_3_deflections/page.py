# %% [markdown]
# # 5.3.3 Three deflections, stage by stage
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
from chapters.ch05_flexible_mirror.s3_3_deflections.trials.pictures import RunSizes
from chapters.ch05_flexible_mirror.s3_3_deflections.trials.rendered import (
    rendered_trial,
)
from chapters.ch05_flexible_mirror.s3_3_deflections.trials.run import (
    of_deflection,
    three_stages,
)
from chapters.ch05_flexible_mirror.s3_3_deflections.trials.tip import one_push
from chapters.shared.mirror_bench import BENCHES, LEVEL
from chapters.shared.mirror_files import GEOMETRY_A, GEOMETRY_B, GEOMETRY_C
from chapters.shared.mirror_plans import SWEEP, UNSEEN, bench_plan, on_each
from chapters.shared.mirror_rejections import by_code
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
# - The deflection at the load is found. The worst of the three final estimates is off
#   by {glue:text}`worst:.1f` % (median; the thesis has 7.76 %), and all three are
#   within 10 % in {glue:text}`share.deflections:.0f` % of the completed runs.
# - Every linear estimate is too small: {glue:text}`linear.1:.2f`,
#   {glue:text}`linear.2:.2f` and {glue:text}`linear.3:.2f` of 5 mm. The share is about
#   $Z/(Z+D)$, with the board $Z$ and the camera $D$ from the mirror.
# - Rays are {glue:text}`angle.0:.2f`° off the true ones after the primary stage and
#   {glue:text}`angle.3:.2f`° after three deflections. Compared with *measured* rays, as
#   in the thesis, it is {glue:text}`measured.0:.2f`° and {glue:text}`measured.3:.2f`°.
# - Back-projection in the pose that the camera finds is {glue:text}`back.1:.2f` mm at
#   stage 1 and {glue:text}`back.3:.2f` mm at stage 3. In the board's true pose it is
#   {glue:text}`true.1:.2f` and {glue:text}`true.3:.2f` mm.

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
# - The load is nearer to the edge than any corner, so that the estimate there
#   depends on the spline between and beyond them.
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
# Every seed draws boards, positions of the monitor and errors of corners and decoded
# points, which are as in rendered pictures ([calibration](s3_3_calibration.ipynb)). The
# mirror goes from 0 to 15 mm in three pushes; the board stands 260 mm from the mirror,
# held by hand in another place at each. Ninety corners or more are seen both before and
# after. After each push an active grid in two positions measures rays, and a board at
# 400 mm is back-projected. The method is the published one: distances along viewing
# rays, 7 x 3 functions, the clamp's position held. All is run at the three error levels
# of [5.3.3](s3_3_calibration.ipynb), with the same draws; the second one decides.
#
# At stage 0 rays are measured with the grids of the primary stage, between the pixels
# that it was fitted to, as Table 5.2 suggests: it has stages 1 to 3 only. Grids that
# are placed anew there are another interpretation of the text. A longer mirror,
# geometry C, is a third.


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
    """Geometry A, at all levels."""
    return bench_plan(results, on_each(by_code(three_stages)), BENCHES, SEEDS[effort])


@experiment(
    "table_5_1_swept",
    artefact="table_5_1",
    shards={"full": 2},
    inputs=GEOMETRY_A,
    needs=("sec_5_3_3_errors",),
)
def swept(effort, results):
    """Geometry A, from half to twice the primary level's numbers."""
    return bench_plan(
        results, on_each(by_code(three_stages)), SWEEP[effort], FEWER[effort]
    )


@experiment(
    "table_5_1_other",
    artefact="table_5_1",
    inputs=GEOMETRY_B,
    needs=("sec_5_3_3_errors",),
)
def other(effort, results):
    """Geometry B, at all levels."""
    return bench_plan(
        results, on_each(by_code(three_stages)), BENCHES, FEWER[effort], "B"
    )


@experiment(
    "table_5_1_longer",
    artefact="table_5_1",
    inputs=GEOMETRY_C,
    needs=("sec_5_3_3_errors",),
)
def longer(effort, results):
    """Geometry C, at the primary level."""
    level = {LEVEL: BENCHES[LEVEL]}
    return bench_plan(
        results, on_each(by_code(three_stages)), level, FEWER[effort], "C"
    )


RUNS_FROM_IMAGES = (
    {"geometry": "A", "bench": "bench", "run": 0},
    {"geometry": "A", "bench": "bench", "run": 1},
    {"geometry": "A", "bench": "bench", "run": 2},
    {"geometry": "A", "bench": "laboratory", "run": 0},
    {"geometry": "B", "bench": "bench", "run": 0},
    {"geometry": "B", "bench": "laboratory", "run": 0},
)
# At quick size one step in small pictures, and fewer of them.
SIZES = {"quick": RunSizes(1, 3, 5, True), "full": RunSizes(3, 8, 36, False)}


@experiment(
    "table_5_1_rendered",
    artefact="ext_mirror_rendered_table",
    shards={"full": 6},
    inputs=(
        "data/rigs/flexible-mirror-a.yaml",
        "data/rigs/flexible-mirror-a-monitor.yaml",
        "data/rigs/flexible-mirror-b.yaml",
        "data/rigs/flexible-mirror-b-monitor.yaml",
        "data/rigs/flexible-mirror-a-small.yaml",
        "data/rigs/flexible-mirror-a-monitor-small.yaml",
    ),
)
def rendered(effort):
    """Pictures of every kind, rendered, read and calibrated."""
    runs = RUNS_FROM_IMAGES if effort == "full" else RUNS_FROM_IMAGES[:1]
    sizes = SIZES[effort]
    settings = sizes._asdict() | {k: bench._asdict() for k, bench in BENCHES.items()}
    trial = partial(rendered_trial, sizes=sizes)
    return Plan(trial, list(runs), 1, settings, UNSEEN)


@experiment(
    "exp_c5_extrapolated_tip",
    artefact="table_5_1",
    inputs=GEOMETRY_A,
    needs=("sec_5_3_3_errors",),
)
def tips(effort, results):
    """How far the mirror went at the load and among the corners, at all levels."""
    return bench_plan(results, on_each(by_code(one_push)), BENCHES, SEEDS[effort])


@experiment(
    "exp_c5_extrapolated_tip_swept",
    artefact="table_5_1",
    inputs=GEOMETRY_A,
    needs=("sec_5_3_3_errors",),
)
def tips_swept(effort, results):
    """The same from half to twice the primary level's numbers."""
    return bench_plan(results, on_each(by_code(one_push)), SWEEP[effort], FEWER[effort])


# %% [markdown]
# ## Further figures

# %% tags=["active-ipynb"]
# show_table("table_5_1")

# %% tags=["active-ipynb"]
# show_table("table_5_2")

# %% tags=["active-ipynb"]
# show_table("table_5_3")

# %% tags=["active-ipynb"]
# show("fig_5_11")

# %% tags=["active-ipynb"]
# show_table("table_5_4")

# %% tags=["active-ipynb"]
# show_table("ext_deflections_swept")

# %% [markdown]
# ## From images to rays
#
# The runs above redraw measured errors of corners and decoded points. In
# {glue:text}`pictures.runs` runs nothing is redrawn: boards, monitor and platter are
# rendered, corners are found by the detector and numbered from the clamp, and the
# monitor is decoded in 36 bands of 16 rows. Only nine points at the clamp are picked by
# hand. Corners are off by {glue:text}`pictures.corner_px:.2f` px (median), and
# {glue:text}`pictures.false` are false. The table compares both kinds of runs.

# %% tags=["active-ipynb"]
# show_table("ext_mirror_rendered_table")

# %% [markdown]
# ## Reading and limits
#
# **What survives.** The deflection is right, from a linear estimate that is far too
# small. The bias comes from the nearness of the scene. The monitor's travel is found to
# {glue:text}`shift.most:.1f` mm and {glue:text}`turn.most:.1f`° in the worst of four
# stages. At the second level that is no finding: the platter's errors, which are put
# in, determine it.
#
# **What does not.** Error is least along the clamp at the first stages only: at stage 3
# it is {glue:text}`clamped:.2f`° there and {glue:text}`free:.2f`° along the free edges.
# The published method holds the position of the clamp and not its slope. Only the
# corners next to the clamp constrain the slope, and the more the mirror is bent, the
# fewer corners are seen there. A calibration leaves {glue:text}`left:.2f` of the
# back-projection error that the deflection to stage 3 caused: unevenness that the
# spline cannot follow.
#
# **The deflection is read where it is known worst.** The load acts
# {glue:text}`tip.beyond:.0f` mm beyond the last corner. From seed to seed the estimate
# there scatters {glue:text}`tip.ratio:.1f` times as much as among the corners,
# {glue:text}`tip.load:.0f` against {glue:text}`tip.among:.0f` µm (SD). A few seeds
# cause most of it. That concerns how far the mirror *moved*. Where it *is* scatters
# {glue:text}`tip.surface:.2f` times as much, since most of that error is one of the
# whole mirror, from the platter.
#
# **The linear estimate.** The camera is {glue:text}`camera:.0f` mm from the middle of
# the mirror on A, and $Z/(Z+D)$ is {glue:text}`formula:.2f`. Ratios of 0.54 to 0.65
# need a board {glue:text}`depth.low:.0f` to {glue:text}`depth.high:.0f` mm from the
# mirror. The thesis says less than 300 mm in one place and about 400 mm in another
# (E-5.19). So its camera may have been near to its mirror; how near, it does not state.
# What share comes out here is thereby chosen, and not compared. That the share is below
# one is judged on all linear stages, also on those of stages that were rejected later.
# The largest of all is {glue:text}`linear.most:.2f`.
#
# **Rejected runs.** {glue:text}`refused` of {glue:text}`seeds` runs are rejected before
# stage 3, since no corner is left at an end of the mirror. At the low-noise level it is
# {glue:text}`lab.refused`, on geometry B, whose mirror is short and near,
# {glue:text}`b.refused` of {glue:text}`b.seeds`. A rejected run is not a miss: claims
# are judged on completed runs, with the share of rejected ones next to it. In
# {glue:text}`swinging` more runs the spline bends at an end as no sheet does: its rays
# there would turn by 5° or more if it bent evenly. The library rejects these. The
# thesis's method has no such test, and with the test the verdicts are another
# interpretation. The rays of the completed runs on B are {glue:text}`b.angle.3`° off at
# stage 3.
#
# **Limits.** The runs with redrawn errors know exactly which corners the mirror shows,
# which is which, and where its edges are. The runs from images are few. The clamp's
# line is picked by hand to half a pixel. The waves are the same at all stages, as the
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
