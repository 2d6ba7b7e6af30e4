# %% [markdown]
# # 4.1.3 Ray directions: joining what a pixel saw on several grids
#
# **Question.** A pixel saw a point on each of several grids, and no line
# passes through all of them and the centre exactly. Which ray is its own?
# The thesis takes the centroid of the points, and gives the grids of the
# linear stage more weight, because the poses of the others are less
# certain. Is that right, and how much more?

# %%
from chapters.ch04_central_generic.s1_3_rays.exercises import (
    image_noise_task,
    pose_task,
)
from chapters.ch04_central_generic.s1_3_rays.results import name_values
from chapters.ch04_central_generic.s1_3_rays.trials import NOISE, weights_trial
from chapters.shared.wide_angle import SETTINGS
from raxel.calibration.adjust.centroid_rays import centroid_directions, centroid_weights
from raxel.geometry import intersect_lines_plane
from repro.page.exercise import check
from repro.page.reader import compared, open_results, show, show_code
from repro.run.experiment import experiment
from repro.run.outcomes import Plan, crossed

# %% tags=["active-ipynb"]
# show("ext_ray_weights")

# %% tags=["active-ipynb"]
# name_values(open_results)

# %% [markdown]
# **Findings.**
#
# - More weight for the linear stage's grids is right where the poses of the
#   others come from few rays. From {glue:text}`posed.few:.0f` rays each, the
#   best of the weights tried is {glue:text}`factor.few:g`; a weight of 1 is
#   worse by a factor of {glue:text}`few.one`, one of 2 by
#   {glue:text}`few.two`.
# - Where poses come from {glue:text}`posed.many:.0f` rays, the best weight
#   is {glue:text}`factor.many:g`: all grids alike. A weight of 4 costs
#   {glue:text}`many.4:.2f` instead of {glue:text}`many.1:.2f` mm.
# - Weights from the variance of every point are a little better than the
#   best one weight for a grid, in both cases: {glue:text}`few.variance:.2f`
#   and {glue:text}`many.variance:.2f` mm, by factors of
#   {glue:text}`few.gain` and {glue:text}`many.gain` within the same trials.
# - Further grids are worth their trouble. Rays from the linear stage's grids
#   alone are {glue:text}`many.linear grids alone:.2f` mm off. All these are
#   medians with noise in the image.
# - All rays meet a plane by one transpose and one product, as the thesis
#   says.

# %% [markdown]
# ## What the thesis claims
#
# - A pixel's ray joins the centre to the weighted centroid of its points.
#   The grids of the linear stage are weighted more heavily.
# - With the Plücker matrices $M_i$ of all rays side by side,
#   $M = [M_1\; M_2\; \dots\; M_n]$, a plane $\mathbf{S}$ is met by all of
#   them at once.

# %% [markdown]
# ## Model
#
# **Weights.** The point on grid $j$ lies at the distance $l_j$ from the
# centre and has an error $e_j$ across the ray. The centroid with weights
# $w_j$ turns the ray by the angle
#
# $$\frac{\sum_j w_j e_j}{\sum_j w_j l_j} .$$
#
# If the errors are independent, with variances $v_j$, this angle scatters
# least for
#
# $$w_j = l_j / v_j .$$
#
# Three cases follow. Noise of the image moves a point the more the farther
# away it is: $v_j \propto l_j^2$, so near points count more. Noise in mm
# has one $v$ for all, so far points count more: they give the better lever.
# And a grid whose pose is an estimate adds what the error of the pose does
# to its points, so it counts less. The last is the thesis's reason.

# %% tags=["active-ipynb"]
# show_code(centroid_directions, centroid_weights)

# %% [markdown]
# **Rays and planes.** The Plücker matrix of the line through $\mathbf{A}$
# and $\mathbf{B}$ is $M = \mathbf{A}\mathbf{B}^\top -
# \mathbf{B}\mathbf{A}^\top$ (2.11). It meets the plane in $M\mathbf{S}$.
# The matrix is skew-symmetric, $M^\top = -M$, so that for all rays
#
# $$\mathbf{X} \simeq -M^\top \mathbf{S} . \tag{4.15}$$
#
# In memory that is no transposition at all: $-M^\top$ is the matrices
# stacked upon each other, as they lie there.

# %% tags=["active-ipynb"]
# show_code(intersect_lines_plane)

# %% [markdown]
# ## Experiment
#
# The camera is that of [section 4.1.5](s1_5_simulated.ipynb), before six
# grids. Three of them are calibrated. The poses of the others are found
# from the rays that this gives: from a handful of rays, or from all. Then
# all six make the rays, once for every weight, and the rays are compared
# with the true points.

# %% tags=["active-ipynb"]
# show_code(weights_trial)


# %%
@experiment("ext_ray_weights_trials", artefact="ext_ray_weights")
def weights_of_rays(effort):
    """Rays by centroids, with weights."""
    cases = crossed(domain=NOISE)
    return Plan(weights_trial, cases, {"quick": 3, "full": 60}[effort], SETTINGS)


# %% [markdown]
# ## Reading and limits
#
# **How much weight?** The thesis does not say. Its further grids are active
# grids, which thousands of rays see, and there equal weights are the best of
# those tried. The
# errors of poses from so many rays are small beside the noise of a single
# point. With a chessboard and a few corners it is another matter.
#
# **The poses here** are the best fit to the rays, started at the true pose,
# so that nothing but noise makes their errors. A pose that is wrong for
# another reason, such as a grid that was moved while it was photographed,
# deserves less weight than its covariance says.
#
# **Neighbours.** The error of a pose moves all points of its grid together.
# The weights treat each ray alone, for which it makes no difference. An
# adjustment of all poses and rays together does not need them, and is
# better: see [section 4.1.4](s1_4_bundle_adjustment.ipynb).
#
# **Matrices or directions?** A central camera's table needs the centre once
# and a direction per pixel. The matrices are built from them when they are
# wanted (`GeneralCamera.pluecker`).

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
# **1.** Noise comes from the image. A ray meets one grid 300 mm and another
# 600 mm from the centre. How many times the weight of the far point has the
# near one at best?

# %% tags=["active-ipynb"]
# check(None, **image_noise_task())

# %% [markdown]
# **2.** Two points lie at the same distance. Each has noise of 0.5 mm. The
# second one's grid has a pose that puts it off by another 1 mm (SD). How
# many times the weight of the second has the first at best?

# %% tags=["active-ipynb"]
# check(None, **pose_task())
