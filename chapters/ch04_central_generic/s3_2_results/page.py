# %% [markdown]
# # 4.3.2a Ray-point errors and centrality of two cameras
#
# **Question.** Does CGSP calibrate a nearly central camera more accurately than the
# standard generic method? A misaligned mirror camera and a fisheye with an
# entrance-pupil shift view three active grids each. How far are the grid points from
# their rays, and the rays from one centre?

# %%
from functools import partial

from chapters.ch04_central_generic.s3_2_results.exercises import (
    kurtosis_task,
    lever_task,
)
from chapters.ch04_central_generic.s3_2_results.experiment import (
    BRACKET_SETS,
    FACTOR_RUNS,
    TRIALS,
    bracket_conditions,
    bracket_trial,
    caustic_conditions,
    caustic_trial,
    cgsp_conditions,
    cgsp_trial,
    errors_conditions,
    errors_trial,
    redrawn_conditions,
    redrawn_trial,
    rendered_trial,
)
from chapters.ch04_central_generic.s3_2_results.report import ERRORS, name_values
from chapters.shared.central import (
    GRID_RIGS,
    GRID_SETS,
    LINEAR_GRIDS,
    MAX_RAYS,
    MIN_SPREAD,
    DecodingErrors,
    crossings,
    facing_plane,
    grid_conditions,
    scatter_of,
    shared_rays,
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
# show_table("table_4_3", digits=3)

# %% tags=["active-ipynb", "remove-input"]
# values()
# name_values(open_results)

# %% [markdown]
# **Findings.**
#
# 1. **CGSP leads, but not tenfold.** On the mirror camera the standard method as
#    printed has {glue:text}`s4_4_ratio_omni:.2f` times CGSP's mean ray-point error,
#    and {glue:text}`lab.omni.as_printed.ratio:.1f` times at the low-noise level.
# 2. **The lead comes from numerical conditioning.** The well-conditioned standard
#    method matches CGSP: the ratios are {glue:text}`omni.well_conditioned.ratio:.3f`
#    and {glue:text}`fish.well_conditioned.ratio:.3f`. Only its centre of the mirror
#    camera is less accurate (Table 4.3).
# 3. **Bundle adjustment makes the errors equal.** As printed, the standard method
#    ends at CGSP's error on both cameras, although its centre is not adjusted.
# 4. **Small misalignment hardly matters.** A bracket offset of 1 mm raises CGSP's
#    error by about a tenth at the low-noise level.

# %% [markdown]
# | quantity | thesis | here |
# |---|---|---|
# | mean error, standard / CGSP, mirror | 16 | {glue:text}`s4_4_ratio_omni:.2f` |
# | mean error, standard / CGSP, fisheye | 2.2 | {glue:text}`s4_4_ratio_fish:.2f` |
# | adjusted, standard, mirror (mm) | 1.16 | {glue:text}`t4_3_omni_std_mean_ba:.2f` |
# | adjusted, CGSP, mirror (mm) | 0.13 | {glue:text}`t4_3_omni_cgsp_mean_ba:.2f` |
# | fisheye parameters agree within (%) | 2.19 | {glue:text}`t4_2_fish_agree:.2f` |
# | depth of the mirror camera's centre | methods differ | methods agree |
# | fisheye centre inside the hull | CGSP only | nearly always, both |

# %% [markdown]
# ## Terms
#
# - *Mirror camera*: omnidirectional (catadioptric) camera of the thesis.
# - *Standard method*: central generic calibration of 2.4.1. *As printed* uses the
#   thesis's formulas, *well conditioned* solves the same equations by least squares
#   in normalised coordinates.
# - *CGSP*: Central Generic Synthetic Pinhole calibration (4.1.2).
# - *Ray-point error*: distance from a grid point to its ray.
# - *Adjustment* (BA): bundle adjustment of the grid poses, centre fixed.
# - *Low-noise level*: the simulator's own decoding errors.
# - *Thesis-matched level*: those errors times {glue:text}`factor:.2f`, so that CGSP's
#   mean error on the mirror camera is the printed 0.19 mm. It applies unless stated.
# - *Rendered run*: rendered images, decoded and calibrated. *Redrawn run*: new grid
#   poses, and decoding errors as in the rendered ones.
# - *Crossing*: where the line fitted to a ray's three points meets the plane through
#   the centre. *Hull*: convex hull of the crossings.
# - *Caustic*: envelope of the rays of a non-central lens.

# %% [markdown]
# ## What the thesis claims
#
# - Fisheye parameters agree within 2.19 % between the methods. The depth of the
#   mirror camera's centre does not (Table 4.2).
# - On the mirror camera CGSP's errors are about ten times smaller, before and after
#   adjustment. On the fisheye the gap is smaller (Table 4.3).
# - CGSP's errors are similar on both cameras and agree with the simulation of 4.1. The
#   misalignment is therefore not significant.
# - With CGSP the mirror camera's crossings scatter less and are closer to Gaussian. On
#   the fisheye only CGSP's centre is in the hull (Fig. 4.6), and the caustic bounds the
#   scatter from below.
# - The scatter is smallest on the plane most nearly perpendicular to the rays.

# %% [markdown]
# ## Model
#
# Ray $i$ meets grid $j$ in $\mathbf P_{ij} = T_j \mathbf Q_{ij}$, with decoded point
# $\mathbf Q_{ij}$ and estimated pose $T_j$. The ray direction $\mathbf r_i$ points
# from the estimated centre $\mathbf C$ to the mean of its points. The ray-point error
# (4.18) is
#
# $$d_{ij} = \left\| (\mathbf r_i \cdot \mathbf p_{ij})\,\mathbf r_i -
# \mathbf p_{ij} \right\|, \qquad \mathbf p_{ij} = \mathbf P_{ij} - \mathbf C.$$
#
# The adjustment of 4.1.4 varies $T_2$ and $T_3$ to minimise it.
#
# The crossings $\mathbf x$ are taken on the plane most nearly perpendicular to the
# lines (4.24). Their covariance $S$ measures isotropy. Mardia's kurtosis, the mean of
# $(\mathbf x^\top S^{-1} \mathbf x)^2$, is 8 for a Gaussian in two dimensions.

# %% tags=["active-ipynb"]
# show_code(crossings, facing_plane, scatter_of)

# %% [markdown]
# ## Experiment
#
# The rigs of [4.3.1](s3_1_setup.ipynb) are rendered and decoded. All methods get the
# same rays: at most 20 000 that meet all three grids (4.1.2), without those that RANSAC
# rejects ({glue:text}`omni.left_out:.1f` % on the mirror camera). In addition, there
# are {glue:text}`redrawn` redrawn runs per camera.
#
# **Noise level.** At the low-noise level CGSP leaves a fifth of the error printed in
# Table 4.3. The factor is the same for both cameras. It is solved from that number by
# CGSP alone, before any claim is tested, and the number is marked *set*.
#
# **Interpretations.** The primary one keeps the errors correlated over the decoder's
# filter. The second makes them white, with its own factor. The third is the low-noise
# level. A verdict is undecided if its estimate changes side between half and twice the
# factor.


# %%
@experiment("table_4_3_rendered", artefact="table_4_3", rendered=GRID_SETS)
def rendered_runs(effort):
    """Plan rendered runs of both cameras, from images to tables."""
    settings = {
        "most_rays": MAX_RAYS,
        "grids": LINEAR_GRIDS,
        "least_spread": MIN_SPREAD,
    }
    return Plan(rendered_trial, grid_conditions(effort), 1, settings)


@experiment("table_4_3_errors", artefact="table_4_3", rendered=GRID_SETS)
def decoding_errors(effort):
    """Plan the decoding errors of the rendered sets."""
    return Plan(errors_trial, errors_conditions(effort), 1, {})


@experiment(
    "table_4_3_redrawn",
    artefact="table_4_3",
    inputs=GRID_RIGS,
    needs=("table_4_3_errors",),
)
def redrawn_runs(effort, results):
    """Plan new grid poses with the decoding errors of the rendered sets."""
    trial = partial(redrawn_trial, errors=DecodingErrors.by_rig(results[ERRORS]))
    return Plan(trial, redrawn_conditions(effort), TRIALS[effort], {})


@experiment(
    "bench_factor",
    artefact="ext_bench_factor",
    inputs=GRID_RIGS,
    needs=("table_4_3_errors",),
)
def bench_factor(effort, results):
    """Plan CGSP alone, with multiplied decoding errors."""
    trial = partial(cgsp_trial, errors=DecodingErrors.by_rig(results[ERRORS]))
    return Plan(trial, cgsp_conditions(effort), FACTOR_RUNS[effort], {})


# %%
@experiment("exp_c4_small_misalign", artefact="table_4_3", rendered=BRACKET_SETS)
def brackets(effort):
    """Plan the mirror camera with several bracket offsets, at reduced size."""
    return Plan(bracket_trial, bracket_conditions(effort), 1, {})


@experiment("exp_c4_caustic_floor", artefact="fig_4_6", inputs=GRID_RIGS)
def caustic(effort):
    """Plan the fisheye without noise, with new grid poses in each trial."""
    return Plan(caustic_trial, caustic_conditions(effort), TRIALS[effort], {})


# %% tags=["active-ipynb"]
# show_code(rendered_trial, redrawn_trial, shared_rays)

# %% [markdown]
# ## Figures and tables

# %% tags=["active-ipynb"]
# show("fig_4_6")

# %% tags=["active-ipynb"]
# show_table("table_4_2", digits=5)

# %% tags=["active-ipynb"]
# show("ext_bench_factor")

# %% [markdown]
# ## Discussion
#
# **Size of the lead.** The standard method as printed works in mm and divides by single
# coefficients. This magnifies model errors, such as the bracket offset. Point noise
# affects all methods equally and hides the effect.
#
# **Agreement with 4.1.5.** As in the simulation, unadjusted CGSP is better than the
# adjusted standard method on the mirror camera, but not on the fisheye.
#
# **Scatter.** Where two grids cross, a ray's points nearly coincide and do not
# determine its line. The thesis keeps such rays, a second interpretation does not.
#
# **Limits.** Mirror shape, bracket offset and pupil shift are choices (4.3.1).

# %% [markdown]
# ## Summary
#
# CGSP's ray-point errors are smaller than those of the standard method as printed, but
# far from ten times, and good conditioning removes the difference. Bundle adjustment
# makes the methods equal. The published gap on the mirror camera remains unexplained.

# %% [markdown]
# ## Compared with the published numbers

# %% tags=["active-ipynb"]
# compared()

# %% [markdown]
# ## Try it yourself
#
# Open this page as a notebook (`make lab`) and run all cells. Then replace `None` by
# an answer and run that cell again.
#
# **1.** A ray meets three grids at 40, 60 and 80 mm from the centre. Each point has a
# lateral error of 0.04 mm (SD). What is the SD (mm) of the fitted line at the centre?

# %% tags=["active-ipynb"]
# check(None, **lever_task())

# %% [markdown]
# **2.** What is Mardia's kurtosis of a three-dimensional Gaussian?

# %% tags=["active-ipynb"]
# check(None, **kurtosis_task())
