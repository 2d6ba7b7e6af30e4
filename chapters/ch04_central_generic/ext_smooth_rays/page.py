# %% [markdown]
# # Smooth rays: a B-spline ray field
#
# **Question.** In a per-pixel ray table every ray has the noise of its own few points.
# Most lenses, however, refract smoothly. How much noise remains if the rays are
# smoothed over the image, and how general is such a camera?

# %%
from chapters.ch04_central_generic.ext_smooth_rays.exercises import controls_task
from chapters.ch04_central_generic.ext_smooth_rays.experiment import (
    CONDITIONS,
    LENSES,
    SMOOTH_SETTINGS,
    TRIALS,
    bent_lens,
    calibrate,
    scores,
)
from chapters.ch04_central_generic.ext_smooth_rays.report import name_values
from chapters.shared.central import draw_scene
from repro.page import check, open_results, show, show_code, show_table
from repro.run import Plan, experiment

# %% tags=["active-ipynb"]
# show("ext_smooth_rays_figure")

# %% tags=["active-ipynb"]
# name_values(open_results)

# %% [markdown]
# **Findings.**
#
# 1. **Smoothing removes most of the noise.** For a bent lens, three grids and 0.5 px
#    noise, the residual is {glue:text}`usual.smooth.left_px:.2f` px. The table has
#    {glue:text}`usual.table.left_px:.2f` px, and the radial law alone is worse than
#    both.
# 2. **Without bending the field stays close to zero.** For the radial lens it is as
#    accurate as the radial law.
# 3. **Common errors remain.** After a rotation, errors of centre and poses leave
#    {glue:text}`usual.smooth.off_px:.2f` px with three grids and
#    {glue:text}`many.smooth.off_px:.2f` px with ten.
# 4. **Only the direct adjustment predicts these errors.** Its squared errors are
#    {glue:text}`usual.direct.normalised:.1f` times those predicted. For the smooth
#    table the factor is {glue:text}`usual.smooth.normalised:.0f` (medians).

# %% [markdown]
# | question or quantity | thesis | here |
# |---|---|---|
# | rays of neighbouring pixels | independent | smooth field |
# | points for a ray | its own | those of the neighbourhood |
# | discontinuous cameras | covered | not covered |
# | residual of a table (px) | – | {glue:text}`usual.table.left_px:.2f` |
# | residual of smooth rays (px) | – | {glue:text}`usual.smooth.left_px:.2f` |

# %% [markdown]
# ## Terms
#
# - *Table*: per-pixel ray model (general camera). *Smooth rays*: B-spline ray field on
#   a trend.
# - *Trend*: parametric central camera that takes the large part of the distortion.
#   *Radial law*: the trend alone.
# - $\mathbf{s}(\mathbf{p})$: field in px at pixel $\mathbf{p} = (u, v)$, with cubic
#   B-splines $b$ and control values $\mathbf{c}_{ij}$ on a lattice of *cells*.
# - *Smooth table*: field fitted to a table. *Direct adjustment*: field and grid poses
#   fitted to the points.
# - *Radial lens*: that of [4.1.5](s1_5_simulated.ipynb). *Bent lens*: the same, with
#   waves of 1 px in the image.
# - *Residual*: distance in the corrected view after a homography, as in the thesis.
#   *After a rotation*: distance in the image after one rotation of all rays.

# %% [markdown]
# ## What the thesis claims
#
# The thesis has no smooth rays. In its general camera the ray of a pixel is in
# principle independent of its neighbours (section 2.3), which also covers discontinuous
# cameras. Section 4.1.3 fits each ray to its own points.

# %% [markdown]
# ## Model
#
# A pixel $\mathbf{p}$ has the ray that the trend has at
#
# $$\mathbf{p} + \mathbf{s}(\mathbf{p}), \qquad
# \mathbf{s}(\mathbf{p}) = \sum_{i,j} b_i(v)\, b_j(u)\, \mathbf{c}_{ij} .$$
#
# With small cells the field describes every central camera with continuous rays. Its
# unit is px because the noise in px is nearly uniform over the image. The field changes
# by much less than a pixel per pixel, so each ray has exactly one pixel.
#
# **Smooth table.** Each ray of a table gives a value of $\mathbf{s}$: its image under
# the trend minus its pixel. The fit is least squares with a penalty on second
# differences of the control values. Prediction of held-out image blocks selects cell
# size and penalty.
#
# **Direct adjustment.** The trend images a grid point at $\mathbf{q}$, and the camera
# images it at the $\mathbf{p}$ with $\mathbf{p} + \mathbf{s}(\mathbf{p}) = \mathbf{q}$.
# Control values and poses are adjusted together to the measured pixels. The field
# contains no common rotation, because the poses already describe it. Here whole grids
# are held out, and only their poses are fitted.
#
# **Uncertainty.** The covariance of the control values gives each ray a covariance in
# px. It treats polynomials up to the third degree as unknown, because the trend comes
# from the same data.
#
# **Extrapolation.** Where there is no target, a weak penalty pulls the field to zero.
# Cells without data are reported.

# %% tags=["active-ipynb"]
# show_code(bent_lens, calibrate)

# %% [markdown]
# ## Experiment
#
# The scene is that of section 4.1.5 with a field of view of 90°: 999 rays and random
# grid poses. Every grid has its own noise. The waves of the bent lens are about half as
# long as the image. CGSP with adjusted centre gives the table.


# %%
def trial(condition, rng):
    """One scene, calibrated by all methods, and its errors."""
    camera = LENSES[condition["lens"]]()
    scene = draw_scene(camera, condition["noise"], rng, grids=condition["grids"])
    return scores(scene, *calibrate(scene))


@experiment("ext_smooth_rays_runs", artefact="ext_smooth_rays_figure")
def runs(effort):
    """All noise levels, lenses and numbers of grids."""
    return Plan(trial, list(CONDITIONS), TRIALS[effort], SMOOTH_SETTINGS)


# %% [markdown]
# ## In numbers

# %% tags=["active-ipynb"]
# show_table("ext_smooth_rays_honest_table")

# %% [markdown]
# ## Discussion
#
# - **Two measures.** After a homography only the shape of the corrected view counts.
#   After a rotation, errors of the centre and the focal length count too. All rays
#   share these errors, so smoothing does not reduce them, but more grids do.
# - **Pose errors in a table.** They are smooth over the image and look like the lens.
#   The predicted standard deviation of the smooth table therefore contains its noise
#   only.
# - **Smoothness.** Cameras with discontinuous rays, such as faceted mirrors, need a
#   table. The field does not represent scratches or single defective pixels.
# - **Few boards.** A few boards with little tilt hardly separate scale from depth, and
#   a free field separates them less well than a parametric model. The predicted
#   standard deviations show it. The field stays zero unless it improves the prediction
#   of held-out boards.
# - **One centre.** The model is central. An entrance-pupil shift is treated in
#   [Parametric lens models](ext_lens_formula.ipynb).
#
# ## Summary
#
# A smooth field removes most of the noise of a ray table and stays as general as a
# continuous central camera. It cannot remove errors of centre and poses, which all rays
# share. The direct adjustment predicts these errors cautiously, whereas a field fitted
# to a finished table underestimates them.
#
# ## Compared with the published numbers
#
# The thesis has no such experiment and prints no number for it.
#
# ## Try it yourself
#
# Open this page as a notebook (`make lab`) and run all cells. Then put an answer in
# place of `None`, and run that cell again.
#
# **1.** A square image has 8 x 8 cells. How many numbers define the field?

# %% tags=["active-ipynb"]
# check(None, **controls_task())
