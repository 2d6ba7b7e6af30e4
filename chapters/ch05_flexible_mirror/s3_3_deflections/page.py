# %% [markdown]
# # 5.3.3b Three deflections
#
# **Question.** A flexible mirror, clamped at one edge, is pushed three times by 5 mm.
# Each time its shape is updated from two images of one chessboard. How accurate are the
# deflections found, and the camera's rays at the end?

# %%
from functools import partial

from chapters.ch05_flexible_mirror.s3_3_deflections.exercises import (
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
# 1. **The deflection is recovered.** All three estimates are within 10 % in
#    {glue:text}`share.deflections:.0f` % of the completed runs.
# 2. **The linear estimate is too small.** It finds somewhat more than the share
#    $Z/(Z+D)$ of each deflection.
# 3. **The rays degrade.** Their error against the *true* rays rises from
#    {glue:text}`angle.0:.2f`° at stage 0 to {glue:text}`angle.3:.2f`° at stage 3.
# 4. **A fitted pose hides ray errors.** In the board's true pose the back-projection
#    error is {glue:text}`true.1:.2f` mm at stage 1 and {glue:text}`true.3:.2f` mm at
#    stage 3.

# %% [markdown]
# | median at the primary level | thesis | here |
# |---|---|---|
# | largest error of the deflections | 7.76 % | {glue:text}`s5_3_3_maxdef:.1f` % |
# | linear estimate of 5 mm, stage 1 | 2.69 mm | {glue:text}`t5_1_s1_linear:.2f` mm |
# | angle to measured rays, stage 0 | 0.19° | {glue:text}`t5_3_s0_mean:.2f`° (set) |
# | angle to measured rays, stage 3 | 0.23° | {glue:text}`t5_3_s3_mean:.2f`° |
# | back-projection, stage 1 | 0.52 mm | {glue:text}`t5_4_s1_bp_mean:.2f` mm |
# | back-projection, stage 3 | 0.42 mm | {glue:text}`t5_4_s3_bp_mean:.2f` mm |

# %% [markdown]
# ## Terms
#
# - *Stage* 0: the flat mirror. Stages 1 to 3: after each push.
# - *Scene ray*: reflection of a *viewing ray* of the camera.
# - *Run*: one simulated experiment. It is *rejected* if no corner constrains an end of
#   the mirror, otherwise *completed*.
# - *Error levels*: *second solved* (primary), *first solved*, *low-noise*
#   ([5.3.3a](s3_3_calibration.ipynb)). *Set*: the level was chosen for this value.
# - *Rigs*: *A* (primary), *B* (shorter mirror), *C* (longer mirror).
# - *Active grid*: phase-shift structured light on a monitor, which the camera sees in
#   the *platter*, a flat reference mirror.
# - $Z$, $D$: distances from the mirror to the board and to the camera.
# - *Residual*: distance of a corner from its scene ray after the fit.
# - *Back-projection error*: distance between a corner of another board, in a *fitted*
#   or its *true* pose, and where its scene ray meets the board.

# %% [markdown]
# ## What the thesis claims
#
# - Deflections are within 7.76 % of 5 mm. Linear estimates are too small, mainly
#   because the board is near (Table 5.1).
# - The monitor's travel of 100 mm is found as 100.12 to 101.29 mm (Table 5.2).
# - The ray error grows only slightly (Table 5.3). It is smallest at the clamped edge
#   and largest at the others (Fig. 5.11).
# - The estimate at the load depends on the spline.
# - High curvature rotates the scene ray strongly for a small shift of its origin.
# - Calibration removes most of the back-projection error. The rest is largest along a
#   free edge (Fig. 5.12) and about constant (Table 5.4).

# %% [markdown]
# ## Model
#
# **Linear step.** The scene rays keep their directions (5.28), as if the board were
# infinitely far away. The normals bisect them and the new viewing rays, and the surface
# follows linearly.
#
# **Final step.** The surface $S'$ is refined until scene rays $V_r'$ pass through the
# corners $P$, known from the image before:
#
# $$ \Gamma(S') = \left\| \left[V_r' \cdot (P - S')\right] V_r' + S' - P
# \right\| . \tag{5.29} $$
#
# The board's pose comes from the previous calibration. Each update inherits its error.

# %% tags=["active-ipynb"]
# show_code(of_deflection)

# %% [markdown]
# **Measures.** The thesis fits the pose of the back-projected board with the calibrated
# camera itself, which absorbs what all ray errors have in common. Angles to *measured*
# rays contain the error of that measurement.

# %% [markdown]
# ## Experiment
#
# Each run draws board poses, monitor positions, and errors of corners and decoded
# points as measured in rendered images. The board is 260 mm from the mirror, in another
# pose at each push. Rays are measured with an active grid in two positions, and a board
# at 400 mm is back-projected. The method is as published: 7 × 3 spline functions of the
# distances along viewing rays, fixed clamp position.
#
# At stage 0 the measured rays come from the primary calibration's grids. New grids, and
# rig C, are other interpretations.


# %%
SEEDS = {"quick": 2, "full": 100}
FEWER = {"quick": 1, "full": 20}


@experiment(
    "table_5_1_runs",
    artefact="table_5_1",
    inputs=GEOMETRY_A,
    needs=("sec_5_3_3_errors",),
)
def runs(effort, results):
    """Rig A, at all error levels."""
    return bench_plan(results, on_each(by_code(three_stages)), BENCHES, SEEDS[effort])


@experiment(
    "table_5_1_swept",
    artefact="table_5_1",
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

# %% [markdown]
# ## From images to rays
#
# In a few runs all images are rendered and decoded. Only nine points at the clamp are
# picked by hand.

# %% tags=["active-ipynb"]
# show_table("ext_mirror_rendered_table")

# %% [markdown]
# ## Discussion
#
# **What holds.** The deflection is correct although the linear estimate is not. The
# share $Z/(Z+D)$ supports the thesis's explanation. It follows from chosen distances
# (E-5.19). The simulated errors of the platter
# determine how well the monitor's travel is recovered.
#
# **What does not hold.** The ray error is smallest along the clamp in most runs at
# stages 0 and 1, but in fewer than half at stage 3. The published method does not fix
# the slope there. Calibration leaves about a third of the back-projection error,
# which is the mirror's unevenness.
#
# **Extrapolation.** The deflection found at the load scatters more than among the
# corners. The *position* does not, since most of its error is common to the whole
# mirror.
#
# **Rejected runs.** Claims are judged on completed runs. Rejecting splines that bend
# implausibly at an end, as the library does, is another interpretation.
#
# **Limits.** With redrawn errors the visible corners, their indices and the mirror's
# edges are given.

# %% [markdown]
# ## Summary
#
# The deflection of the mirror is recovered, from a linear estimate that is too small
# for a geometric reason. The rays degrade, because each update inherits the error of
# the one before. Back-projection with a fitted pose does not show this, and the
# residual shows only a part.

# %% [markdown]
# ## Compared with the published numbers

# %% tags=["active-ipynb"]
# compared()

# %% [markdown]
# ## Try it yourself
#
# Open this page as a notebook (`make lab`) and run all cells. Then put an answer in
# place of `None`, and run that cell again. The answer to 1 may be 3 % off.
#
# **1.** The board is 260 mm from the mirror, the camera {glue:text}`camera:.0f` mm. How
# many mm of a deflection of 5 mm does the linear estimate find, by $Z/(Z+D)$?

# %% tags=["active-ipynb"]
# check(None, **linear_task())

# %% [markdown]
# **2.** A scene ray has an error of 0.2°. By how many mm does it miss a board that
# faces it at 400 mm? Compare with Table 5.4.

# %% tags=["active-ipynb"]
# check(None, **ray_task())
