# %% [markdown]
# # 5.3.3 The full model: primary calibration, and the error levels
#
# **Question.** Before a mirror is bent, its shape has to be known. How well is
# it found from two places of a monitor, and how much larger were the errors of
# the thesis's measurements than those of a clean laboratory?

# %%
from functools import partial

from chapters.ch05_flexible_mirror.s3_3_calibration.exercises import (
    fan_task,
    slope_task,
    unknowns_task,
)
from chapters.ch05_flexible_mirror.s3_3_calibration.results import name_values
from chapters.ch05_flexible_mirror.s3_3_calibration.trials.bench import (
    AMPLITUDES_UM,
    FACTORS,
    SEEDS,
    first_trial,
    second_trial,
)
from chapters.ch05_flexible_mirror.s3_3_calibration.trials.errors import (
    GEOMETRIES,
    RENDERED,
    SMALL,
    errors_trial,
)
from chapters.ch05_flexible_mirror.s3_3_calibration.trials.trust import trust_trial
from chapters.ch05_flexible_mirror.s3_3_calibration.trials.views import (
    DEFLECTIONS_MM,
    displacement_trial,
    fan_trial,
    pictures_trial,
)
from chapters.shared.mirror_bench import BENCHES, FIRST, SECOND
from chapters.shared.mirror_errors import MirrorErrors
from chapters.shared.mirror_files import ALL_THREE, BOTH, GEOMETRY_A, SMALL_A
from chapters.shared.mirror_plans import UNSEEN
from raxel.calibration.mirror.primary_start import mirror_points
from repro.page.exercise import check
from repro.page.reader import compared, open_results, show, show_code, show_table
from repro.run.experiment import experiment
from repro.run.outcomes import Plan, crossed

# %% tags=["active-ipynb"]
# show("fig_5_10")

# %% tags=["active-ipynb", "remove-input"]
# name_values(open_results)

# %% [markdown]
# **Findings.**
#
# - Pushed by 15 mm, the mirror of geometry A shows a fan of
#   {glue:text}`fan.last:.1f`° in place of {glue:text}`fan.first:.1f`°,
#   {glue:text}`fan.ratio.a:.2f` times as wide; on geometries B and C it is
#   {glue:text}`fan.ratio.b:.2f` and {glue:text}`fan.ratio.c:.2f` times. The thesis
#   says about twice.
# - In a clean laboratory mirror points lie {glue:text}`miss.clean:.2f` mm from their
#   rays after the primary stage; the thesis has 0.86 mm. Decoding errors *alone* would
#   have to be {glue:text}`bench.factor:.2f` times as large for that. Most other
#   printed numbers contradict so large a factor.
# - A second error level starts from the angle and the back-projection error of stage 0:
#   {glue:text}`second.factor:.2f` times the decoding errors, a mirror uneven by
#   {glue:text}`second.aberration:.1f` µm, and a platter that is a little off its place.
#   The table below holds all 32 printed numbers against it.
# - What stays unexplained: the distance of mirror points from their rays
#   ({glue:text}`second.miss:.2f` mm for 0.86 mm), and the residuals of all stages
#   ({glue:text}`second.residual:.2f` mm at stage 1 for 0.68 mm).

# %% [markdown]
# ## What the thesis claims
#
# - A plastic mirror on a sheet of aluminium is clamped at one edge and pushed
#   at the other, in four stages 5 mm apart. A camera of 7.1 Mpixel looks at it
#   from near by.
# - At stage 3 the field of view is about twice that of stage 0 (Fig. 5.10).
# - The model has 7 functions along the mirror and 3 across, since it bends
#   along only (Fig. 5.9).
# - Viewing and scene rays of 1056 places pass each other at 0.86 mm on the mean.
#   The two positions of the monitor come out 99.73 mm apart and turned by
#   0.14°; the stage that moved it said 100 mm.
# - Rays of the calibrated mirror are 0.19° off those that were measured.

# %% [markdown]
# ## Model
#
# **The rig.** Nothing is said of where camera, mirror and monitor stood. So
# there are three geometries, and one sees how much depends on them: A, with a
# mirror of 160 mm in 370 mm; B, with one of 130 mm in 190 mm; and C, as A with a mirror
# of 212 mm. C was chosen after all printed numbers had been seen, by one of them alone:
# the rays turn by about as much as Table 5.3 prints. Every length
# stands in the rig's file with its reason. The sheet is bent as an *elastica*:
# it keeps its length, and the sine of its slope follows the bending moment. Its
# rulings are a little out of square.

# %% tags=["active-ipynb"]
# show("fig_5_8")

# %% [markdown]
# **The spline.** The distance of the mirror along viewing rays is a sum of
# products $f_i(u)\,g_j(v)$ of quadratic B-splines (5.4). Their knots span the
# mirror's picture, anew at every stage.

# %% tags=["active-ipynb"]
# show("fig_5_9")

# %% [markdown]
# **Primary calibration** (section 5.2.1). A monitor is seen in the mirror in two
# positions. Each pixel decodes a point of either; both together are its scene
# ray. Where the scene ray comes nearest to the viewing ray lies the mirror.
# The monitor's poses come from its picture in a flat mirror, a platter on a
# chessboard. The normals, half way between the rays, give the spline up to its
# size (5.15, 5.16), the mirror points give the size, and the distances of all
# decoded points from their scene rays are made small.

# %% tags=["active-ipynb"]
# show_code(mirror_points)

# %% [markdown]
# ## Experiment
#
# **Errors.** Pictures of boards, of the monitor in the mirror and in the
# platter, and of the platter's own board are rendered at full size, for both
# geometries. Corners are off by {glue:text}`corner_px:.3f` px (RMS), decoded
# points by {glue:text}`decoded_mm:.3f` mm, most of it the ripple that the
# monitor's gamma leaves (section 3.2.2). From these errors those of many seeds
# are drawn again: for a corner any that was measured, for a decoded point the
# bias of its place in the period and any of what is left.


# %%
@experiment(
    "sec_5_3_3_errors",
    artefact="sec_5_3_3",
    shards={"full": 2},
    inputs=(
        "data/rigs/flexible-mirror-a.yaml",
        "data/rigs/flexible-mirror-a-monitor.yaml",
        "data/rigs/flexible-mirror-b.yaml",
        "data/rigs/flexible-mirror-b-monitor.yaml",
        "data/rigs/flexible-mirror-a-small.yaml",
        "data/rigs/flexible-mirror-a-monitor-small.yaml",
        "data/rigs/flexible-mirror-b-small.yaml",
        "data/rigs/flexible-mirror-b-monitor-small.yaml",
    ),
)
def picture_errors(effort):
    """Errors of corners and decoded points in rendered pictures."""
    conditions = crossed(geometry=GEOMETRIES, small=[SMALL[effort]])
    return Plan(errors_trial, conditions, RENDERED[effort], {})


# %% [markdown]
# **Error levels.** What is said of the thesis's own measurements may depend on how
# clean the laboratory is. So claims about them are judged at three levels, each with
# the same random draws:
#
# - the *low-noise level*: errors as measured in rendered images, and a smooth mirror;
# - the *first solved level*: decoding errors times one factor, and a mirror made uneven
#   by four waves of 45 to 110 mm. The factor is solved from the mean distance of mirror
#   points from their rays (0.86 mm), the unevenness from the residual of stage 1
#   (0.68 mm);
# - the *second solved level*, which is the primary one: factor and unevenness solved
#   from the mean angle to measured rays (0.19°) and the mean back-projection error
#   (0.56 mm) of stage 0, with a platter whose mirror is off its place on the board by
#   0.2 mm and 0.06° each time that it is placed, and by 0.2 mm and 0.05° more at each
#   position of the monitor (standard deviations).
#
# Both pairs of numbers are solved on geometry A with the method as published, by runs
# that judge nothing, before any claim was run with them. The printed numbers that they
# are solved from are *set* and say nothing more. The form of the second level was
# chosen after all 32 printed numbers had been seen: how many of them it reaches
# describes the choice and tests nothing. A claim whose verdict differs between the
# levels is left undecided, and so is one whose estimate changes side between half and
# twice the second level's numbers.

# %% tags=["active-ipynb"]
# show("ext_mirror_bench")


# %%
@experiment(
    "bench_mirror",
    artefact="ext_mirror_bench",
    shards={"full": 2},
    inputs=GEOMETRY_A,
    needs=("sec_5_3_3_errors",),
)
def bench(effort, results):
    """How factor and amplitude act on the two numbers that they are solved from."""
    return _solving(results, first_trial, {}, FIRST, SEEDS[effort])


@experiment(
    "bench_mirror_second",
    artefact="ext_mirror_bench",
    shards={"full": 2},
    inputs=GEOMETRY_A,
    needs=("sec_5_3_3_errors",),
)
def second(effort, results):
    """The same of the second level, with a platter that is off its place."""
    return _solving(results, second_trial, {"level": SECOND}, SECOND, SEEDS[effort])


def _solving(results, trial, condition, level, seeds):
    errors = MirrorErrors.read(results["sec_5_3_3_errors"], "A")
    settings = {"factors": FACTORS[level], "amplitudes_um": AMPLITUDES_UM[level]}
    settings |= BENCHES[level]._asdict()
    return Plan(partial(trial, errors=errors), [condition], seeds, settings)


# %% tags=["active-ipynb"]
# show_table("ext_mirror_levels")


# %% [markdown]
# **What the mirror shows.** A bookcase in the mirror at each stage, the angle of
# the fan of rays of the mirror's middle line, and how far corners of a board
# move in the picture.


# %%
@experiment("fig_5_10_pictures", artefact="fig_5_10", inputs=SMALL_A)
def pictures(effort):
    """The room in the mirror."""
    stages = {"quick": [0, 3], "full": [0, 1, 2, 3]}[effort]
    return Plan(pictures_trial, [{"geometry": "A", "stages": stages}], 1, {})


@experiment("fig_5_10_fans", artefact="fig_5_10", inputs=ALL_THREE)
def fans(effort):
    """How wide the fan of rays is, on smooth mirrors and on uneven ones."""
    seeds = {"quick": 3, "full": 100}[effort]
    return Plan(fan_trial, crossed(geometry=["A", "B", "C"]), seeds, {}, UNSEEN)


@experiment("fig_5_10_moved", artefact="fig_5_10", inputs=GEOMETRY_A)
def moved(effort):
    """How far corners move in the picture."""
    seeds = {"quick": 3, "full": 20}[effort]
    settings = {"deflections_mm": DEFLECTIONS_MM}
    return Plan(displacement_trial, crossed(geometry=["A"]), seeds, settings)


# %% [markdown]
# **What a calibration states about itself.** Each update starts from the one before,
# so errors accumulate and residuals do not show them. An adjustment of all stages
# together gives a covariance of the coefficients, and from it a predicted error of each
# ray. A real sheet is none of the splines: what the residuals have beyond the noise of
# the corners is *misfit*, and is added to each ray. The runs have Gaussian errors of
# 0.2 px and 0.01 mm, inverse depth, position and slope of the clamp, and a prior on
# bending.


# %%
@experiment(
    "ext_mirror_trust_runs",
    artefact="ext_mirror_trust_figure",
    shards={"full": 2},
    inputs=BOTH,
)
def trust_runs(effort):
    """Three stages, calibrated all together."""
    surfaces = {"geometry": ("A", "B"), "aberration_um": (0.0, 10.0)}
    seeds = {"quick": 1, "full": 20}[effort]
    return Plan(trust_trial, crossed(**surfaces), seeds)


# %% tags=["active-ipynb"]
# show("ext_mirror_trust_figure")

# %% [markdown]
# On the uneven mirror of A the rays of stage 3 are {glue:text}`trust.true:.3f`° off
# (RMS). The prediction is {glue:text}`trust.predicted:.3f`° with the misfit term, and
# {glue:text}`trust.without:.3f`° without it.

# %% [markdown]
# ## Reading and limits
#
# - **A level is a stand-in.** That errors of decoding, an uneven mirror and a
#   platter that is off its place made the thesis's numbers is a guess.
# - **Why 0.86 and 0.68 stay.** The printed SD of the 0.86 mm is 0.47 of the mean. Noise
#   alone gives 0.73 to 1. An offset that all points have in common would explain it,
#   such as a platter that is not parallel to its board. The printed residual of stage 1
#   is larger than the back-projection error. Unevenness alone gives half to three
#   quarters of it; a longer mirror gives more, without any error.
# - **Corners are as they come.** Corners are as sharp at the solved levels as at the
#   low-noise one. Rendered corners are found from places near the true ones, by
#   the saddle point method; ordering them is not tried here. A pixel that was
#   decoded though its own ray misses the monitor is left out. So in the runs with
#   errors drawn from these no corner is missed and none is wrong. In
#   [runs from images](s3_3_deflections.ipynb) both occur.
# - **The field of view** is the fan in the plane of bending. Across it the mirror
#   does not bend, and shows no more than before.

# %% [markdown]
# ## Compared with the published numbers

# %% tags=["active-ipynb"]
# compared()

# %% [markdown]
# ## Try it yourself
#
# Open this page as a notebook (`make lab`) and run all cells. Then put an
# answer in place of `None`, and run that cell again.
#
# **1.** A mirror is clamped 150 mm from where it is pushed, by 15 mm. By how many
# degrees does the scene ray at the load turn?

# %% tags=["active-ipynb"]
# check(None, **slope_task())

# %% [markdown]
# **2.** The camera of geometry A sees the flat mirror, 160 mm long, in its
# picture. Predict the fan of rays at stage 3 in degrees, from the turn of
# exercise 1, and compare with the figure's caption.

# %% tags=["active-ipynb"]
# check(None, **fan_task())

# %% [markdown]
# **3.** How many pairs of a viewing and a scene ray does the full model need at
# least, before its size is fixed?

# %% tags=["active-ipynb"]
# check(None, **unknowns_task())
