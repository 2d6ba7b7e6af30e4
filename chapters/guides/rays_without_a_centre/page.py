# %% [markdown]
# # Rays without a centre: what solvers of motion ask for
#
# **Question.** A camera that looks into a bent mirror is calibrated, and
# takes two pictures. How do its rays go into a solver of motion, and what
# can that find? Rays that do not meet in one point even tell how *long* the
# motion was. How well, is known before any is made.

# %%
from chapters.guides.rays_without_a_centre.results import facts
from chapters.guides.rays_without_a_centre.trials import (
    DEFLECTIONS_MM,
    NOISE_PX,
    PAIRS,
    RIG,
    STEP_MM,
    WRONG,
    motion_of_pixels,
    products,
    step_trial,
)
from repro.page.reader import open_results, show, show_code, show_table, value
from repro.run.experiment import experiment
from repro.run.outcomes import Plan, crossed

# %%
TRIALS = {"quick": 1, "full": 40}


@experiment(
    "ext_ray_motion_steps",
    artefact="ext_ray_motion",
    inputs=("data/rigs/flexible-mirror-a.yaml",),
)
def ext_ray_motion_steps(effort):
    """A step aside before points in the mirror, bent by more and more."""
    settings = {"rig": RIG, "step_mm": STEP_MM, "noise_px": NOISE_PX}
    settings |= {"pairs": PAIRS, "wrong": WRONG}
    conditions = crossed(deflection_mm=DEFLECTIONS_MM)
    return Plan(step_trial, conditions, TRIALS[effort], settings)


# %% tags=["active-ipynb", "remove-input"]
# for name, x in facts(open_results("ext_ray_motion_steps")).items(): value(name, x)

# %% tags=["active-ipynb", "remove-input"]
# for name, x in open_results("ext_ray_motion_steps").settings.items(): value(name, x)

# %% tags=["active-ipynb"]
# show("ext_ray_motion_told")

# %% [markdown]
# ## Findings
#
# - **The more the mirror bends, the better the length is told.** At
#   {glue:text}`deflection.least` mm of deflection the rays pass
#   {glue:text}`spread.least` mm from one point, and the standard deviation
#   of the length of a {glue:text}`step_mm:.0f` mm step is
#   {glue:text}`told.least` % of it. At {glue:text}`deflection.most` mm they
#   pass {glue:text}`spread.most` mm from it, and it is
#   {glue:text}`told.most` %.
# - **Where it is hardly told, one does better to give it.** Rotation and
#   length err together: with the length given, the median rotation at the
#   largest deflection is off by {glue:text}`turn.held`° instead of
#   {glue:text}`turn.robust`°.
# - **A linear solution is a start, not an answer**, where rays come near to
#   one point: it is off by {glue:text}`turn.linear`°.
# - **Wrong pairs are left out**: {glue:text}`kept` % of the right pairs are
#   kept, and {glue:text}`let_in` % of the wrong ones let in. These happen to
#   agree with the motion.

# %% tags=["active-ipynb"]
# show_table("ext_ray_motion", digits=2)

# %% [markdown]
# ## Six numbers for a ray
#
# A ray through $\mathbf{o}$ along the unit vector $\mathbf{d}$ is a line, and
# the same line whatever point of it is called $\mathbf{o}$. Its Plücker
# coordinates are the direction and the **moment** $\mathbf{o} \times
# \mathbf{d}$, which is the same for every such point. Two orders are in use:
# this report follows the thesis, $\mathbf{L} = (\mathbf{d};\;
# -\mathbf{o} \times \mathbf{d})$, and most programs have $(\mathbf{d};\;
# \mathbf{o} \times \mathbf{d})$. [Conventions and
# notation](../conventions.md#plucker) tells more.
#
# Let $\mathbf{X}_2 = R\,\mathbf{X}_1 + \mathbf{t}$ take points from the first
# view to the second, and $E = [\mathbf{t}]_\times R$. A point that both see
# lies on both lines, and lines that meet satisfy
#
# $$
# \mathbf{L}_2^T \begin{bmatrix} E & -R \\ -R & 0 \end{bmatrix} \mathbf{L}_1 = 0 .
# \tag{5.30}
# $$
#
# For a camera with a centre at the origin the moments vanish, and $\mathbf{d}_2^T
# E\, \mathbf{d}_1 = 0$ is left, which any length of $\mathbf{t}$ satisfies.
# With moments it does not: **skew rays carry the scale.** In the usual order both
# minus signs are plus. Mixed, the equation is wrong by little enough to go
# unnoticed: here the products are {glue:text}`product` mm at most for rays
# without noise, and {glue:text}`mixed` mm mixed.

# %% tags=["active-ipynb"]
# show_code(products)

# %% [markdown]
# ## From matched pixels to a motion
#
# `rays_of_pixels` asks the camera for the rays, and for what
# {glue:text}`noise_px` px of noise do to each: before a bent mirror a ray
# turns about a point of the caustic behind it. The threshold then is a
# number of standard deviations, whatever the camera. The motion is found
# from samples of eight pairs, refined on all that agree with it, and
# adjusted once more together with the points.

# %% tags=["active-ipynb"]
# show_code(motion_of_pixels)

# %% [markdown]
# What it finds says how well: `found.scale_sd` is the standard deviation of
# the length as a share of it, and `found.scale_told` whether that is below a
# third. Before any picture is taken, `motion_information(T_2_1, rays_1,
# rays_2)` says the same of a motion that is planned, and its `eigenvalues()`
# which of the six numbers is told least. Three ways out where it is the
# length:
#
# - give it: `generalised_pose_ransac(..., length=25.0)`, the way of the
#   rays' centre in mm; in the bundle, `held=1` keeps the one of the start;
# - bend the mirror more, or go farther;
# - take more pictures: the bundle of several views shares one scale.

# %% [markdown]
# ## To other programs
#
# Any solver that takes a centre for each ray takes these rays: the origin
# of the ray is its centre, in the frame of the camera.
#
# **PoseLib** has a six-point solver for them. It gives several motions, each
# with $\mathbf{X}_2 = R\,\mathbf{X}_1 + \mathbf{t}$ as here:
#
# ```python
# import poselib
#
# six = rng.choice(len(rays_1.origins), 6, replace=False)
# motions = poselib.gen_relpose_6pt(
#     list(rays_1.origins[six]), list(rays_1.directions[six]),
#     list(rays_2.origins[six]), list(rays_2.directions[six]),
# )
# for motion in motions:
#     print(motion.R, motion.t)
# ```
#
# Its `estimate_generalized_relative_pose` is for rigs: it wants five pairs
# that share their two centres, and version 2.0.5 does not come back where
# every ray has a centre of its own. Put the six-point solver into a sampling
# loop of your own; `make bench` does so, and sets the times and errors of
# both side by side.
#
# **Solvers that take Plücker vectors** mostly want the usual order:
#
# ```python
# from raxel.geometry.line_motion import other_order, pluecker_of_rays
#
# lines_1 = other_order(pluecker_of_rays(rays_1.origins, rays_1.directions))
# ```
#
# **Before you trust one**, hand it rays without noise, of a motion that you
# know, and look whether (5.30) holds: that finds a wrong order, an inverted
# pose and pixels that start at one, all at once.
#
# ## The scene of this page
#
# {glue:text}`pairs` points, {glue:text}`step_mm:.0f` mm aside, the camera of the
# rig {glue:text}`rig` with its mirror bent; three in ten pairs are wrong. The
# camera is the true one: errors of a calibration come on top.

# %% tags=["active-ipynb"]
# show_code(step_trial)
