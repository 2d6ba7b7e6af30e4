# %% [markdown]
# # 4.1.3 Ray directions from several grids
#
# **Question.** A pixel views a point on each of several grids, and no line through the
# centre meets all of them exactly. The thesis joins the centre to the weighted centroid
# of the points, and gives more weight to the grids of the linear stage. Is that right,
# and how large should the weight be?

# %%
from chapters.ch04_central_generic.s1_3_rays.exercises import (
    image_noise_task,
    pose_task,
)
from chapters.ch04_central_generic.s1_3_rays.experiment import NOISE, weights_trial
from chapters.ch04_central_generic.s1_3_rays.report import name_values
from chapters.shared.central import SETTINGS
from raxel.calibration import centroid_directions, centroid_weights
from raxel.geometry import intersect_lines_plane
from repro.page import check, compared, open_results, show, show_code
from repro.run import Plan, crossed, experiment

# %% tags=["active-ipynb"]
# show("ext_ray_weights")

# %% tags=["active-ipynb"]
# name_values(open_results)

# %% [markdown]
# **Findings.**
#
# 1. **Grids with poses from few rays deserve less weight.** With poses from 6 rays, the
#    best weight tried for the linear grids is {glue:text}`factor.few:g`. Equal weights
#    increase the error by a factor of {glue:text}`few.one`.
# 2. **Grids with poses from many rays deserve equal weight.** With 999 rays the best
#    weight tried is {glue:text}`factor.many:g`. Pose errors are then small compared
#    with the noise.
# 3. **Variance-based weights are slightly better in both cases.** With 999 rays the
#    best fixed weight has {glue:text}`many.gain` times their error (medians, image
#    noise).
# 4. **One transpose and one product intersect all rays with a plane.** The printed
#    formula (4.15) is exact.

# %% [markdown]
# | question or quantity | thesis | here |
# |---|---|---|
# | weight of the linear grids | higher, no number | higher only if rays are few |
# | reason | the other poses are less certain | holds for few rays |
# | grids used for the rays | all | all: better than the linear grids alone |
# | all rays against one plane | $-M^\top \mathbf{S}$ | exact |

# %% [markdown]
# ## Terms
#
# - *Linear grids*: the three grids of the linear stage
#   ([4.1.2](s1_2_linear_stage.ipynb)). *Further grids*: grids whose poses come from the
#   calibrated rays.
# - *Weight*: weight of the linear grids in the centroid. That of the further grids is
#   1.
# - *Variance-based weights*: weights from the predicted variance of every point.
# - $l_j$, $e_j$, $v_j$, $w_j$: distance from the centre, error across the ray, its
#   variance and the weight of the point on grid $j$.
# - *Plücker matrix* $M$: skew-symmetric $4 \times 4$ matrix of a line. $\mathbf{S}$:
#   plane. $\mathbf{X}$: point of intersection.

# %% [markdown]
# ## What the thesis claims
#
# - A ray joins the centre to the weighted centroid of its points. The linear grids have
#   more weight, because the other poses are estimates from the rays. The thesis states
#   no number.
# - With $M = [M_1\; M_2\; \dots\; M_n]$ for $n$ rays, one product intersects all of
#   them with a plane.

# %% [markdown]
# ## Model
#
# **Weights.** The weighted centroid rotates the ray by the angle
#
# $$\frac{\sum_j w_j e_j}{\sum_j w_j l_j} .$$
#
# For independent errors its variance is smallest for
#
# $$w_j = l_j / v_j .$$
#
# Three cases follow:
#
# - *Image noise*: $v_j \propto l_j^2$, so near points count more.
# - *Noise in mm*: $v_j$ is constant, so far points count more, as they have the longer
#   lever.
# - *Estimated poses*: the pose error adds to $v_j$, so such a grid counts less. This is
#   the thesis's reason.

# %% tags=["active-ipynb"]
# show_code(centroid_directions, centroid_weights)

# %% [markdown]
# **Rays and planes.** The Plücker matrix of the line through $\mathbf{A}$ and
# $\mathbf{B}$ is $M = \mathbf{A}\mathbf{B}^\top - \mathbf{B}\mathbf{A}^\top$ (2.11),
# and the line meets the plane in $M\mathbf{S}$. The matrix is skew-symmetric,
# $M^\top = -M$, so that for all rays
#
# $$\mathbf{X} \simeq -M^\top \mathbf{S} . \tag{4.15}$$
#
# The code needs no transposition: $-M^\top$ is the stack of the matrices as stored in
# memory.

# %% tags=["active-ipynb"]
# show_code(intersect_lines_plane)

# %% [markdown]
# ## Experiment
#
# The camera of [section 4.1.5](s1_5_simulated.ipynb) views six grids. Three of them are
# the linear grids, calibrated by CGSP and the consistent adjustment of 4.1.4. The poses
# of the others are fitted to 6, 40 or all 999 of the resulting rays. All six grids then
# define the rays, once for every weight. The error is the distance of the rays from the
# true points.

# %% tags=["active-ipynb"]
# show_code(weights_trial)


# %%
@experiment("ext_ray_weights_trials", artefact="ext_ray_weights")
def weights_of_rays(effort):
    """Rays by centroids, with weights."""
    cases = crossed(domain=NOISE)
    return Plan(weights_trial, cases, {"quick": 3, "full": 60}[effort], SETTINGS)


# %% [markdown]
# ## Discussion
#
# - **Size of the weight.** The further grids of the thesis are active grids, viewed by
#   thousands of rays. Equal weights are the best ones tried for such grids. A
#   chessboard with few corners is different.
# - **Further grids.** They improve the rays: the linear grids alone give
#   {glue:text}`many.linear grids alone:.2f` mm instead of
#   {glue:text}`many.variance:.2f` mm.
# - **Pose errors.** Here they result from noise alone, since each fit starts at the
#   true pose. A pose with another error, such as a grid that moved, deserves less
#   weight than its covariance indicates.
# - **Correlation.** A pose error moves all points of a grid together. The weights treat
#   each ray alone, so this does not matter for them. An adjustment of all poses and
#   rays needs no such weights and is better ([4.1.4](s1_4_bundle_adjustment.ipynb)).
#
# ## Summary
#
# The higher weight of the linear grids is right if the other poses come from few rays.
# With all rays of an active grid, equal weights are the best of those tried. Weights
# from the variance of every point need no choice and are slightly better in both cases.
#
# ## Compared with the published numbers

# %% tags=["active-ipynb"]
# compared()

# %% [markdown]
# ## Try it yourself
#
# Open this page as a notebook (`make lab`) and run all cells. Then put an answer in
# place of `None`, and run that cell again.
#
# **1.** The noise is image noise. A ray meets one grid 300 mm and another 600 mm from
# the centre. What is the best ratio of the near point's weight to the far point's
# weight?

# %% tags=["active-ipynb"]
# check(None, **image_noise_task())

# %% [markdown]
# **2.** Two points have the same distance, and each has noise of 0.5 mm. The pose error
# of the second grid adds 1 mm (SD). What is the best ratio of the first weight to the
# second?

# %% tags=["active-ipynb"]
# check(None, **pose_task())
