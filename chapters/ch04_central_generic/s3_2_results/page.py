# %% [markdown]
# # 4.3.2 A mirror and a fisheye, rendered: parameters, errors, centrality
#
# **Question.** A mirror whose bracket is not quite right, and a fisheye whose
# pupil moves: neither is exactly central. The thesis had two such cameras;
# rendered rigs stand in for them here. Both are calibrated from three
# active grids, by the standard method and by CGSP. Whose rays fit the grids
# better, before and after bundle adjustment? And how near do they come to
# one point?

# %%
from functools import partial

from chapters.ch04_central_generic.s3_2_results.exercises import (
    kurtosis_task,
    lever_task,
)
from chapters.ch04_central_generic.s3_2_results.results import ERRORS, name_values
from chapters.ch04_central_generic.s3_2_results.trials import (
    BRACKET_SETS,
    FACTOR_SEEDS,
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
from chapters.shared.central_scatter import crossings, facing_plane, scatter_of
from chapters.shared.central_sets import (
    GRID_RIGS,
    GRID_SETS,
    LINEAR_GRIDS,
    MOST_RAYS,
    grid_conditions,
    shared_rays,
)
from chapters.shared.decoding_errors import DecodingErrors
from chapters.shared.three_grids import LEAST_SPREAD
from repro.page.exercise import check
from repro.page.reader import compared, open_results, show, show_code, show_table
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

# %% tags=["active-ipynb"]
# show_table("table_4_3", digits=3)

# %% tags=["active-ipynb", "remove-input"]
# name_values(open_results)

# %% [markdown]
# **Findings.**
#
# - At the bench's noise (see *Experiment*) the standard method as printed has
#   {glue:text}`omni.as_printed.ratio:.2f` times CGSP's ray-point error on the
#   mirror, and {glue:text}`fish.as_printed.ratio:.2f` times on the fisheye; with
#   the laboratory's own decoding errors, {glue:text}`lab.omni.as_printed.ratio:.2f`
#   and {glue:text}`lab.fish.as_printed.ratio:.2f` times. It is a factor, but
#   nowhere an order of magnitude.
# - Well conditioned, the standard method leaves the ray-point errors of CGSP at
#   the bench's noise: the ratios are {glue:text}`omni.well_conditioned.ratio:.3f`
#   and {glue:text}`fish.well_conditioned.ratio:.3f`. On the mirror its centre is
#   farther off, {glue:text}`omni.well_conditioned.centre_off_mm:.2f` mm against
#   {glue:text}`omni.cgsp.centre_off_mm:.2f` mm, and as printed
#   {glue:text}`omni.as_printed.centre_off_mm:.2f` mm; on the fisheye it is
#   {glue:text}`fish.well_conditioned.centre_off_mm:.2f` mm against
#   {glue:text}`fish.cgsp.centre_off_mm:.2f` mm.
# - Adjustment leaves the centre where it was and makes the errors equal: as
#   printed, the standard method keeps {glue:text}`omni.as_printed.ba_ratio:.2f`
#   times CGSP's on the mirror, and {glue:text}`fish.as_printed.ba_ratio:.2f` times
#   on the fisheye ({glue:text}`lab.omni.as_printed.ba_ratio:.2f` and
#   {glue:text}`lab.fish.as_printed.ba_ratio:.2f` with the laboratory's errors).
# - A bracket that is 1 mm off takes CGSP's error from
#   {glue:text}`bracket.0:.3f` to {glue:text}`bracket.1:.3f` mm with the
#   laboratory's errors.
# - The fisheye's rays scatter {glue:text}`caustic.scatter_mm:.2f` mm about
#   the estimated centre even without noise, more than its caustic's
#   {glue:text}`caustic.caustic_mm:.2f` mm: the poses give way to it too.

# %% [markdown]
# ## What the thesis claims
#
# - The parameters of the fisheye agree within 2.19 % between the methods; the
#   depth of the mirror's centre does not (Table 4.2).
# - On the mirror CGSP's ray-point errors are about ten times smaller than
#   those of the standard method, before and after adjustment. On the fisheye
#   the gap is smaller (Table 4.3).
# - CGSP's errors are alike on both cameras, so the mirror's misalignment does
#   not matter.
# - The rays scatter about CGSP's centre more tightly, and more like a
#   Gaussian, on the mirror; on the fisheye there is little between the
#   methods, but CGSP's centre lies in the convex hull of the scatter and the
#   other one does not (Fig. 4.6). The fisheye's caustic puts a floor on it.
#   The plane across the rays shows the scatter at its most compact.
# - The ray-point errors agree with the simulated results of 4.1.

# %% [markdown]
# ## Model
#
# Ray $i$ meets grid $j$ in $\mathbf P_{ij} = T_j \mathbf Q_{ij}$: $\mathbf
# Q_{ij}$ is decoded, $T_j$ estimated. Its direction $\mathbf r_i$ goes from
# the estimated centre $\mathbf C$ to the mean of its points. The ray-point
# error (4.18) is the distance of a point from its ray,
#
# $$d_{ij} = \left\| (\mathbf r_i \cdot \mathbf p_{ij})\,\mathbf r_i -
# \mathbf p_{ij} \right\|, \qquad \mathbf p_{ij} = \mathbf P_{ij} - \mathbf C.$$
#
# The adjustment of 4.1.4 moves $T_2$ and $T_3$ to make it small, and joins
# the rays anew after each round. $\mathbf C$ stays.
#
# For centrality the rays forget $\mathbf C$: each becomes the line that fits
# best to its three points. These lines are met with the plane through
# $\mathbf C$ that lies across them, by (4.24). What is left is a cloud of
# points about $\mathbf C$. Its covariance says how round it is. Mardia's
# kurtosis $b$, the mean of $(\mathbf x^\top S^{-1} \mathbf x)^2$ with $S$ the
# covariance, is 8 for a Gaussian of two coordinates.

# %% tags=["active-ipynb"]
# show_code(crossings, facing_plane, scatter_of)

# %% [markdown]
# ## Experiment
#
# The rigs of [section 4.3.1](s3_1_setup.ipynb) are photographed and decoded.
# Three grids take part; the methods get the same rays:
#
# | | | reason |
# |---|---|---|
# | rays | at most {glue:text}`most` of those that meet all three grids | 4.1.2 |
# | outliers | what fits no homography of grid to base (RANSAC) | 4.3.1 |
# | standard method | as printed, and well conditioned | the thesis does not say which |
# | adjustment | of the poses, the centre kept | 4.1.4 |
# | rendered seeds | {glue:text}`rendered` | end to end, the monitor set up anew |
# | redrawn seeds | {glue:text}`redrawn` | the claims ask for 50 |
# | lines | all rays, and those whose points lie apart | no line where grids cross |
#
# A redrawn seed sets the monitor up anew and draws decoding errors like those
# that were measured on the rendered sets: the bias by the place in a period
# of the sines and by the viewing angle, and noise that neighbours share. The
# bias is the larger part: {glue:text}`omni.errors.bias_mm_rms:.3f` mm RMS
# over places and angles on the mirror, since the camera's tone curve does not
# quite undo the monitor's gamma.
#
# **The bench's noise.** The laboratory decodes more cleanly than the thesis's
# bench did: with its own errors CGSP leaves
# {glue:text}`lab.omni.cgsp.ray_mean_mm:.3f` mm on the mirror, a fifth of what
# Table 4.3 prints. What is said of the thesis's own measurements may hang on
# that. So decoding errors, decoded less true, are multiplied by one factor,
# {glue:text}`factor:.2f` for both cameras, after decoding and before any
# calibration. It was solved from one printed number, CGSP's mean error on the
# mirror before adjustment, by runs of CGSP alone over seeds of their own and
# before any claim was run with it. That cell says nothing more, and counts as
# *set*; no other printed number was looked at. [Section 4.2](s2_pose.ipynb)
# and the next pages take the same factor.
#
# The errors come as the decoder leaves them: their bias repeats with the
# sines, and their noise is alike over the 7 x 7 pixels of its filter. A second
# reading makes them white: each has a sign drawn for it alone, and the factor
# is {glue:text}`factor.white:.2f`. The third is the laboratory's own
# errors. A verdict whose estimate changes side between half and twice the
# factor is left undecided.

# %% tags=["active-ipynb", "remove-input"]
# from repro.page.reader import value
#
# value("most", MOST_RAYS)


# %%
@experiment(
    "table_4_3_rendered", artefact="table_4_3", shards={"full": 2}, rendered=GRID_SETS
)
def rendered_seeds(effort):
    """From pictures to tables, both cameras."""
    settings = {
        "most_rays": MOST_RAYS,
        "grids": LINEAR_GRIDS,
        "least_spread": LEAST_SPREAD,
    }
    return Plan(rendered_trial, grid_conditions(effort), 1, settings)


@experiment("table_4_3_errors", artefact="table_4_3", rendered=GRID_SETS)
def decoding_errors(effort):
    """Decoding errors of the rendered sets."""
    return Plan(errors_trial, errors_conditions(effort), 1, {})


@experiment(
    "table_4_3_redrawn",
    artefact="table_4_3",
    shards={"full": 2},
    inputs=GRID_RIGS,
    needs=("table_4_3_errors",),
)
def redrawn_seeds(effort, results):
    """Grids set up anew, with the decoding errors of the rendered sets."""
    trial = partial(redrawn_trial, errors=DecodingErrors.by_rig(results[ERRORS]))
    return Plan(trial, redrawn_conditions(effort), TRIALS[effort], {})


@experiment(
    "bench_factor",
    artefact="ext_bench_factor",
    inputs=GRID_RIGS,
    needs=("table_4_3_errors",),
)
def bench_factor(effort, results):
    """CGSP alone, with the laboratory's decoding errors multiplied."""
    trial = partial(cgsp_trial, errors=DecodingErrors.by_rig(results[ERRORS]))
    return Plan(trial, cgsp_conditions(effort), FACTOR_SEEDS[effort], {})


# %%
@experiment("exp_c4_small_misalign", artefact="table_4_3", rendered=BRACKET_SETS)
def brackets(effort):
    """The mirror with brackets more and less off, at reduced size."""
    return Plan(bracket_trial, bracket_conditions(effort), 1, {})


@experiment("exp_c4_caustic_floor", artefact="fig_4_6", inputs=GRID_RIGS)
def caustic(effort):
    """The fisheye without noise, grids set up anew in each trial."""
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
# ## Reading and limits
#
# **Why no order of magnitude?** The standard method as printed works in mm
# and divides by single numbers. That magnifies what no central camera fits,
# the bracket and the pupil, and with the laboratory's clean points it costs a
# factor of {glue:text}`lab.omni.as_printed.ratio:.1f` on the mirror. Noise of
# the points adds to the error of every method alike, and hides it: the larger
# the noise, the nearer the ratio is to 1, up to about the bench's. On the
# fisheye it grows: there the noise alone unsettles the method as printed. The
# standard method's equations are the same as CGSP's; well conditioned, it is
# level. What took the thesis's implementation to 3.22 mm is not in its text.
#
# **Two tables of one error.** Table 4.3 has medians over all seeds, rendered and
# redrawn, with 95 % intervals of the median. The comparison at the end gives the
# same medians with the range of the seeds.
#
# **The bracket.** The true rays of the mirror pass
# {glue:text}`omni.true_scatter_mm:.3f` mm (RMS) from one point with a bracket
# that is 1 mm off. That is little beside the decoding errors carried back to
# the centre, so centrality alone would not betray it.
#
# **The cloud.** A line through three points a few centimetres apart is
# carried back ten centimetres. Its error there is several times that of the
# points. Where two grids cross, a ray's points nearly coincide, its line
# points anywhere, and single rays land centimetres away. They decide the RMS
# and, to the fourth power, the kurtosis. The thesis leaves none of them out,
# so all rays are the first reading. The second keeps those whose points lie
# apart by a tenth of their distance or more; on the mirror that leaves out
# {glue:text}`omni.left_close:.1f` %.
#
# **The plane.** Where all lines are equally good, the plane across the rays
# has the smallest cloud. Here lines are worse where grids come near each
# other, and the cloud is smallest on a plane that leans towards those rays,
# by a few per cent.
#
# **As simulated?** In 4.1.5 CGSP is ahead of the standard method before and
# after adjustment, and adjustment lowers the standard method's error. On the
# mirror that is so. On the fisheye CGSP's error before adjustment is larger
# than the standard method's after it, since its pupil moves and the poses of
# CGSP do not give way.
#
# **The hull.** Some thousand points with such tails have a wide hull. On the
# fisheye CGSP's centre lies inside it in {glue:text}`inside.cgsp` of
# {glue:text}`inside.seeds` seeds, that of the standard method in
# {glue:text}`inside.as_printed`.
#
# **RANSAC.** With the laboratory's errors it takes
# {glue:text}`lab.omni.left_out:.1f` % of the mirror's rays for outliers, and
# {glue:text}`lab.fish.left_out:.1f` % of the fisheye's. Hardly any was decoded
# wrongly: on the fisheye they are those farthest off the axis, where a pupil
# that moves fits no homography. Its limit follows the noise, and at the
# bench's it leaves out {glue:text}`omni.left_out:.1f` % and
# {glue:text}`fish.left_out:.1f` %.
#
# **Limits.** The figure of the mirror, its bracket and the shift of the pupil
# are choices (section 4.3.1). Redrawn seeds have the bias and the noise of
# the rendered ones, but rays on a lattice, fewer than rendered ones. In quick
# builds small pictures bend within the decoder's window; there redrawn and
# rendered seeds differ more.

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
# **1.** A ray meets three grids 40, 60 and 80 mm from the centre, each
# point with an error of SD 0.04 mm across it. What is the SD (mm) of the best
# line where it passes the centre?

# %% tags=["active-ipynb"]
# check(None, **lever_task())

# %% [markdown]
# **2.** What is Mardia's kurtosis of a Gaussian of three coordinates?

# %% tags=["active-ipynb"]
# check(None, **kurtosis_task())
