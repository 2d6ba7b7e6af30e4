# %% [markdown]
# # 5.3.3a Primary calibration and error levels
#
# **Question.** Every update of a flexible mirror starts from its initial shape. The
# thesis measures it with two positions of a monitor seen in the mirror. It prints 32
# error figures, but neither its set-up nor its noise. How large must simulated errors
# be to reach these figures?

# %%
from functools import partial

from chapters.ch05_flexible_mirror.s3_3_calibration.exercises import (
    fan_task,
    slope_task,
    unknowns_task,
)
from chapters.ch05_flexible_mirror.s3_3_calibration.experiment import (
    AMPLITUDES_UM,
    DEFLECTIONS_MM,
    FACTORS,
    GEOMETRIES,
    RENDERED,
    SEEDS,
    SMALL,
    displacement_trial,
    errors_trial,
    fan_trial,
    first_trial,
    images_trial,
    second_trial,
    trust_trial,
)
from chapters.ch05_flexible_mirror.s3_3_calibration.report import name_values
from chapters.shared.mirror import (
    ALL_THREE,
    BENCHES,
    BOTH,
    FIRST,
    GEOMETRY_A,
    SECOND,
    SMALL_A,
    UNSEEN,
    MirrorErrors,
)
from raxel.calibration import mirror_points
from repro.page import (
    check,
    compared,
    open_results,
    show,
    show_code,
    show_table,
    values,
)
from repro.run import Plan, crossed, experiment

# %% tags=["active-ipynb"]
# show("fig_5_10")

# %% tags=["active-ipynb", "remove-input"]
# name_values(open_results)
# values()

# %% [markdown]
# **Findings.**
#
# 1. **The field of view grows by a factor of {glue:text}`fig5_10_fov:.2f` on rig A.**
#    The factor depends on the rig.
# 2. **Decoding errors alone do not explain the thesis's errors.** They would have to be
#    {glue:text}`bench.factor:.2f` times the simulated ones. About half of the other
#    printed numbers contradict so large a factor.
# 3. **The primary level combines three causes.** They are
#    {glue:text}`second.factor:.2f` times the decoding errors, a mirror uneven by
#    {glue:text}`second.aberration:.1f` µm, and placement errors of the reference
#    mirror.
# 4. **The residuals stay unexplained.** At the primary level they are too small at all
#    stages. Distances of mirror points from their rays are too small in most runs.

# %% [markdown]
# | quantity | thesis | here |
# |---|---|---|
# | field of view, stage 3 / stage 0 | about 2 | {glue:text}`fig5_10_fov:.2f` (rig A) |
# | point-to-ray distance, low-noise | 0.86 mm | {glue:text}`miss.clean:.2f` mm |
# | point-to-ray distance, primary | 0.86 mm | {glue:text}`second.miss:.2f` mm |
# | residual of stage 1, primary | 0.68 mm | {glue:text}`second.residual:.2f` mm |
# | angle to measured rays, stage 0 | 0.19° | sets the primary level |

# %% [markdown]
# ## Terms
#
# - *Stage* $k$: the mirror is pushed by $5k$ mm, $k$ = 0 to 3. *Run*: one simulated
#   experiment with its own random errors.
# - *Viewing ray*: from camera to mirror. *Scene ray*: its reflection. *Mirror point*:
#   estimated intersection of both.
# - *Decoded point*: monitor position that a pixel sees.
# - *Platter*: flat reference mirror on a chessboard, which shows the monitor.
# - *Rigs*: A has a mirror of 160 mm, seen from 370 mm. B has 130 mm and 190 mm. C is A
#   with a mirror of 212 mm.
# - *Unevenness*: waves of 45 to 110 mm on the mirror (RMS).
# - *Fan*: rays of the mirror's middle line. Its angle is the field of view.

# %% [markdown]
# ## What the thesis claims
#
# - A clamped plastic mirror is pushed three times by 5 mm. At stage 3 the field of view
#   is about twice that of stage 0 (Fig. 5.10).
# - The model has 7 functions along the mirror and 3 across (Fig. 5.9).
# - The mean distance of 1056 mirror points from their rays is 0.86 mm. Calibrated rays
#   differ from measured ones by 0.19°.

# %% [markdown]
# ## Model
#
# **Rigs.** Rig C was chosen after all printed numbers were known: its rays rotate as in
# Table 5.3.

# %% tags=["active-ipynb"]
# show("fig_5_8")

# %% [markdown]
# **Spline.** The distance of the mirror along viewing rays is a sum of products
# $f_i(u)\,g_j(v)$ of quadratic B-splines (5.4), with knots anew at each stage.

# %% tags=["active-ipynb"]
# show("fig_5_9")

# %% [markdown]
# **Primary calibration** (5.2.1). Each pixel decodes one point of the monitor in either
# position, which gives its scene ray. Normals give the spline up to scale (5.15, 5.16),
# and mirror points the scale. Then the distances of decoded points from their scene
# rays are minimised.

# %% tags=["active-ipynb"]
# show_code(mirror_points)

# %% [markdown]
# ## Experiment
#
# **Errors** of corners and decoded points are measured in rendered images of rigs A and
# B. Most of the decoding error is the ripple that the monitor's gamma leaves (3.2.2).
# Runs redraw them.


# %%
@experiment(
    "sec_5_3_3_errors",
    artefact="sec_5_3_3",
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
    """Errors of corners and decoded points in rendered images."""
    conditions = crossed(geometry=GEOMETRIES, small=[SMALL[effort]])
    return Plan(errors_trial, conditions, RENDERED[effort], {})


# %% [markdown]
# **Error levels.** Claims are judged at three levels with the same random draws:
#
# - *Low-noise level*: errors as measured in rendered images, smooth mirror.
# - *First solved error level*: a factor of the decoding errors, solved from the mean
#   distance of mirror points (0.86 mm), and unevenness, solved from the residual of
#   stage 1 (0.68 mm).
# - *Second solved error level* (primary): both solved from the mean angle to measured
#   rays (0.19°) and the mean back-projection error (0.56 mm) of stage 0. The platter is
#   displaced by 0.2 mm and 0.06° (SD) each time it is placed. At each position of the
#   monitor it is displaced by another 0.2 mm and 0.05°.
#
# Both pairs are solved on rig A before any claim is run with them. The form of the
# second level was chosen after all 32 printed numbers were known, so the count of
# numbers that it reaches tests nothing. A claim is undecided if its verdict differs
# between the levels, or if its estimate changes side between half and twice the second
# level's numbers.

# %% tags=["active-ipynb"]
# show("ext_mirror_bench")


# %%
@experiment(
    "bench_mirror",
    artefact="ext_mirror_bench",
    inputs=GEOMETRY_A,
    needs=("sec_5_3_3_errors",),
)
def bench(effort, results):
    """Effect of factor and amplitude on the two numbers that they are solved from."""
    return _solving(results, first_trial, {}, FIRST, SEEDS[effort])


@experiment(
    "bench_mirror_second",
    artefact="ext_mirror_bench",
    inputs=GEOMETRY_A,
    needs=("sec_5_3_3_errors",),
)
def second(effort, results):
    """The same for the second level, with a displaced platter."""
    return _solving(results, second_trial, {"level": SECOND}, SECOND, SEEDS[effort])


def _solving(results, trial, condition, level, seeds):
    errors = MirrorErrors.read(results["sec_5_3_3_errors"], "A")
    settings = {"factors": FACTORS[level], "amplitudes_um": AMPLITUDES_UM[level]}
    settings |= BENCHES[level]._asdict()
    return Plan(partial(trial, errors=errors), [condition], seeds, settings)


# %% tags=["active-ipynb"]
# show_table("ext_mirror_levels")


# %%
@experiment("fig_5_10_pictures", artefact="fig_5_10", inputs=SMALL_A)
def images(effort):
    """The room in the mirror."""
    stages = {"quick": [0, 3], "full": [0, 1, 2, 3]}[effort]
    return Plan(images_trial, [{"geometry": "A", "stages": stages}], 1, {})


@experiment("fig_5_10_fans", artefact="fig_5_10", inputs=ALL_THREE)
def fans(effort):
    """Angle of the fan of rays, on smooth mirrors and on uneven ones."""
    seeds = {"quick": 3, "full": 100}[effort]
    return Plan(fan_trial, crossed(geometry=["A", "B", "C"]), seeds, {}, UNSEEN)


@experiment("fig_5_10_moved", artefact="fig_5_10", inputs=GEOMETRY_A)
def moved(effort):
    """Displacement of corners in the image."""
    seeds = {"quick": 3, "full": 20}[effort]
    settings = {"deflections_mm": DEFLECTIONS_MM}
    return Plan(displacement_trial, crossed(geometry=["A"]), seeds, settings)


# %% [markdown]
# **Predicted errors.** A joint adjustment of all stages predicts an error for each ray
# from the covariance of the coefficients. The *misfit*, the part of the residuals
# beyond the corner noise of 0.2 px, is added to each ray.


# %%
@experiment("ext_mirror_trust_runs", artefact="ext_mirror_trust_figure", inputs=BOTH)
def trust_runs(effort):
    """Three stages, calibrated together."""
    surfaces = {"geometry": ("A", "B"), "aberration_um": (0.0, 10.0)}
    seeds = {"quick": 1, "full": 20}[effort]
    return Plan(trust_trial, crossed(**surfaces), seeds)


# %% tags=["active-ipynb"]
# show("ext_mirror_trust_figure")

# %% [markdown]
# Only with the misfit term is the prediction close, but too small at stage 3.

# %% [markdown]
# ## Discussion
#
# **Distances of mirror points.** The printed SD is about half of the mean of 0.86 mm.
# With decoding noise alone the SD is nearly the mean. The displaced platter gives about
# half, and single runs reach 0.86 mm.
#
# **Residuals.** The printed residual of stage 1 is larger than the back-projection
# error. In the runs it is about half of it.
#
# **Limits.** A level is one guess at the causes of the thesis's errors. It has no
# missed or false corners ([runs from images](s3_3_deflections.ipynb) have).

# %% [markdown]
# ## Summary
#
# Decoding errors alone contradict about half of the printed numbers. With placement
# errors of the platter the residuals stay too small. Later claims use three levels.

# %% [markdown]
# ## Compared with the published numbers

# %% tags=["active-ipynb"]
# compared()

# %% [markdown]
# ## Try it yourself
#
# Run all cells of this notebook (`make lab`). Put an answer in place of `None`, and run
# that cell again.
#
# **1.** A mirror is clamped 150 mm from where it is pushed, by 15 mm. By how many
# degrees does the scene ray at the load rotate?

# %% tags=["active-ipynb"]
# check(None, **slope_task())

# %% [markdown]
# **2.** The camera of rig A sees the whole flat mirror, 160 mm long. Predict the angle
# of the fan at stage 3 in degrees, from exercise 1.

# %% tags=["active-ipynb"]
# check(None, **fan_task())

# %% [markdown]
# **3.** How many pairs of viewing and scene rays does the full model need, before its
# scale is fixed?

# %% tags=["active-ipynb"]
# check(None, **unknowns_task())
