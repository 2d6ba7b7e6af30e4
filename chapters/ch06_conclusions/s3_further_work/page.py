# %% [markdown]
# # 6.3 Further work and its outcome
#
# **Question.** The thesis ends with directions for further work on corner detection,
# central calibration and flexible mirrors. Since 2009 some of them have become easier
# to try, because cameras and mirrors can be rendered. Given is this list. Which
# directions did this report take up, and what came out?

# %%
from chapters.ch06_conclusions.s3_further_work.exercises import edge_task, pairs_task
from chapters.ch06_conclusions.s3_further_work.report import name_values
from repro.page import check, open_results, scoreboard

# The scoreboard follows from the results of all pages.
READS_VERDICTS = True

# %% tags=["active-ipynb", "remove-input"]
# rows, _ = scoreboard()
# name_values(rows, open_results)

# %% [markdown]
# **Findings.**
#
# 1. **Corners can be detected without clicks.** A detector with several scales and a
#    check of symmetry extracts {glue:text}`detector.right` of
#    {glue:text}`detector.boards` boards, and {glue:text}`detector.wrong` incorrectly.
# 2. **Adjusting the centre brings no gain.** Its median error is
#    {glue:text}`linear:.2f` mm after the linear stage and
#    {glue:text}`consistent:.2f` mm after a consistent adjustment. The scheme of the
#    thesis leads to {glue:text}`line_fitting:.0f` mm.
# 3. **More spline functions represent an uneven mirror better.** They remove
#    {glue:text}`relief:.0f` % of the error that waves add, but the largest tolerated
#    step falls by {glue:text}`step:g` mm.
# 4. **Half of the twelve directions are not taken up**, among them straight edges for
#    self-calibration, and adaptive optics.

# %% [markdown]
# | direction | thesis | here |
# |---|---|---|
# | corner detector for chessboards | 6.3.1 | [another detector](#corners) |
# | clustering of detected corners | 6.3.1 | not taken up |
# | window radius from the curvature of edges | 6.3.1 | not taken up |
# | CELECT on coded grids | 6.3.1 | [other detectors](#corners) |
# | adjustment of the centre | 6.3.2 | [taken up](#central-cameras) |
# | effect of inexact centrality on it | 6.3.2 | [another test](#central-cameras) |
# | loads at several points | 6.3.3 | [library only](#flexible-mirrors) |
# | choice of knots and spline order | 6.3.3 | [in part](#flexible-mirrors) |
# | active grids after a deflection | 6.3.3 | not taken up |
# | refinement without known points | 6.3.3 | not taken up |
# | straight edges as constraint | 6.3.3 | not taken up |
# | adaptive optics | 6.3.3 | not taken up |

# %% [markdown]
# ## Terms
#
# - *Direction*: a proposal of section 6.3 for further work.
# - *Not taken up*: no code and no experiment of this repository tries it.
# - *CELECT*: the corner detector of the thesis
#   ([3.1.2](../ch03_planar_grids/s1_2_celect.ipynb)).
# - *Harris detector*: corner detector that CELECT applies in its windows.
# - *Active grid*: phase-shift structured light on a monitor (3.2.2).
# - *Consistent adjustment*: bundle adjustment with residuals in the plane of each grid
#   ([4.1.4](../ch04_central_generic/s1_4_bundle_adjustment.ipynb)).
# - *SPFC²*: the thesis's calibration of a flexible mirror (5.2).

# %% [markdown]
# ## What the thesis claims
#
# - The corner error of CELECT is below 8 px, which suffices for localisation. A better
#   corner detector and clustering could reduce it.
# - Traced on a coded grid, CELECT could replace active grids with a single image.
# - A refined centre could improve CGSP. A first scheme performed poorly.
# - More knots, chosen with dense data, could represent an uneven mirror.
# - Straight edges of the scene could replace known points in self-calibration. The cost
#   would measure how far the rays of an edge are from a plane.

# %% [markdown]
# ## Model
#
# **Straight edges.** Ray $i$ starts in the mirror point $\mathbf{s}_i$ with direction
# $\mathbf{d}_i$. The edge is a line through $\mathbf{a}$ with direction $\mathbf{e}$.
# The ray meets the edge if
#
# $$(\mathbf{d}_i \times \mathbf{e}) \cdot (\mathbf{a} - \mathbf{s}_i) = 0 ,$$
#
# one equation for each ray, with four unknowns for the edge. In a central camera all
# $\mathbf{s}_i$ are the centre $\mathbf{c}$. The equation then is $\mathbf{d}_i \cdot
# \mathbf{n} = 0$ with $\mathbf{n} = \mathbf{e} \times (\mathbf{a} - \mathbf{c})$: the
# rays lie in a plane. A bent mirror is not central, so rays of an edge are not coplanar
# in general. The cost that the thesis proposes therefore does not vanish for the true
# mirror. The distances of the rays from the edge do.

# %% [markdown]
# ## Experiment
#
# This page has no experiment of its own. Its numbers are results of the pages that it
# links, and its verdicts are those of the scoreboard.

# %% [markdown]
# ## Corners
#
# **Corner detector.** The thesis proposes a Harris detector at several scales, with a
# measure of symmetry. CELECT here keeps its detector. The verdict on its corner error,
# below 8 px, is *{glue:text}`c6_detect_8px`*. A second detector searches saddle points
# at several scales, follows edges from corner to corner and tests the symmetry of each
# corner. It needs no clicks, and the median of its largest errors is
# {glue:text}`detector.median_px:.2g` px
# ([without clicks](../ch03_planar_grids/ext_without_clicks.ipynb)).
#
# **Clustering.** Candidates are merged by distance, as in the thesis. The claim that
# uneven squares cause merge errors is *{glue:text}`c3_size_variation_merge`*
# ([3.3.2](../ch03_planar_grids/s3_2_conditions.ipynb)), and
# [3.3.1](../ch03_planar_grids/s3_1_robustness.ipynb#ext_celect_merging) shows where
# merging fails. No clustering was tried.
#
# **Curvature of edges.** No window radius follows from the curvature. The claim behind
# this direction, that large squares with strongly curved edges defeat tracing, is
# *{glue:text}`c3_big_square_curved`* ([3.1.2](../ch03_planar_grids/s1_2_celect.ipynb)).
#
# **Coded grids.** `raxel corners` reads ChArUco boards and AprilTag grids. Markers give
# the order of the corners; CELECT does not trace these boards. No page of this report
# measures how much distortion the markers tolerate.

# %% [markdown]
# ## Central cameras
#
# **Centre.** [Page 4.1.4](../ch04_central_generic/s1_4_bundle_adjustment.ipynb) repeats
# the adjustment of the thesis on simulated data, as proposed. The claim that it
# converges poorly, with many minima, is *{glue:text}`c4_centre_ba_unstable`*. A central
# camera shows the drift too, so poor centrality is not needed to explain it. With
# residuals in the plane of each grid and frozen weights the adjustment is stable.
#
# **Inexact centrality.** The adjustment was not run with a non-central camera.
# [Another page](../ch04_central_generic/ext_central_or_not.ipynb) tests whether a
# camera is central. For a mirror with an offset of 2 mm the rays of a central
# calibration have an error of {glue:text}`central_miss_mm:.2f` mm next to the camera,
# and free lines {glue:text}`lines_miss_mm:.2f` mm.

# %% [markdown]
# ## Flexible mirrors
#
# **Several loads.** The simulator renders mirror sets with two loads
# (`data/rigs/mirror-sets/two-loads.yaml`), and `raxel calibrate` accepts them. No page
# of this report judges such a calibration.
#
# **Knots.** Two claims vary the number of functions. Relief beyond the spline explains
# the residual of the flat mirror: *{glue:text}`c5_high_order`*
# ([5.3.3c](../ch05_flexible_mirror/s3_3_repeatability.ipynb)). More knots are more
# accurate and tolerate less deflection: *{glue:text}`c5_knot_tradeoff`*
# ([5.2](../ch05_flexible_mirror/s2_method.ipynb)). A guided choice of knots and of the
# order was not tried. Active grids serve for the flat mirror only, as in the thesis.
#
# **Self-calibration.** [Page 5.4](../ch05_flexible_mirror/s4_self_calibration.ipynb)
# shows what a refinement would have to correct. That linear self-calibration is not
# usable is *{glue:text}`c5_selfcal_impractical`*. That errors do not accumulate with a
# known static scene is *{glue:text}`c5_known_scene`*: the drift is
# {glue:text}`drift:.2g` % per step. No refinement without known points was tried, and
# no lines are detected in distorted images.
#
# **Adaptive optics.** No data and no simulation of such mirrors exist here.

# %% [markdown]
# ## Discussion
#
# - **Choice.** Directions were taken up where a claim of the thesis or a user of the
#   library needed them, not in the order of their promise.
# - **Straight edges** remain the most specific proposal. The model above shows which
#   cost is zero at the true mirror.
# - **Limits.** Results on simulated cameras do not replace the experiments on real
#   mirrors that the thesis proposes.

# %% [markdown]
# ## Summary
#
# This report adjusts the centre of a camera, varies the functions of a mirror spline
# and detects corners without clicks. The library also reads coded grids and calibrates
# mirrors with several loads, without a result in this report. Half of the directions
# are not taken up.

# %% [markdown]
# ## Compared with the published numbers
#
# Section 6.3.1 makes one claim: the corner error of CELECT is below 8 px. It is
# *{glue:text}`c6_detect_8px`* ([3.3.1](../ch03_planar_grids/s3_1_robustness.ipynb)).

# %% [markdown]
# ## Try it yourself
#
# Open this page as a notebook (`make lab`) and run all cells. Then replace `None` by an
# answer and run that cell again.
#
# **1.** A bent mirror shows a straight edge in 20 pixels. How many equations for the
# mirror remain, beyond those that determine the edge?

# %% tags=["active-ipynb"]
# check(None, **edge_task())

# %% [markdown]
# **2.** A pair of viewing ray and scene ray gives two linear equations for the spline
# of a mirror (5.1.2). How many pairs determine 14 × 9 coefficients up to their scale?

# %% tags=["active-ipynb"]
# check(None, **pairs_task())
