# %% [markdown]
# # 5.3.3b Three deflections
#
# **Question.** Does a camera with a flexible mirror stay accurate while the mirror is
# bent and recalibrated three times? The mirror is clamped at one edge, and its free
# edge is pushed by 5 mm, three times. After each push its shape is updated from two
# images of one chessboard. How accurate are the deflections found, and the camera's
# rays at the end?

# %%
from functools import partial

from chapters.ch05_flexible_mirror.s3_3_deflections.exercises import (
    depth_task,
    linear_task,
    ray_task,
)
from chapters.ch05_flexible_mirror.s3_3_deflections.experiment import (
    RunSizes,
    of_deflection,
    one_push,
    rendered_trial,
    three_stages,
)
from chapters.ch05_flexible_mirror.s3_3_deflections.report import name_values
from chapters.shared.mirror import (
    BENCHES,
    GEOMETRY_A,
    GEOMETRY_B,
    GEOMETRY_C,
    LEVEL,
    SWEEP,
    UNSEEN,
    bench_plan,
    by_code,
    on_each,
)
from repro.page import (
    check,
    compared,
    open_results,
    show,
    show_code,
    show_table,
    values,
)
from repro.run import Plan, experiment

# %% tags=["active-ipynb"]
# show("fig_5_12")

# %% tags=["active-ipynb", "remove-input"]
# name_values(open_results)
# values()

# %% [markdown]
# **Findings.**
#
# 1. **The deflection is recovered.** All three final estimates are within 10 % in
#    {glue:text}`share.deflections:.0f` % of the completed runs.
# 2. **The linear estimate is too small.** It finds a share of about $Z/(Z+D)$ of each
#    deflection. The cause is geometric.
# 3. **The rays degrade.** Their error against the *true* rays is
#    {glue:text}`angle.0:.2f`° after the primary calibration and
#    {glue:text}`angle.3:.2f`° after three updates.
# 4. **A fitted pose hides ray errors.** In the board's true pose the back-projection
#    error is {glue:text}`true.1:.2f` mm at stage 1 and {glue:text}`true.3:.2f` mm at
#    stage 3.

# %% [markdown]
# | median at the primary level | thesis | here |
# |---|---|---|
# | largest error of the deflections | 7.76 % | {glue:text}`s5_3_3_maxdef:.1f` % |
# | linear estimate of 5 mm, stage 1 | 2.69 mm | {glue:text}`t5_1_s1_linear:.2f` mm |
# | linear estimate of 5 mm, stage 3 | 3.10 mm | {glue:text}`t5_1_s3_linear:.2f` mm |
# | angle to measured rays, stage 0 | 0.19° | set to the thesis's value |
# | angle to measured rays, stage 3 | 0.23° | {glue:text}`t5_3_s3_mean:.2f`° |
# | back-projection, stage 1 | 0.52 mm | {glue:text}`t5_4_s1_bp_mean:.2f` mm |
# | back-projection, stage 3 | 0.42 mm | {glue:text}`t5_4_s3_bp_mean:.2f` mm |

# %% [markdown]
# ## Terms
#
# - *Stage* 0: the flat mirror. Stages 1 to 3: after each push.
# - *Viewing ray*: from camera to mirror. *Scene ray*: its reflection.
# - *Run*: one simulated experiment. It is *rejected* if no corner constrains an end of
#   the mirror, otherwise *completed*.
# - *Error levels*: *second solved* (primary), *first solved*, *low-noise*
#   ([5.3.3a](s3_3_calibration.ipynb)).
# - *Rig A*: the primary simulated set-up. *Rig C*: with a longer mirror.
# - *Active grid*: phase-shift structured-light target on a monitor.
# - *Platter*: flat reference mirror that shows the monitor to the camera.
# - $Z$, $D$: distances from the mirror to the board and to the camera.
# - *Residual*: distance of a corner from its scene ray after the fit.
# - *Back-projection error*: distance between a corner of another board and the point
#   where its scene ray meets that board.

# %% [markdown]
# ## What the thesis claims
#
# - Final deflections are within 7.76 % of 5 mm. Linear estimates are too small, mainly
#   because the board is nearer than 300 mm (Table 5.1).
# - The monitor's travel of 100 mm is found as 100.12 to 101.29 mm (Table 5.2).
# - The ray error after three deflections is "only marginally greater" than at first
#   (Table 5.3). It is smallest at the clamped edge and largest at the others (Fig.
#   5.11).
# - The load acts beyond the last corner, so the estimate there depends on the spline.
# - Where the curvature is high, a small shift of the reflection point rotates the scene
#   ray strongly.
# - Calibration removes most of the back-projection error. The rest is largest along a
#   free edge (Fig. 5.12). Errors and residuals stay about constant (Table 5.4).

# %% [markdown]
# ## Model
#
# **Linear step.** The scene rays are assumed to keep their directions (5.28), as if the
# board were infinitely far away. The normals bisect them and the new viewing rays, and
# the surface follows linearly from the normals.
#
# **Final step.** The surface $S'$ is refined until scene rays $V_r'$ pass through the
# corners $P$, known from the image before the deflection:
#
# $$ \Gamma(S') = \left\| \left[V_r' \cdot (P - S')\right] V_r' + S' - P
# \right\| . \tag{5.29} $$
#
# The board's pose comes from the previous calibration. Each update inherits its error,
# and the residual does not show it.

# %% tags=["active-ipynb"]
# show_code(of_deflection)

# %% [markdown]
# **Measures.** The thesis finds the pose of the back-projected board with the
# calibrated camera itself. Such a fitted pose absorbs what all ray errors have in
# common. Angles to *measured* rays also contain the error of that measurement. The
# simulation also knows the true pose and the *true* rays.

# %% [markdown]
# ## Experiment
#
# Each run draws board poses, monitor positions, and errors of corners and decoded
# points as measured in rendered images. The board is 260 mm from the mirror, in another
# pose at each push. At least ninety corners are visible before and after. After each
# push an active grid in two positions measures rays, and a board at 400 mm is
# back-projected. The method is as published: distances along viewing rays, 7 × 3 spline
# functions, fixed clamp position.
#
# At stage 0 the rays are measured with the grids of the primary calibration, as Table
# 5.2 suggests. New grids there are another interpretation, and rig C is a third.


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
    """Rig A, at all error levels."""
    return bench_plan(results, on_each(by_code(three_stages)), BENCHES, SEEDS[effort])


@experiment(
    "table_5_1_swept",
    artefact="table_5_1",
    shards={"full": 2},
    inputs=GEOMETRY_A,
    needs=("sec_5_3_3_errors",),
)
def swept(effort, results):
    """Rig A, from half to twice the primary level's numbers."""
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
    """Rig B, at all error levels."""
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
    """Rig C, at the primary level."""
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
# At quick size one step in small images, and fewer of them.
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
    """Images of every kind, rendered, decoded and calibrated."""
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
    """Movement at the load and among the corners, at all error levels."""
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
# The runs above redraw measured errors. A few further runs redraw nothing: all images
# are rendered, corners detected and monitor images decoded. Only nine points at the
# clamp are picked by hand.

# %% tags=["active-ipynb"]
# show_table("ext_mirror_rendered_table")

# %% [markdown]
# ## Discussion
#
# **What holds.** The deflection is correct although the linear estimate is far too
# small. The share $Z/(Z+D)$ supports the thesis's explanation, the nearness of the
# board. Its value follows from the chosen distances, since the thesis gives no $D$ and
# two values of $Z$ (E-5.19). The monitor's travel is recovered, but the simulated
# placement errors of the platter determine how well.
#
# **What does not hold.** The ray error is smallest along the clamp at the first stages
# only. The published method fixes the clamp's position and not its slope. Only corners
# next to the clamp constrain the slope, and a more bent mirror shows fewer of them. At
# stage 3 calibration leaves a large share of the back-projection error that the
# deflection caused: unevenness that the spline cannot follow.
#
# **Extrapolation.** The deflection found at the load scatters more from run to run than
# among the corners, and a few runs cause most of it. The *position* found there does
# not, since most of its error comes from the platter and is common to the whole mirror.
#
# **Rejected runs.** Claims are judged on completed runs, with the share of rejected
# runs next to them. The claim on linear estimates also counts stages that are rejected
# later. The library further rejects splines that bend implausibly at an end, which the
# thesis does not, so this is another interpretation.
#
# **Limits.** Runs with redrawn errors know which corners are visible, their indices,
# and the mirror's edges. Runs from images are few. The unevenness moves with the sheet
# and is the same at all stages.

# %% [markdown]
# ## Summary
#
# The deflection of the mirror is recovered, from a linear estimate that is too small
# for a geometric reason. The rays degrade over three updates, because each update
# inherits the error of the one before. Neither the residual nor back-projection with a
# fitted pose measures this error.

# %% [markdown]
# ## Compared with the published numbers

# %% tags=["active-ipynb"]
# compared()

# %% [markdown]
# ## Try it yourself
#
# Open this page as a notebook (`make lab`) and run all cells. Then put an
# answer in place of `None`, and run that cell again. Answers to 1 and 2 have a
# tolerance of 3 %.
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
# **3.** A scene ray has an error of 0.2°. By how many mm does it miss a board that
# faces it at 400 mm? Compare with the back-projection errors of Table 5.4.

# %% tags=["active-ipynb"]
# check(None, **ray_task())
